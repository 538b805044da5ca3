# SPDX-License-Identifier: GPL-3.0-or-later
"""Where Blender keeps on which side of its frame a shutter is open: with the render since 4.2, with Cycles before."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bpy.types import Scene


def position_settings(scene: Scene) -> Any:  # noqa: ANN401  of the one kind or the other
    """What has ``motion_blur_position``; None where Cycles, which keeps it before 4.2, is not enabled."""
    render = scene.render
    return render if hasattr(render, "motion_blur_position") else getattr(scene, "cycles", None)
