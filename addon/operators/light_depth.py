# SPDX-License-Identifier: GPL-3.0-or-later
"""Show what a light sees of its occluders, before and after their edits, as two images."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import IntProperty
from bpy.types import Context, Image, Operator

from ..availability import why_no_render
from ..edited_light import edited_light, object_of, why_not_editable
from ..image_editors import show_image

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class TYNDALL_OT_show_light_depth(Operator):
    """Render the light's depth map as it is and as its edits leave it: black is near the light, white far or nothing.

    Edits along the view depend on the camera, and do not show
    """

    bl_idname = "tyndall.show_light_depth"
    bl_label = "Show Depth Map"
    bl_options = {"REGISTER"}

    resolution: IntProperty(
        name="Resolution", description="Texels along the longer side", default=1024, min=16, max=16384, subtype="PIXEL"
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := why_not_editable(edited_light(context))) is not None or (reason := why_no_render()) is not None:
            cls.poll_message_set(reason)
        else:
            return True
        return False

    def execute(self, context: Context) -> set[str]:
        # All panels register where the native core does not load; only what computes needs it.
        from tyndall import InvalidInput, Progress

        from ..engine.sessions import session_of

        light = edited_light(context)
        thing = object_of(context, light)
        if thing is None:
            self.report({"ERROR"}, f'Light "{light.name}" is not in the scene')
            return {"CANCELLED"}
        session = session_of(context.evaluated_depsgraph_get())
        try:
            pictures = session.light_depth_picture(thing.name, self.resolution, Progress())
        except InvalidInput as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        before, after = (
            _write_image(f"{thing.name} depth {when}", picture)
            for when, picture in zip(("before", "after"), pictures, strict=True)
        )
        show_image(context, after)
        self.report({"INFO"}, f'The depth map is in the images "{before.name}" and "{after.name}"')
        return {"FINISHED"}


def _write_image(name: str, picture: NDArray[np.float32]) -> Image:
    height, width = picture.shape
    image = bpy.data.images.get(name)
    if image is None:
        image = bpy.data.images.new(name, width, height, float_buffer=True, is_data=True)
    elif tuple(image.size) != (width, height):
        image.scale(width, height)
    import numpy as np  # Debian's Blender comes without: the add-on must load, and say so

    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = picture[..., None]
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


CLASSES = (TYNDALL_OT_show_light_depth,)
