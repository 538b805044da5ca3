# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoise the picture in the compositor, and leave it as it was again."""

from __future__ import annotations

from bpy.types import Context, Operator

from .. import denoising


class TYNDALL_OT_denoising_set_up(Operator):
    """Put Blender's Denoise node behind this scene's picture, and switch on the passes that guide it.

    Where some of it is missing, it is mended; all other nodes stay
    """

    bl_idname = "tyndall.denoising_set_up"
    bl_label = "Denoise in the Compositor"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := denoising.why_not(context.scene)) is not None:
            cls.poll_message_set(reason)
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        denoising.set_up(context.scene)
        return {"FINISHED"}


class TYNDALL_OT_denoising_remove(Operator):
    """Take the Denoise node out of the compositor: links are as they were before, and the passes stay."""

    bl_idname = "tyndall.denoising_remove"
    bl_label = "Remove Denoising from the Compositor"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not denoising.nodes_of(context.scene):
            cls.poll_message_set("There is none in this scene's compositor")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        denoising.remove(context.scene)
        return {"FINISHED"}


CLASSES = (TYNDALL_OT_denoising_set_up, TYNDALL_OT_denoising_remove)
