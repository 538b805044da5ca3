# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint the air: with the mouse or a pen in a 3D view, or, in a script, through given places."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, FloatVectorProperty
from bpy.types import Context, Event, Operator, PropertyGroup

from ..air_painting import AirPainting, active_painting, begin_painting, end_painting
from ..air_strokes import BoxStroke
from ..availability import why_no_render
from ..painted_air import edited_box, why_not_editable
from ..properties.air_brush import VALUED_MODES, VOLUMES

if TYPE_CHECKING:
    from bpy.types import Area, Region

#: Handed on between strokes: navigation, the view's own keys, undo, and what the window itself needs.
_HANDED_ON = frozenset({"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "HOME", "ACCENT_GRAVE", "N", "T", "Z"})
_HANDED_ON_KINDS = ("NUMPAD_", "NDOF_", "TRACKPAD", "TIMER", "MOUSEROTATE", "MOUSESMARTZOOM", "WINDOW_")
_MOVES = frozenset({"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"})  # most of a stroke comes as the latter
_ENDS = frozenset({"ESC", "RIGHTMOUSE", "RET", "NUMPAD_ENTER"})
_SLIDES = {"UP_ARROW": 1, "DOWN_ARROW": -1, "PAGE_UP": 5, "PAGE_DOWN": -5}
_WHEEL_SLIDES = {"WHEELUPMOUSE": 1, "WHEELDOWNMOUSE": -1}
_SIZES = {"LEFT_BRACKET": 0.8, "RIGHT_BRACKET": 1.25}
#: What F changes, by the key that is held with it: shift, ctrl, alt.
_DIALS = {
    (False, False, False): "radius_m",
    (True, False, False): "opacity",
    (False, True, False): "hardness",
    (False, False, True): "depth",
}
_HELP = (
    "Drag: paint  |  Ctrl: erase  |  Shift: smooth  |  F: size  |  Shift F: opacity  |  Ctrl F: hardness  |  "
    "Alt F: depth  |  Ctrl Wheel, Up, Down: slide the plane  |  S: to the surface under the mouse  |  Esc: end"
)


def why_no_paint(context: Context) -> str | None:
    """What a button says that paints; None: it may."""
    return why_no_render() or why_not_editable(edited_box(context))


class PaintOperator:
    """Works on the box that is painted in."""

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := why_no_paint(context)) is not None:
            cls.poll_message_set(reason)
            return False
        return True


class TyndallAirDab(PropertyGroup):
    location: FloatVectorProperty(name="Location", description="In the world", subtype="XYZ", unit="LENGTH", size=3)
    pressure: FloatProperty(name="Pressure", description="Of the pen", min=0.0, max=1.0, default=1.0)


class TYNDALL_OT_paint_air_stroke(PaintOperator, Operator):
    """Paint one stroke of the scene's brush into the air, straight from place to place."""

    bl_idname = "tyndall.paint_air_stroke"
    bl_label = "Paint Stroke"
    bl_options = {"UNDO", "INTERNAL"}

    dabs: CollectionProperty(
        name="Dabs", description="Places that the stroke goes through", type=TyndallAirDab, options={"SKIP_SAVE"}
    )
    normal: FloatVectorProperty(
        name="Normal",
        description="Of the plane that is painted on: the brush has its depth along it",
        subtype="XYZ",
        size=3,
        default=(0.0, 0.0, 1.0),
        options={"SKIP_SAVE"},
    )

    def execute(self, context: Context) -> set[str]:
        box = edited_box(context)
        if not any(self.normal):
            self.report({"ERROR"}, "The normal of the plane is 0")
            return {"CANCELLED"}
        try:
            stroke = BoxStroke(box, context.scene.tyndall.air_brush, self.normal)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for dab in self.dabs:
            stroke.move_to(dab.location, dab.pressure)
        if not stroke.keep(box):
            self.report({"WARNING"}, f'The stroke is outside of "{box.name}": nothing is painted')
            return {"CANCELLED"}
        return {"FINISHED"}


class TYNDALL_OT_paint_air(Operator):
    """Paint the air in the 3D view, on a plane that faces you and slides through the box."""

    bl_idname = "tyndall.paint_air"
    bl_label = "Paint the Air"
    # Each stroke is a step of undo, and the tool none.
    bl_options = set()

    begins_stroke: BoolProperty(
        name="Begin a Stroke",
        description="The press that calls it paints already",
        default=False,
        options={"SKIP_SAVE", "HIDDEN"},
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if active_painting() is not None:
            cls.poll_message_set("Esc in the 3D view ends the painting that goes on")
        elif (reason := why_no_paint(context)) is not None:
            cls.poll_message_set(reason)
        else:
            return True
        return False

    def execute(self, context: Context) -> set[str]:
        self.report({"ERROR"}, "Painting needs a mouse in a 3D view: in a script, call tyndall.paint_air_stroke")
        return {"CANCELLED"}

    def invoke(self, context: Context, event: Event) -> set[str]:
        found = _view_for(context, event)
        if found is None:
            self.report({"ERROR"}, "Open a 3D view to paint in")
            return {"CANCELLED"}
        painting = begin_painting(context, *found)
        painting.box_in(context)
        self._tool = _tool_name(context)
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(_HELP)
        if self.begins_stroke:
            self._wait(context, event, painting, *found)
        self._show(context, painting, found[0])
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        painting = active_painting()
        found = painting.region_in(context) if painting is not None else None
        if painting is None or found is None or _tool_name(context) != self._tool:
            return self._end(context)
        area, region = found
        if painting.box_in(context) is None:
            self.report({"WARNING"}, f"The painting has ended. {why_not_editable(edited_box(context))}")
            return self._end(context)
        painting.note_brush(context)
        is_busy = painting.stroke is not None or painting.dial is not None
        if not is_busy and not _is_over(area, region, event):
            return {"PASS_THROUGH"}
        painting.mouse_px = event.mouse_x - region.x, event.mouse_y - region.y
        if painting.stroke is None:
            painting.mode = "ERASE" if event.ctrl else ("SMOOTH" if event.shift else "")
        if painting.dial is not None:
            result = self._turn(context, event, painting)
        elif painting.stroke is not None:
            result = self._go_on(context, event, painting, region)
        elif event.type in _ENDS and event.value == "PRESS":
            return self._end(context)
        else:
            result = self._wait(context, event, painting, area, region)
        self._show(context, painting, area)
        return result

    def cancel(self, context: Context) -> None:
        self._end(context)

    def _end(self, context: Context) -> set[str]:
        painting = active_painting()
        found = painting.region_in(context) if painting is not None else None
        end_painting()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        if found is not None:
            found[0].header_text_set(None)
            found[0].tag_redraw()
        return {"FINISHED"}

    def _wait(self, context: Context, event: Event, painting: AirPainting, area: Area, region: Region) -> set[str]:
        """Between strokes."""
        brush = context.scene.tyndall.air_brush
        slides = _SLIDES | (_WHEEL_SLIDES if event.ctrl else {})
        if event.type in _MOVES:
            return {"RUNNING_MODAL"}
        if event.value != "PRESS":
            return {"PASS_THROUGH"}
        painting.remark = ""
        if event.type == "LEFTMOUSE":
            painting.begin_stroke(context, region, event.pressure)
        elif event.type == "F":
            name = _DIALS.get((event.shift, event.ctrl, event.alt))
            if name is not None:
                painting.begin_dial(brush, region, name)
        elif event.type in slides:
            painting.plane.slide(region.data, slides[event.type])
        elif event.type in _SIZES:
            brush.radius_m *= _SIZES[event.type]
        elif event.type == "S" and not event.ctrl:
            _slide_to_surface(context, event, painting, region)
        elif event.type in _HANDED_ON or event.type.startswith(_HANDED_ON_KINDS):
            return {"PASS_THROUGH"}
        return {"RUNNING_MODAL"}

    def _go_on(self, context: Context, event: Event, painting: AirPainting, region: Region) -> set[str]:
        """Within a stroke."""
        if event.type in _MOVES:
            painting.go_on(region, event.pressure)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            if painting.end_stroke(context, keeps=True):
                bpy.ops.ed.undo_push(message=self.bl_label)
        elif event.type in _ENDS and event.value == "PRESS":
            painting.end_stroke(context, keeps=False)
        return {"RUNNING_MODAL"}

    def _turn(self, context: Context, event: Event, painting: AirPainting) -> set[str]:
        """While F changes a setting."""
        brush = context.scene.tyndall.air_brush
        if event.type in _MOVES:
            painting.turn_dial(brush)
        elif event.value == "PRESS" and event.type in {"LEFTMOUSE", "RET", "NUMPAD_ENTER", "F"}:
            painting.end_dial(brush, keeps=True)
        elif event.value == "PRESS" and event.type in {"RIGHTMOUSE", "ESC"}:
            painting.end_dial(brush, keeps=False)
        return {"RUNNING_MODAL"}

    def _show(self, context: Context, painting: AirPainting, area: Area) -> None:
        """Say in the header what is painted and with what, or what there is to say about the last stroke."""
        area.header_text_set(painting.remark or _header(context, painting))
        area.tag_redraw()


def _tool_name(context: Context) -> str:
    """Of the toolbar: who chooses another one wants to paint no more."""
    tool = context.workspace.tools.from_space_view3d_mode(context.mode, create=False)
    return tool.idname if tool is not None else ""


def _header(context: Context, painting: AirPainting) -> str:
    brush = context.scene.tyndall.air_brush
    label = next(name for key, name, *_rest in VOLUMES if key == brush.volume)
    mode = painting.mode or brush.mode
    value = f" {getattr(brush, brush.volume.lower()):.3g}" if mode in VALUED_MODES else ""
    return (
        f"{mode.title()} {label}{value}    Size {brush.radius_m:.3g} m    Depth {brush.depth:.3g}    "
        f"Opacity {brush.opacity:.2f}    Hardness {brush.hardness:.2f}"
    )


def _view_for(context: Context, event: Event) -> tuple[Area, Region] | None:
    """The 3D view that the tool was called in; else the largest of the window."""
    areas = [area for area in context.screen.areas if area.type == "VIEW_3D"]
    if context.area in areas:
        areas = [context.area]
    if not areas:
        return None
    area = max(areas, key=lambda area: area.width * area.height)
    regions = [region for region in area.regions if region.type == "WINDOW"]
    under = [region for region in regions if _holds(region, event)]
    return area, (under or regions)[0]


def _is_over(area: Area, region: Region, event: Event) -> bool:
    """Whether the mouse is over the view itself, and not over a sidebar or a header that lies above it."""
    others = (other for other in area.regions if other.type != "WINDOW" and min(other.width, other.height) > 1)
    return _holds(region, event) and not any(_holds(other, event) for other in others)


def _holds(region: Region, event: Event) -> bool:
    x, y = event.mouse_x - region.x, event.mouse_y - region.y
    return 0 <= x < region.width and 0 <= y < region.height


def _slide_to_surface(context: Context, event: Event, painting: AirPainting, region: Region) -> None:
    from ..engine.view_rays import first_hit, place_under

    depsgraph = context.evaluated_depsgraph_get()
    place = place_under(context, depsgraph, event.mouse_x, event.mouse_y)
    hit = first_hit(depsgraph, place) if place is not None else None
    if hit is None:
        painting.remark = "There is no surface under the mouse"
        return
    painting.plane.point = hit.world_point
    painting.plane.keep_in(region.data)


CLASSES = (TyndallAirDab, TYNDALL_OT_paint_air_stroke, TYNDALL_OT_paint_air)
