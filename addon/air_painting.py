# SPDX-License-Identifier: GPL-3.0-or-later
"""What goes on while an artist paints the air in a 3D view: the plane, the stroke, and the setting that F changes.

Areas and regions are looked up anew for each event: Blender may have closed them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import dist
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent
from mathutils import Matrix, Vector

from .air_plane import AirPlane, axes_of, normal_of, ray_under
from .air_strokes import BoxStroke
from .granted_writes import write
from .painted_air import edited_box, forget, why_not_editable, world_from_unit

if TYPE_CHECKING:
    from bpy.types import Area, Context, Object, Region

    from .properties.air_brush import TyndallAirBrush

#: Of a ring that stands for a value of 1.
DIAL_PX = 100.0


@dataclass(frozen=True, kw_only=True)
class Dial:
    """A setting of the brush that follows the mouse, as F does it in Blender: by its distance from a centre."""

    name: str
    centre_px: tuple[float, float]
    value_per_px: float
    before: float  #: What Esc brings back.


class AirPainting:
    """One at a time, in one 3D view."""

    def __init__(self, context: Context, area: Area, region: Region) -> None:
        self._area_address = area.as_pointer()
        self._region_address = region.as_pointer()
        self._box_name = ""
        self.plane: AirPlane | None = None  #: Of the box that is painted in.
        self.stroke: BoxStroke | None = None
        self.stroke_count = 0  #: Changes with each move of a stroke, for who draws it.
        self.dial: Dial | None = None
        self.mouse_px: tuple[float, float] = (region.width / 2.0, region.height / 2.0)
        self.mode = ""  #: What a held key makes of the brush.
        self.remark = ""  #: What there is to say about the last stroke.
        self._brush: dict[str, Any] = {}
        self.note_brush(context)

    def region_in(self, context: Context) -> tuple[Area, Region] | None:
        """Where it goes on; None: that has been closed."""
        for area in context.screen.areas if context.screen is not None else ():
            if area.as_pointer() == self._area_address and area.type == "VIEW_3D":
                for region in area.regions:
                    if region.as_pointer() == self._region_address and region.data is not None:
                        return area, region
        return None

    def box_in(self, context: Context) -> Object | None:
        """What is painted in, with the plane in it; None: it is gone, or cannot be painted in any more."""
        box = edited_box(context)
        if why_not_editable(box) is not None:
            return None
        matrix = Matrix(world_from_unit(box))
        if self.plane is None or box.name != self._box_name:
            self.plane, self._box_name = AirPlane(matrix), box.name
        self.plane.follow(matrix)
        return box

    def place_under(self, region: Region, mouse_px: tuple[float, float]) -> Vector | None:
        """On the plane, in the world; None: the view does not see the plane there."""
        if self.plane is None or not self.plane.keep_in(region.data):
            return None
        return self.plane.meet(region.data, ray_under(region, *mouse_px))

    def begin_stroke(self, context: Context, region: Region, pressure: float) -> None:
        box = self.box_in(context)
        try:
            self.stroke = BoxStroke(box, context.scene.tyndall.air_brush, normal_of(region.data), self.mode)
        except ValueError as error:
            self.remark = str(error)
            return
        self.go_on(region, pressure)

    def go_on(self, region: Region, pressure: float) -> None:
        place = self.place_under(region, self.mouse_px)
        if self.stroke is not None and place is not None:
            self.stroke.move_to(place, pressure)
            self.stroke_count += 1

    def end_stroke(self, context: Context, *, keeps: bool) -> bool:
        """Whether anything was painted."""
        stroke, self.stroke = self.stroke, None
        box = self.box_in(context)
        self.stroke_count += 1
        if stroke is None or box is None or not keeps:
            return False
        if not stroke.keep(box):
            self.remark = f'The stroke is outside of "{box.name}": nothing is painted'
            return False
        return True

    def begin_dial(self, brush: TyndallAirBrush, region: Region, name: str) -> None:
        radius_px = self.radius_px(brush, region)
        scales = {"radius_m": brush.radius_m / radius_px, "depth": 1.0 / radius_px}
        value_per_px = scales.get(name, 1.0 / DIAL_PX)
        value = getattr(brush, name)
        x, y = self.mouse_px
        self.dial = Dial(name=name, centre_px=(x - value / value_per_px, y), value_per_px=value_per_px, before=value)

    def turn_dial(self, brush: TyndallAirBrush) -> None:
        if self.dial is not None:
            setattr(brush, self.dial.name, dist(self.mouse_px, self.dial.centre_px) * self.dial.value_per_px)

    def end_dial(self, brush: TyndallAirBrush, *, keeps: bool) -> None:
        if self.dial is not None and not keeps:
            setattr(brush, self.dial.name, self.dial.before)
        self.dial = None

    @property
    def centre_px(self) -> tuple[float, float]:
        """Of the brush: it stands still while a setting follows the mouse."""
        return self.dial.centre_px if self.dial is not None else self.mouse_px

    def radius_px(self, brush: TyndallAirBrush, region: Region) -> float:
        """Of the brush where it is on the plane, at least a pixel; DIAL_PX where the plane is not seen."""
        from bpy_extras.view3d_utils import location_3d_to_region_2d

        centre_px = self.centre_px
        place = self.place_under(region, centre_px)
        if place is None:
            return DIAL_PX
        rim = location_3d_to_region_2d(region, region.data, place + axes_of(region.data)[0] * brush.radius_m)
        return max(1.0, dist(rim, centre_px)) if rim is not None else DIAL_PX

    def note_brush(self, context: Context) -> None:
        """Remember the brush: undo brings back the scene's of that time, which is not what undoing a stroke means."""
        brush = context.scene.tyndall.air_brush
        self._brush = {
            name: getattr(brush, name)
            for name, rna in brush.bl_rna.properties.items()
            if not rna.is_readonly and name != "name"
        }

    def restore_brush(self, context: Context) -> None:
        for name, value in self._brush.items():
            setattr(context.scene.tyndall.air_brush, name, value)


_active: AirPainting | None = None


def active_painting() -> AirPainting | None:
    """What goes on now."""
    return _active


def begin_painting(context: Context, area: Area, region: Region) -> AirPainting:
    """Make it the one that is drawn."""
    global _active  # noqa: PLW0603  one mouse, one painting
    _active = AirPainting(context, area, region)
    return _active


def end_painting() -> None:
    """Draw it no more."""
    global _active  # noqa: PLW0603
    _active = None


@persistent
def _keep_brush(*_: object) -> None:
    if _active is not None:
        write(partial(_active.restore_brush, bpy.context))


@persistent
def _end_with_file(*_: object) -> None:
    end_painting()
    forget()


_HANDLERS = (("undo_post", _keep_brush), ("redo_post", _keep_brush), ("load_pre", _end_with_file))


def register() -> None:
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).append(handler)


def unregister() -> None:
    end_painting()
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).remove(handler)
