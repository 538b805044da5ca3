# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes on smooth, bent patches, as emission: in Cycles and in ours, pixel against pixel.

Every set-up has a patch of its own: an object that is turned, stretched, and every second time mirrored, before a
perspective camera. Only pixels well inside a patch are compared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector
from numpy.typing import NDArray

from .engine_pictures import cycles_pixels, tyndall_pixels
from .small_scenes import Node, add, empty_scene, material

New, Link = Callable[[str], Node], Callable[..., object]
Socket = bpy.types.NodeSocket
_COLUMNS, _CELL_PX, _MARGIN_PX, _STEPS = 8, 14, 4, 6
#: What is shown is the result plus this, as light is not negative.
_OFFSET = 8.0


@dataclass(frozen=True)
class Shown:
    """Pixels of one patch, each (pixels, 3)."""

    cycles: NDArray[np.float64]
    ours: NDArray[np.float64]

    def off(self, share: float = 1.0) -> float:
        """Largest deviation, relative where values are above 1; of the ``share`` of pixels that agree best."""
        off = (np.abs(self.ours - self.cycles) / np.maximum(np.abs(self.cycles), 1.0)).max(axis=1)
        return float(np.quantile(off, share))


def shown_on_patches(setups: dict[str, Callable[[New, Link], Socket]], *, is_flat: bool = False) -> dict[str, Shown]:
    """Render all of them at once, in either engine."""
    scene = patch_scene(setups, is_flat=is_flat)
    ours = tyndall_pixels(scene) - _OFFSET
    cycles = cycles_pixels(scene, samples=1, seed=1) - _OFFSET
    found = {}
    for index, name in enumerate(setups):
        row, column = divmod(index, _COLUMNS)
        inner = tuple(
            slice(place * _CELL_PX + _MARGIN_PX, (place + 1) * _CELL_PX - _MARGIN_PX) for place in (row, column)
        )
        found[name] = Shown(cycles[inner].reshape(-1, 3), ours[inner].reshape(-1, 3))
    return found


def patch_scene(setups: dict[str, Callable[[New, Link], Socket]], *, is_flat: bool = False) -> bpy.types.Scene:
    scene = empty_scene()
    rows = -(-len(setups) // _COLUMNS)
    scene.render.resolution_x, scene.render.resolution_y = _COLUMNS * _CELL_PX, rows * _CELL_PX
    camera = scene.camera
    camera.data.type, camera.data.sensor_fit = "PERSP", "HORIZONTAL"
    distance = 30.0
    camera.data.sensor_width, camera.data.lens = float(_COLUMNS), distance
    camera.location = (_COLUMNS / 2, rows / 2, distance)
    camera.rotation_euler, camera.scale = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    for index, (name, build) in enumerate(setups.items()):
        row, column = divmod(index, _COLUMNS)
        patch = add(f"Patch {name}", _patch(name, material(name, _emitted(build)), is_flat=is_flat))
        turn = Euler((0.25, -0.3, 0.4 * index)).to_matrix().to_4x4()
        stretch = Matrix.Diagonal((1.3 if index % 2 else -1.1, 1.2, 1.4, 1.0))
        patch.matrix_world = Matrix.Translation((column + 0.5, row + 0.5, 0.2 * (index % 3))) @ turn @ stretch
        patch.color, patch.pass_index = (0.2, 0.5 + 0.01 * index, 0.9, 0.7), index
    return scene


def _patch(name: str, shown: bpy.types.Material, *, is_flat: bool) -> bpy.types.Mesh:
    """A little hill, 0.6 wide, with UVs that are bent and turned."""
    steps = np.linspace(-0.3, 0.3, _STEPS + 1)
    corners = [(x, y, 0.15 * np.cos(3.0 * x) * np.cos(4.0 * y + 0.6)) for y in steps for x in steps]
    width = _STEPS + 1
    faces = [
        (first, first + 1, first + 1 + width, first + width)
        for row in range(_STEPS)
        for first in range(row * width, row * width + _STEPS)
    ]
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    data.polygons.foreach_set("use_smooth", np.full(len(faces), not is_flat))
    uvs = data.uv_layers.new(name="UVMap").data
    for loop in data.loops:
        x, y, _ = corners[loop.vertex_index]
        uvs[loop.index].uv = (0.5 + 1.4 * x + 0.4 * y, 0.4 - 0.2 * x + 1.6 * y + 0.8 * x * x)
    other = data.uv_layers.new(name="Other").data
    for loop in data.loops:
        x, y, _ = corners[loop.vertex_index]
        other[loop.index].uv = (3.0 * y, 0.3 - 2.0 * x)
    warmth = data.attributes.new("warmth", "FLOAT", "POINT")
    warmth.data.foreach_set("value", np.array([4.0 * x * y + 0.5 for x, y, _ in corners], np.float32))
    flow = data.attributes.new("flow", "FLOAT_VECTOR", "CORNER")
    flow.data.foreach_set(
        "vector", np.array([Vector(corners[loop.vertex_index]).yzx for loop in data.loops], np.float32).ravel()
    )
    step = data.attributes.new("step", "INT", "FACE")
    step.data.foreach_set("value", np.arange(len(faces), dtype=np.int32))
    data.materials.append(shown)
    data.uv_layers["UVMap"].active_render = True
    return data


def _emitted(build: Callable[[New, Link], Socket]) -> Callable[[New, Link], Socket]:
    def built(new: New, link: Link) -> Socket:
        moved, emission = new("ShaderNodeVectorMath"), new("ShaderNodeEmission")
        moved.operation = "ADD"
        moved.inputs[1].default_value = (_OFFSET, _OFFSET, _OFFSET)
        link(build(new, link), moved.inputs[0])
        link(moved.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    return built
