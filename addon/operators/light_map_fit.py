# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit a light's map to strokes that were painted over cameras; the list of those strokes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.types import Context, Light, Operator

from ..availability import why_no_render
from ..edited_light import edited_light, object_of, why_not_editable
from ..fitted_maps import continued_fit, keep, kept_fit, new_fit, write_back
from ..item_lists import ItemList
from ..stroke_views import begin_painting, view_of
from .in_thread import InThread
from .item_lists import ListOperator, RemoveItem

if TYPE_CHECKING:
    from tyndall import Progress

    from ..fitted_maps import PreparedFit


def why_no_fit(light: Light | None) -> str | None:
    """What a button says that fits maps; None: it may."""
    if (reason := why_not_editable(light)) is not None:
        return reason
    if light is not None and light.type == "AREA":
        return "An area light has no beam to paint: paint the shafts of a sun, a spot or a point light"
    if light is not None and light.library is not None:
        return "The light is linked: make a library override of it first"
    return None


def views_of(light: Light) -> ItemList:
    return ItemList(light.tyndall.light_map_fit, "views", "active_view")


class _FitOperator:
    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := why_no_fit(edited_light(context))) is not None or (reason := why_no_render()) is not None:
            cls.poll_message_set(reason)
        else:
            return True
        return False


class _Solve(_FitOperator, InThread):
    """In a thread, with progress, where there is a window; Esc stops it, and leaves the light as it is."""

    bl_options = {"REGISTER", "UNDO"}
    thread_name = "tyndall fit"

    def prepare(self, context: Context, light: Light) -> PreparedFit:
        raise NotImplementedError

    def begin(self, context: Context) -> bool:
        from tyndall import InvalidInput

        self._light = edited_light(context)
        try:
            self._prepared = self.prepare(context, self._light)
        except (ValueError, InvalidInput) as error:
            self.report({"ERROR"}, str(error))
            return False
        return True

    def work(self, progress: Progress) -> None:
        self._prepared.run(progress)

    def end(self, context: Context, error: BaseException | None) -> set[str]:
        from tyndall import Cancelled, InvalidInput

        if isinstance(error, Cancelled):
            goes_on = self._prepared.fit is not None
            if goes_on:
                keep(self._light, self._prepared.fit)
            self.report({"INFO"}, f"The fit was stopped: the light is as it was{', and Continue goes on' * goes_on}")
            return {"CANCELLED"}
        if isinstance(error, InvalidInput):
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if error is not None:
            raise error
        for line in self._prepared.reports:
            self.report({"WARNING"}, line)
        fit = self._prepared.fit
        image = write_back(self._light, fit)
        first, last = fit.residuals[0], fit.residuals[-1]
        self.report(
            {"INFO"},
            f'"{image.name}" is the gobo of "{self._light.name}": {len(fit.residuals) - 1} steps took the strokes\' '
            f"error from {first:.1%} to {last:.1%}",
        )
        return {"FINISHED"}


class TYNDALL_OT_fit_light_map(_Solve, Operator):
    """Find the picture that this light has to throw for its shafts to look as they are painted, and make it its gobo.

    Starts from the gobo that it has, and keeps that where no stroke sees it
    """

    bl_idname = "tyndall.fit_light_map"
    bl_label = "Fit Light Map"

    def prepare(self, context: Context, light: Light) -> PreparedFit:
        thing = object_of(context, light)
        if thing is None:
            raise ValueError(f'Light "{light.name}" is not in the scene')
        return new_fit(context, light, thing)


class TYNDALL_OT_continue_light_map(_Solve, Operator):
    """Take more steps of this light's last fit, as its strokes and the scene were then."""

    bl_idname = "tyndall.continue_light_map"
    bl_label = "Continue"

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not super().poll(context):
            return False
        if kept_fit(edited_light(context)) is None:
            cls.poll_message_set("There is no fit to go on with: fit its map first")
            return False
        return True

    def prepare(self, _context: Context, light: Light) -> PreparedFit:
        return continued_fit(light)


class TYNDALL_OT_paint_strokes(_FitOperator, Operator):
    """Paint over what a camera shows how the shafts of this light should look, in Blender's own Image Editor.

    Makes an image for the strokes, and renders the picture that lies behind them. White is the light's own colour
    """

    bl_idname = "tyndall.paint_strokes"
    bl_label = "Paint Strokes"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: Context) -> set[str]:
        from tyndall import InvalidInput

        views = views_of(edited_light(context))
        camera = views.active.camera if views.active is not None and views.active.camera else context.scene.camera
        if camera is None:
            self.report({"ERROR"}, "The scene has no camera to paint over")
            return {"CANCELLED"}
        try:
            shown = begin_painting(context, view_of(views, camera))
        except (ValueError, InvalidInput) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        views.owner.update_tag()
        if not shown:
            self.report({"INFO"}, f'Open "{views.active.strokes.name}" in an Image Editor to paint')
        return {"FINISHED"}


class _ViewOperator(ListOperator):
    empty = "Nothing is painted yet: Paint Strokes begins"

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        return why_no_fit(edited_light(context))

    @classmethod
    def edited_list(cls, context: Context) -> ItemList:
        return views_of(edited_light(context))


class TYNDALL_OT_fit_view_add(_ViewOperator, Operator):
    """Paint over the scene's camera, too."""

    bl_idname = "tyndall.fit_view_add"
    bl_label = "Add View"
    needs_item = False

    def execute(self, context: Context) -> set[str]:
        views, camera = self.edited_list(context), context.scene.camera
        views.add(camera.name if camera is not None else "View").camera = camera
        views.owner.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_fit_view_remove(_ViewOperator, RemoveItem, Operator):
    """Remove the active view. Its strokes stay in the file as an image."""

    bl_idname = "tyndall.fit_view_remove"
    bl_label = "Remove View"


CLASSES = (
    TYNDALL_OT_fit_light_map,
    TYNDALL_OT_continue_light_map,
    TYNDALL_OT_paint_strokes,
    TYNDALL_OT_fit_view_add,
    TYNDALL_OT_fit_view_remove,
)
