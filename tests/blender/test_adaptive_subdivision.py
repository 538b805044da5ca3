# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that Cycles cuts until they are smooth are drawn with their modifier's levels: that is said."""

from __future__ import annotations

import bpy

from addon.sync.adaptive_subdivision import NOTE
from support.small_scenes import cube, empty_scene, read


def _ball(name: str, *, adapts: bool) -> bpy.types.SubsurfModifier:
    ball = cube(name)
    modifier: bpy.types.SubsurfModifier = ball.modifiers.new("Smooth", "SUBSURF")
    (modifier if bpy.app.version >= (5, 0, 0) else ball.cycles).use_adaptive_subdivision = adapts
    return modifier


# Seen to fail: with no report, as until the fourth sample of other people's files.
def test_what_cycles_would_cut_further_is_named() -> None:
    """Not what is cut by its levels alone, nor where another modifier comes later, or the modifier is off."""
    scene = empty_scene()
    if bpy.app.version < (5, 0, 0):
        scene.cycles.feature_set = "EXPERIMENTAL"
    _ball("Adaptive", adapts=True)
    _ball("Plain", adapts=False)
    _ball("Bevelled", adapts=True).id_data.modifiers.new("Bevel", "BEVEL")
    off = _ball("Off", adapts=True)
    off.show_render = off.show_viewport = False
    assert read().reports == (f'Object "Adaptive": {NOTE}',)
    if bpy.app.version < (5, 0, 0):
        scene.cycles.feature_set = "SUPPORTED"
        assert read().reports == ()
