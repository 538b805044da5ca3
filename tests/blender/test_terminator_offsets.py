# SPDX-License-Identifier: GPL-3.0-or-later
"""An object's own shadow terminator is not drawn, and named."""

from __future__ import annotations

import bpy
import pytest

from addon.sync.terminator_offsets import NOTE
from support.small_scenes import cube, empty_scene, read

IS_OBJECTS = "shadow_terminator_shading_offset" in bpy.types.Object.bl_rna.properties


# Seen to fail: nothing was said.
@pytest.mark.parametrize(("geometry", "shading"), [(0.3, 0.0), (0.1, 0.5), (0.0, 0.0)])
def test_offsets_that_are_not_drawn_are_named(geometry: float, shading: float) -> None:
    empty_scene()
    body = cube()
    assert read().reports == ()
    holder = body if IS_OBJECTS else body.cycles
    holder.shadow_terminator_geometry_offset = geometry
    setattr(holder, "shadow_terminator_shading_offset" if IS_OBJECTS else "shadow_terminator_offset", shading)
    body.update_tag()  # of Cycles' own properties it is not told
    assert read().reports == (f'Object "Cube": {NOTE}',)
