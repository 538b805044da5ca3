# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens the tab Light Shafts over a scene with fog and a lamp: its steps, as an artist first sees them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from support.mouse import TAB, click


def session(window: Any) -> Iterator[float]:
    from support.beam_scene import build_beam_scene

    yield from window.calm()
    build_beam_scene()
    bpy.context.view_layer.objects.active = bpy.data.objects["Lamp"]
    bpy.ops.ed.undo_push(message="begin")
    window.area("VIEW_3D").spaces[0].show_region_ui = True
    yield from window.calm()
    yield from click(window, TAB)
    window.screenshot("sidebar_begin")
