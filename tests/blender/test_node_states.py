# SPDX-License-Identifier: GPL-3.0-or-later
"""Every shader node of the running Blender is drawn as a test says, or says what becomes of it; see docs/nodes.md."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from support.image_setups import IMAGES, NORMALS
from support.input_setups import INPUT_SETUPS
from support.node_measurements import measured
from support.node_states import ELSEWHERE, TESTS, node_states
from support.pattern_setups import setups_of, usual_cases
from support.photometry_files import PHOTOMETRY


# Seen to fail: with a node left out of the registries' reports.
def test_no_node_is_left_unnamed() -> None:
    patterns = [setup for setup, _ in setups_of(usual_cases()).values()]
    of_values = measured(patterns, {**INPUT_SETUPS, **IMAGES, **NORMALS, **PHOTOMETRY})
    states = node_states()
    assert len(states) > 80
    unnamed = [
        kind
        for kind, state in states.items()
        if not state.reports and kind not in of_values and kind not in TESTS and kind not in ELSEWHERE
    ]
    assert not unnamed
    assert max(deviation for deviation, _ in of_values.values()) < 2e-2


def test_what_is_no_node_is_not_called_one() -> None:
    """Reports reach the node that they are about."""
    states = node_states()
    assert any("keeps its own value" in report for report in states["ShaderNodeShaderToRGB"].reports)
    assert not states["ShaderNodeMath"].reports


@pytest.mark.skipif(not (4, 5) <= bpy.app.version < (4, 6), reason="the page is of 4.5")
def test_the_page_says_what_the_compiler_says() -> None:
    lines = (Path(__file__).parents[2] / "docs" / "nodes.md").read_text(encoding="utf-8").splitlines()
    shown = {cells[1].strip(): cells[2].strip() for line in lines if len(cells := line.split("|")) > 4}
    for kind, state in node_states().items():
        assert shown[state.label] == ELSEWHERE.get(kind, state.said())
