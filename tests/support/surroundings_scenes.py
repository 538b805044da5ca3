# SPDX-License-Identifier: GPL-3.0-or-later
"""Cells far apart, each with things around a patch that a camera sees from above: for nodes that trace rays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import bpy
from mathutils import Matrix

from .engine_pictures import FloatArray, cycles_pixels, tyndall_pixels
from .patch_nodes import Link, New
from .small_scenes import Build, Node, add, empty_scene, light, material, mesh

_APART_M, _SEEN_M, _CELL_PX = 8.0, 1.0, 8
_SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
SetUp = Callable[[New, Link, Node], None]
Shape = tuple[list[tuple[float, ...]], list[tuple[int, ...]]]


@dataclass(frozen=True)
class Part:
    """A mesh in a cell, relative to its middle."""

    shape: Shape
    shown: Build | None = None  #: None: Blender's default.
    place: Matrix = field(default_factory=lambda: Matrix.Identity(4))
    is_smooth: bool = False
    flags: dict[str, bool] = field(default_factory=dict)  #: Of the object.


def box(low: Sequence[float], high: Sequence[float]) -> Shape:
    corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    return corners, list(_SIDES)


FLOOR: Shape = ([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], [(0, 1, 2, 3)])
#: A floor with a wall, in one mesh.
FOLDED: Shape = ([*FLOOR[0][:1], (0.55, -2, 0), (0.55, 2, 0), FLOOR[0][3], (0.55, -2, 0.8), (0.55, 2, 0.8)],
                 [(0, 1, 2, 3), (1, 4, 5, 2)])  # fmt: skip


def occluded(output: str = "AO", set_up: SetUp | None = None, samples: int = 64, **inputs: object) -> Build:
    """Emits what Ambient Occlusion gives; ``inside`` and ``only_local`` are its switches."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        node, emission = new("ShaderNodeAmbientOcclusion"), new("ShaderNodeEmission")
        node.samples = samples
        _fill(node, inputs)
        if set_up is not None:
            set_up(new, link, node)
        link(node.outputs[output], emission.inputs["Color"])
        return emission.outputs[0]

    return build


def beveled(set_up: SetUp | None = None, samples: int = 16, **inputs: object) -> Build:
    """Emits the normal that Bevel gives, and 2 more: light is not negative."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        node, lifted, emission = new("ShaderNodeBevel"), new("ShaderNodeVectorMath"), new("ShaderNodeEmission")
        node.samples = samples
        _fill(node, inputs)
        if set_up is not None:
            set_up(new, link, node)
        lifted.inputs[1].default_value = (2.0, 2.0, 2.0)
        link(node.outputs[0], lifted.inputs[0])
        link(lifted.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    return build


def _fill(node: Node, inputs: dict[str, object]) -> None:
    for name, value in inputs.items():
        if name in node.inputs:
            node.inputs[name].default_value = value
        else:
            setattr(node, name, value)


def with_normal(x: float, y: float, z: float) -> SetUp:
    def set_up(new: New, link: Link, node: Node) -> None:
        vector = new("ShaderNodeCombineXYZ")
        for socket, value in zip(vector.inputs, (x, y, z), strict=True):
            socket.default_value = value
        link(vector.outputs[0], node.inputs["Normal"])

    return set_up


def with_bump(new: New, link: Link, node: Node) -> None:
    """A normal that is bent by waves of the place."""
    geometry, sine, bump = new("ShaderNodeNewGeometry"), new("ShaderNodeVectorMath"), new("ShaderNodeBump")
    sine.operation = "SINE"
    bump.inputs["Distance"].default_value = 0.4
    link(geometry.outputs["Position"], sine.inputs[0])
    link(sine.outputs[0], bump.inputs["Height"])
    link(bump.outputs[0], node.inputs["Normal"])


def with_varying(name: str) -> SetUp:
    """An input that is the place's fraction of a metre along Y."""

    def set_up(new: New, link: Link, node: Node) -> None:
        geometry, fraction, apart = (new(f"ShaderNode{kind}") for kind in ("NewGeometry", "VectorMath", "SeparateXYZ"))
        fraction.operation = "FRACTION"
        link(geometry.outputs["Position"], fraction.inputs[0])
        link(fraction.outputs[0], apart.inputs[0])
        link(apart.outputs["Y"], node.inputs[name])

    return set_up


def scene_of_cells(cells: dict[str, Sequence[Part]]) -> bpy.types.Scene:
    scene = empty_scene(_CELL_PX)
    camera = scene.camera.data
    camera.ortho_scale, camera.clip_start, camera.clip_end = _SEEN_M, 0.01, 100.0
    for index, (name, parts) in enumerate(cells.items()):
        for count, part in enumerate(parts):
            label = f"{name} {count}"
            data = mesh(label, *part.shape, material(label, part.shown) if part.shown else None)
            data.polygons.foreach_set("use_smooth", [part.is_smooth] * len(data.polygons))
            thing = add(label, data)
            thing.matrix_world = Matrix.Translation((_APART_M * index, 0.0, 0.0)) @ part.place
            for flag, value in part.flags.items():
                setattr(thing, flag, value)
    light("SUN", (0, 0, 30), angle=0.0, energy=1.0)
    return scene


def look_at(scene: bpy.types.Scene, index: int) -> None:
    """A little beside the middle of a cell: through no edge between triangles."""
    scene.camera.location = (_APART_M * index + 0.013, 0.021, 20.0)


def pictures(
    scene: bpy.types.Scene, cells: dict[str, Sequence[Part]], samples: int
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Of each cell Cycles' and ours, (height, width, 3)."""
    found = {}
    for index, name in enumerate(cells):
        look_at(scene, index)
        found[name] = (cycles_pixels(scene, samples, seed=1), tyndall_pixels(scene, samples))
    return found
