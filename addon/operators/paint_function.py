# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint a transfer function: an image layer that begins as a picture of the function."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.types import Context, Operator

from ..availability import why_no_render
from ..function_trees import edited_function
from ..image_editors import show_image
from .transfer_functions import FunctionOperator

if TYPE_CHECKING:
    import numpy as np
    from bpy.types import Image, NodeTree
    from numpy.typing import NDArray

#: Texels per side: those that a render composes a function with.
SIZE_PX = 256


class TYNDALL_OT_transfer_layer_paint(FunctionOperator, Operator):
    """Turn the function into an image layer, to be painted on in the Image Editor, and switch its other layers off."""

    bl_idname = "tyndall.transfer_layer_paint"
    bl_label = "Paint as Image"
    needs_item = False

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        return why_no_render() or super().why_not(context)

    def execute(self, context: Context) -> set[str]:
        from tyndall import InvalidInput

        tree = edited_function(context)
        try:
            image = _packed_image(f"{tree.name} painted", _picture_of(context, tree))
        except InvalidInput as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        layers = self.edited_list(context)
        for layer in layers.items:
            layer.is_enabled = layer.is_solo = False
        layer = layers.insert(len(layers.items), "Painted")
        layer.kind, layer.image = "IMAGE", image
        tree.update_tag()
        if not show_image(context, image):
            self.report({"INFO"}, f'Open the image "{image.name}" in an Image Editor, in its mode Paint')
        return {"FINISHED"}


def _picture_of(context: Context, tree: NodeTree) -> NDArray[np.float32]:
    from tyndall.native_transfer_functions import compose

    from ..sync.images import ImageReader
    from ..sync.reports import Reports
    from ..sync.transfer_functions import FunctionReader

    depsgraph = context.evaluated_depsgraph_get()
    reader = FunctionReader(depsgraph, ImageReader(), Reports(), follows_surfaces=False)
    return compose(reader.read(tree), SIZE_PX)


def _packed_image(name: str, picture: NDArray[np.float32]) -> Image:
    """Of scene-linear colours multiplied with alpha, which is how Blender keeps float pixels; saved with the file."""
    image = bpy.data.images.new(name, SIZE_PX, SIZE_PX, alpha=True, float_buffer=True)
    image.pixels.foreach_set(picture.ravel())
    image.pack()
    return image


CLASSES = (TYNDALL_OT_transfer_layer_paint,)
