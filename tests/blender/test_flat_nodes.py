# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that compute give what Cycles gives, over random inputs."""

from __future__ import annotations

from support.flat_nodes import Setup, deviations
from support.flat_setups import COLOUR_SETUPS, GRAPH_SETUPS, MATH_SETUPS

#: Relative, of float32's 1.2e-7: sums with the offset of 16, and functions that differ in their last bits.
ROUNDING = 2e-5


def largest(setups: list[Setup], bound_of: dict[str, float]) -> list[str]:
    """What is off by more than its bound."""
    found = deviations(setups)
    return [
        f"{name}: {one.largest:.2e}" for name, one in found.items() if not one.largest <= bound_of.get(name, ROUNDING)
    ]


def test_numbers_and_vectors_agree() -> None:
    assert not largest(MATH_SETUPS, {})


def test_colours_agree() -> None:
    # Cycles' blackbody is a fit, which is off by so much.
    assert not largest(COLOUR_SETUPS, {"Blackbody": 1e-3})


def test_groups_reroutes_and_muted_nodes_agree() -> None:
    assert not largest(GRAPH_SETUPS, {})
