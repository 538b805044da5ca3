# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the values of nodes are off Cycles', by node: of all set-ups that the tests of nodes render."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
from numpy.typing import NDArray

from .flat_nodes import Inputs, Setup, deviations
from .flat_setups import COLOUR_SETUPS, GRAPH_SETUPS, MATH_SETUPS
from .patch_nodes import shown_on_patches

Socket = bpy.types.NodeSocket
Build = Callable[..., Socket]
#: What set-ups feed the tested node with, or show it by.
HELPERS = {
    "ShaderNodeAttribute", "ShaderNodeUVMap", "ShaderNodeTexCoord", "ShaderNodeNewGeometry", "ShaderNodeMath",
    "ShaderNodeVectorMath", "ShaderNodeMapping", "ShaderNodeCombineXYZ", "ShaderNodeSeparateXYZ",
}  # fmt: skip
BEST_SHARE = 0.98  #: Of points: where patterns and texels jump, the last bit of a place decides.


class Recorder:
    """Remembers which nodes set-ups are about, by their names: all that are no helpers, or else what they show."""

    def __init__(self) -> None:
        self.tested: dict[str, set[str]] = {}

    def of_inputs(self, setup: Setup) -> Setup:
        """The same set-up."""

        def build(inputs: Inputs) -> Socket:
            return self._recorded(setup.name, lambda new, link: setup.build(Inputs(new, link)), inputs.new, inputs.link)

        return Setup(setup.name, build, setup.low, setup.high, is_special=setup.is_special)

    def of_patches(self, name: str, build: Build) -> Build:
        """The same builder."""
        return lambda new, link: self._recorded(name, build, new, link)

    def _recorded(self, name: str, build: Build, new: Callable[[str], bpy.types.Node], link: Build) -> Socket:
        made = set()

        def recorded(kind: str) -> bpy.types.Node:
            made.add(kind)
            return new(kind)

        shown = build(recorded, link)
        self.tested[name] = made - HELPERS or {shown.node.bl_idname}
        return shown


def off(ours: NDArray[np.float64], cycles: NDArray[np.float64]) -> float:
    """The largest deviation of the points that agree best, relative where values are above 1."""
    by_point = (np.abs(ours - cycles) / np.maximum(np.abs(cycles), 1.0)).max(axis=1)
    return float(np.quantile(by_point, BEST_SHARE))


def measured(patterns: list[Setup], patches: dict[str, Build]) -> dict[str, tuple[float, int]]:
    """By node: the largest deviation, and of how many set-ups."""
    recorder = Recorder()
    found: dict[str, tuple[float, int]] = {}

    def add(name: str, deviation: float) -> None:
        for kind in recorder.tested[name]:
            before, count = found.get(kind, (0.0, 0))
            found[kind] = (max(before, deviation), count + 1)

    for setups in (MATH_SETUPS, COLOUR_SETUPS, GRAPH_SETUPS, patterns):
        for name, one in deviations([recorder.of_inputs(setup) for setup in setups]).items():
            add(name, off(one.ours, one.cycles))
    recorded = {name: recorder.of_patches(name, build) for name, build in patches.items()}
    for name, shown in shown_on_patches(recorded).items():
        add(name, off(shown.ours, shown.cycles))
    return found
