# SPDX-License-Identifier: GPL-3.0-or-later
"""Image Editors of the window that is worked in."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bpy.types import Context, Image


def show_image(context: Context, image: Image) -> bool:
    """Show it in an Image Editor that does not show a render. False: none is open."""
    for area in context.screen.areas if context.screen else ():
        if area.type == "IMAGE_EDITOR" and (area.spaces.active.image or image).type != "RENDER_RESULT":
            area.spaces.active.image = image
            return True
    return False
