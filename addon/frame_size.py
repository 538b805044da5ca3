# SPDX-License-Identifier: GPL-3.0-or-later
"""The size of a final render, for tools that work on its frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bpy.types import Scene


def frame_size_px(scene: Scene) -> tuple[int, int]:
    """Width and height of the full frame, before any border; at least a pixel."""
    render = scene.render
    share = render.resolution_percentage / 100.0
    return max(1, int(render.resolution_x * share)), max(1, int(render.resolution_y * share))
