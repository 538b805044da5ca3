# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes rendered flat, as emission, over random inputs: in Cycles and in ours, pixel against pixel.

Each pixel is a face of its own, with inputs of its own that are the same all over it; each row is a material. Inputs
are float colour attributes and a UV map. Of many faces they are 0, 1, -1 and other such numbers, where nodes divide.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from .engine_pictures import cycles_pixels, tyndall_pixels
from .small_scenes import Node, add, empty_scene, material

Socket = bpy.types.NodeSocket
COLUMNS = 64
_NUMBERS, _COLOURS = 4, 4
_SPECIAL = (0.0, 1.0, -1.0, 0.5, 2.0)
#: What is shown is the result plus this, as light is not negative.
_OFFSET = 16.0


@dataclass(frozen=True)
class Inputs:
    """Sockets whose values are random: to be linked to what is tested."""

    new: Callable[[str], Node]
    link: Callable[..., object]

    def number(self, index: int) -> Socket:
        return self._attribute(f"number {index}", "Fac")

    def colour(self, index: int) -> Socket:
        return self._attribute(f"colour {index}", "Color")

    def vector(self, index: int) -> Socket:
        return self._attribute(f"colour {index}", "Vector")

    def uv(self) -> Socket:
        return self.new("ShaderNodeUVMap").outputs["UV"]

    def _attribute(self, name: str, output: str) -> Socket:
        node = self.new("ShaderNodeAttribute")
        node.attribute_name = name
        return node.outputs[output]


@dataclass(frozen=True)
class Setup:
    """What is rendered: ``build`` makes nodes and returns the output to be shown."""

    name: str
    build: Callable[[Inputs], Socket]
    low: float = -2.0  #: Of the random inputs.
    high: float = 3.0
    is_special: bool = True  #: A third of the inputs are such as 0 and 1.


@dataclass(frozen=True)
class Deviation:
    """Of a set-up, over its pixels and channels; relative to Cycles' value where that is above 1."""

    largest: float
    mean: float
    cycles: NDArray[np.float64]  #: (columns, 3).
    ours: NDArray[np.float64]


def with_inputs(kind: str, *sources: str, output: int = 0, **properties: object) -> Callable[[Inputs], Socket]:
    """A node with its visible inputs linked in turn: to "number 0", "colour 1", "vector 2", "uv", or to nothing for "".

    Names of properties that the node does not have are those of inputs, with underscores for spaces.
    """

    def build(inputs: Inputs) -> Socket:
        node = inputs.new(kind)
        for name, value in properties.items():
            if hasattr(node, name):
                setattr(node, name, value)
            else:
                node.inputs[name.replace("_", " ")].default_value = value
        visible = [socket for socket in node.inputs if not socket.is_unavailable]
        for source, socket in zip(sources, visible, strict=False):
            if source:
                name, _, index = source.partition(" ")
                inputs.link(getattr(inputs, name)(*([int(index)] if index else [])), socket)
        return [socket for socket in node.outputs if not socket.is_unavailable][output]

    return build


def deviations(setups: Sequence[Setup], seed: int = 1) -> dict[str, Deviation]:
    """Render all of them at once, in either engine."""
    scene = flat_scene(setups, seed)
    ours = np.maximum(tyndall_pixels(scene), 0.0) - _OFFSET
    cycles = np.maximum(cycles_pixels(scene, samples=1, seed=1), 0.0) - _OFFSET
    found = {}
    for row, setup in enumerate(setups):
        off = np.abs(ours[row] - cycles[row]) / np.maximum(np.abs(cycles[row]), 1.0)
        found[setup.name] = Deviation(float(off.max()), float(off.mean()), cycles[row], ours[row])
    return found


def flat_scene(setups: Sequence[Setup], seed: int = 1) -> bpy.types.Scene:
    """An orthographic camera above one row of faces per set-up, a pixel each."""
    scene = empty_scene()
    rows = len(setups)
    scene.render.resolution_x, scene.render.resolution_y = COLUMNS, rows
    scene.camera.data.ortho_scale = float(max(COLUMNS, rows))
    scene.camera.location = (COLUMNS / 2, rows / 2, 3.0)
    mesh = _faces(rows)
    for setup in setups:
        mesh.materials.append(material(setup.name, _shown(setup)))
    mesh.polygons.foreach_set("material_index", np.repeat(np.arange(rows), COLUMNS).astype(np.int32))
    random = np.random.default_rng(seed)
    uvs = random.uniform(-1.0, 2.0, (rows * COLUMNS, 2))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.repeat(uvs, 4, axis=0).astype(np.float32).ravel())
    for index in range(_NUMBERS):
        number = np.concatenate([_values(setup, random, 1) for setup in setups])
        _set_attribute(mesh, f"number {index}", np.repeat(number, 3, axis=1))
    for index in range(_COLOURS):
        _set_attribute(mesh, f"colour {index}", np.concatenate([_values(setup, random, 3) for setup in setups]))
    add("Faces", mesh)
    return scene


def _faces(rows: int) -> bpy.types.Mesh:
    row, column = np.divmod(np.arange(rows * COLUMNS), COLUMNS)
    offsets = np.array(((0, 0), (1, 0), (1, 1), (0, 1)))
    corners = np.stack([column, row], axis=1)[:, None] + offsets
    flat = np.concatenate([corners.reshape(-1, 2), np.zeros((rows * COLUMNS * 4, 1))], axis=1)
    mesh = bpy.data.meshes.new("Faces")
    mesh.from_pydata(flat.tolist(), [], np.arange(rows * COLUMNS * 4).reshape(-1, 4).tolist())
    return mesh


def _values(setup: Setup, random: np.random.Generator, channels: int) -> NDArray[np.float64]:
    values = random.uniform(setup.low, setup.high, (COLUMNS, channels))
    special = random.choice(_SPECIAL, (COLUMNS, channels))
    is_special = random.uniform(size=(COLUMNS, channels)) < (0.33 if setup.is_special else 0.0)
    is_special &= (special >= setup.low) & (special <= setup.high)
    return np.where(is_special, special, values)


def _set_attribute(mesh: bpy.types.Mesh, name: str, values: NDArray[np.float64]) -> None:
    rgba = np.concatenate([values, np.ones((len(values), 1))], axis=1)
    attribute = mesh.color_attributes.new(name, "FLOAT_COLOR", "CORNER")
    attribute.data.foreach_set("color", np.repeat(rgba, 4, axis=0).astype(np.float32).ravel())


def _shown(setup: Setup) -> Callable[[Callable[[str], Node], Callable[..., object]], Socket]:
    def build(new: Callable[[str], Node], link: Callable[..., object]) -> Socket:
        moved = new("ShaderNodeVectorMath")
        moved.operation = "ADD"
        moved.inputs[1].default_value = (_OFFSET, _OFFSET, _OFFSET)
        link(setup.build(Inputs(new, link)), moved.inputs[0])
        emission = new("ShaderNodeEmission")
        link(moved.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    return build
