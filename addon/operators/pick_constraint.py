# SPDX-License-Identifier: GPL-3.0-or-later
"""Click on the picture, and the shafts there get a colour: a constraint where that ray is in the transfer function."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy
from bpy.props import FloatVectorProperty, StringProperty
from bpy.types import Context, Event, Operator

from ..availability import why_no_render
from ..frame_size import frame_size_px
from ..function_trees import edited_function
from ..surface_points import anchor_at, anchor_in
from .transfer_functions import ConstraintOperator

if TYPE_CHECKING:
    from bpy.types import Depsgraph

    from ..engine.view_rays import Hit, Place
    from ..properties.transfer_layers import TyndallTransferConstraint

#: Handed on while a click is waited for, so that the view can be moved.
_NAVIGATION = frozenset(
    {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "NDOF_MOTION"}
)
#: A click shall not wait for more than the eye tells apart.
_ERROR_TARGET = 0.01
_LIGHT_SAMPLES = 16
_HELP = "Click: set a colour there   |   Shift-click: and go on   |   Esc: end"


class TYNDALL_OT_pick_constraint(ConstraintOperator, Operator):
    """Click on a 3D view or on the render: the shafts that are like the one there get the new constraint's colour.

    Where the view meets a surface the constraint follows that, as it moves
    """

    bl_idname = "tyndall.pick_constraint"
    bl_label = "Pick on the Picture"
    # What is picked in a view cannot be redone with other settings: not registered for that.
    bl_options = {"UNDO"}  # type: ignore[assignment]
    needs_item = False

    place: FloatVectorProperty(
        name="Place",
        description="In a script: of the final frame, from 0 at its left and bottom to 1 at its right and top",
        size=2,
        min=0.0,
        max=1.0,
        default=(0.5, 0.5),
        options={"SKIP_SAVE"},
    )
    object_name: StringProperty(
        name="Object",
        description="Follow this object's surface, whatever is in front of it; empty: the first that is met",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        return why_no_render() or super().why_not(context)

    def execute(self, context: Context) -> set[str]:
        from ..engine.view_rays import place_in_frame

        depsgraph = context.evaluated_depsgraph_get()
        width_px, height_px = frame_size_px(context.scene)
        try:
            place = place_in_frame(depsgraph, (self.place[0] * width_px, self.place[1] * height_px))
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"} if self._pick(context, depsgraph, place) else {"CANCELLED"}

    def invoke(self, context: Context, event: Event) -> set[str]:
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set(_HELP)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type in _NAVIGATION:
            return {"PASS_THROUGH"}
        if event.type in {"ESC", "RIGHTMOUSE"}:
            return self._end(context, {"CANCELLED"})  # each pick before has its own step of undo
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"RUNNING_MODAL"}
        if not self._pick_under_mouse(context, event):
            return {"RUNNING_MODAL"}
        if not event.shift:
            return self._end(context, {"FINISHED"})
        bpy.ops.ed.undo_push(message=self.bl_label)
        return {"RUNNING_MODAL"}

    def _end(self, context: Context, result: set[str]) -> set[str]:
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
        return result

    def _pick_under_mouse(self, context: Context, event: Event) -> bool:
        from ..engine.view_rays import place_under

        depsgraph = context.evaluated_depsgraph_get()
        try:
            place = place_under(context, depsgraph, event.mouse_x, event.mouse_y)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return False
        if place is None:
            self.report({"WARNING"}, "Click in a 3D view, or on the render in an Image Editor")
            return False
        is_picked = self._pick(context, depsgraph, place)
        for area in context.screen.areas:
            area.tag_redraw()
        return is_picked

    def _pick(self, context: Context, depsgraph: Depsgraph, place: Place) -> bool:
        """Whether there is a new constraint."""
        from tyndall import InvalidInput

        from ..engine.view_rays import first_hit

        if place.ray() is None:
            self.report({"ERROR"}, "The camera shows nothing there: it lies beside its panorama")
            return False
        try:
            position = _parameters(context, depsgraph, place)
        except InvalidInput as error:
            self.report({"ERROR"}, str(error))
            return False
        hit = first_hit(depsgraph, place, self.object_name)
        if hit is None and self.object_name:
            self.report({"ERROR"}, f'Object "{self.object_name}" has no surface there')
            return False
        constraints = self.edited_list(context)
        colour = None if constraints.active is None else tuple(constraints.active.colour)
        constraint = constraints.add("Colour")
        constraint.position = position
        if colour is not None:
            constraint.colour = colour
        if hit is None:
            self.report({"INFO"}, "There is no surface: the constraint stays where it is in the function")
        else:
            _follow(constraint, depsgraph, hit)
        constraints.owner.update_tag()
        return True


def _parameters(context: Context, depsgraph: Depsgraph, place: Place) -> tuple[float, float]:
    """Where the ray is in the edited function. Raises InvalidInput, which names what is wrong with that."""
    import numpy as np

    from tyndall import InvalidInput, Progress
    from tyndall.transfer_functions import WeightedFunction

    from ..engine.sessions import session_of
    from ..engine.settings import FrameWindow, render_config
    from ..sync.images import ImageReader
    from ..sync.reports import Reports
    from ..sync.transfer_functions import FunctionReader

    reports = Reports()
    reader = FunctionReader(depsgraph, ImageReader(), reports, follows_surfaces=False)
    function = reader.read_without_layers(edited_function(context))
    if function is None:
        raise InvalidInput("; ".join(reports.lines()))
    window = FrameWindow(size_px=place.camera.size_px, region_px=(0, 0, *place.camera.size_px))
    config = render_config(
        depsgraph.scene_eval, depsgraph.view_layer_eval, window, (WeightedFunction(function=function),)
    )
    shafts = replace(config.shafts, method="EPIPOLAR", error_target=max(config.shafts.error_target, _ERROR_TARGET))
    config = replace(config, shafts=replace(shafts, light_samples=min(shafts.light_samples, _LIGHT_SAMPLES)))
    places_px = np.array([place.place_px], np.float32)
    (position,) = session_of(depsgraph).ray_parameters(place.camera, config, places_px, Progress())
    return float(position[0]), float(position[1])


def _follow(constraint: TyndallTransferConstraint, depsgraph: Depsgraph, hit: Hit) -> None:
    """The surface; on an instance, the object that instances it."""
    thing = hit.instancer(depsgraph)
    if thing is not None:
        anchor = anchor_in(thing.evaluated_get(depsgraph), hit.world_point)
    else:
        thing = hit.thing
        local_point = hit.world_from_object.inverted() @ hit.world_point
        anchor = anchor_at(thing.evaluated_get(depsgraph), hit.polygon_index, local_point)
    constraint.tracked_object = thing
    constraint.triangle_index, constraint.triangle_count = anchor.triangle_index, anchor.triangle_count
    constraint.triangle_weights, constraint.local_point = anchor.weights, anchor.local_point
    constraint.is_tracked = True


CLASSES = (TYNDALL_OT_pick_constraint,)
