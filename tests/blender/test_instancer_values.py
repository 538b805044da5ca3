# SPDX-License-Identifier: GPL-3.0-or-later
"""What instancers give to instances, attributes, properties and coordinates, is what Cycles finds."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np
import pytest

from addon import last_render
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.particle_scenes import OFFSET, SQUARE, emitter
from support.patch_nodes import Link, New, Socket
from support.small_scenes import Build, add, empty_scene, material, mesh

IS_TOLD = hasattr(bpy.types.Object, "evaluated_geometry")
Asks = Callable[[New], Socket]


def attribute(name: str, output: str = "Color") -> Asks:
    def ask(new: New) -> Socket:
        node = new("ShaderNodeAttribute")
        node.attribute_type, node.attribute_name = "INSTANCER", name
        return node.outputs[output]

    return ask


def coordinate(kind: str, output: str) -> Asks:
    def ask(new: New) -> Socket:
        node = new(kind)
        node.from_instancer = True
        return node.outputs[output]

    return ask


COORDINATES = {
    "UV": coordinate("ShaderNodeTexCoord", "UV"),
    "UV map": coordinate("ShaderNodeUVMap", "UV"),
    "Generated": coordinate("ShaderNodeTexCoord", "Generated"),
}


def telling(ask: Asks) -> Build:
    def build(new: New, link: Link) -> Socket:
        moved, emission = new("ShaderNodeVectorMath"), new("ShaderNodeEmission")
        moved.inputs[1].default_value = (OFFSET, OFFSET, OFFSET)
        link(ask(new), moved.inputs[0])
        link(moved.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    return build


def plate_scene() -> tuple[bpy.types.Scene, bpy.types.Object]:
    """Of 8 by 8 m from above, and a plate of a metre beside it, that tells what it is asked for."""
    scene = empty_scene(32)
    scene.camera.data.ortho_scale, scene.camera.location.z = 8.0, 6.0
    plate = add("Plate", mesh("Plate", SQUARE, [(0, 1, 2, 3)], material("Told", telling(attribute("")))), (20, 0, 0))
    plate["own"], plate.data["of data"], plate["both"] = 0.75, (0.25, 0.5), 0.5
    return scene, plate


def ask(plate: bpy.types.Object, asks: Asks) -> None:
    plate.data.materials[0] = material("Told", telling(asks))


def are_those_of_cycles(scene: bpy.types.Scene, *, edges: float = 0.02) -> int:
    """How many different values there are."""
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=1, seed=1)
    assert np.quantile(np.abs(ours - cycles).max(axis=2), 1.0 - edges) < 1e-4
    assert not (last_render.statistics_of(scene.name) or {})["reports"]
    return len(np.unique(np.round(ours.reshape(-1, 3), 4), axis=0)) - 1  # but for the background


def on_faces(plate: bpy.types.Object) -> bpy.types.Object:
    """A hidden grid of 3 x 3 faces, on each of which the plate stands."""
    corners = [(x, y, 0) for y in range(4) for x in range(4)]
    faces = [(4 * y + x, 4 * y + x + 1, 4 * y + x + 5, 4 * y + x + 4) for y in range(3) for x in range(3)]
    grid = add("Grid", mesh("Grid", corners, faces))
    grid.location = (-2, -2, 0)
    uv_map = grid.data.uv_layers.new(name="UVMap")
    for loop in grid.data.loops:
        x, y, _ = grid.data.vertices[loop.vertex_index].co
        uv_map.data[loop.index].uv = 0.1 * x + 0.02 * y, 0.3 - 0.1 * y
    grid.instance_type, grid.show_instancer_for_render = "FACES", False
    plate.parent, plate.location = grid, (0, 0, 0)
    return grid


def add_particles(plate: bpy.types.Object) -> bpy.types.ParticleSettings:
    """That show the plate as another object, which stands by itself, too."""
    settings = emitter("Strip", "EMITTER", 12, -2.8)
    settings.frame_start = settings.frame_end = 0.0
    settings.physics_type, settings.render_type = "NO", "OBJECT"
    settings.instance_object = twin = add("Twin", plate.data, (3, 3, 0))
    settings.use_rotation_instance, twin.rotation_euler.y = True, 0.5 * math.pi  # particles lay their x along z
    bpy.context.scene.frame_set(1)
    return settings


@pytest.mark.parametrize("name", COORDINATES)
def test_coordinates_of_instancers(name: str) -> None:
    """On faces, by particles, and of what is no instance."""
    scene, plate = plate_scene()
    ask(plate, COORDINATES[name])
    on_faces(plate)
    add_particles(plate)
    kinds = are_those_of_cycles(scene)
    assert kinds >= (10 if name.startswith("UV") else 5)


@pytest.mark.parametrize("name", ["own", "of data", "both", "of grid", "of system", "nobody's"])
def test_properties_of_instancers(name: str) -> None:
    """Of the particles' settings, the instancer, the instance and its mesh, in this order."""
    scene, plate = plate_scene()
    ask(plate, attribute(name))
    grid = on_faces(plate)
    grid["of grid"], grid["both"], grid.data["of data"] = (0.1, 0.2, 0.3, 0.4), 0.25, 0.125
    settings = add_particles(plate)
    settings["of system"], settings["both"] = 0.9, 0.1
    are_those_of_cycles(scene)


def geometry_nodes(name: str, build: Callable[[bpy.types.NodeTree], Socket]) -> bpy.types.Object:
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT") if IS_TOLD else ():
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    if not IS_TOLD and bpy.app.version < (4, 0, 0):
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    tree.links.new(build(tree), tree.nodes.new("NodeGroupOutput").inputs[0])
    made = add(name, mesh(name, [], []), (-3.5, -3.5, 0))
    made.modifiers.new("Nodes", "NODES").node_group = tree
    return made


def shown(tree: bpy.types.NodeTree, plate: bpy.types.Object, *, as_instance: bool = False) -> Socket:
    node = tree.nodes.new("GeometryNodeObjectInfo")
    node.inputs["Object"].default_value, node.inputs["As Instance"].default_value = plate, as_instance
    return node.outputs["Geometry"]


def in_line(tree: bpy.types.NodeTree, what: Socket, count: int, step: tuple[float, float, float]) -> Socket:
    line, placed = tree.nodes.new("GeometryNodeMeshLine"), tree.nodes.new("GeometryNodeInstanceOnPoints")
    line.inputs["Count"].default_value, line.inputs["Offset"].default_value = count, step
    tree.links.new(line.outputs[0], placed.inputs["Points"])
    tree.links.new(what, placed.inputs["Instance"])
    return placed.outputs[0]


def with_attribute(tree: bpy.types.NodeTree, what: Socket, name: str, kind: str, value: object) -> Socket:
    node = tree.nodes.new("GeometryNodeStoreNamedAttribute")
    node.data_type, node.domain, node.inputs["Name"].default_value = kind, "INSTANCE", name
    tree.links.new(what, node.inputs["Geometry"])
    (given,) = (one for one in node.inputs if one.name == "Value" and one.enabled)
    if isinstance(value, bpy.types.NodeSocket):
        tree.links.new(value, given)
    else:
        given.default_value = value
    return node.outputs[0]


def random_numbers(tree: bpy.types.NodeTree) -> Socket:
    node = tree.nodes.new("FunctionNodeRandomValue")
    node.data_type = "FLOAT_VECTOR"
    return node.outputs[0]


CONSTANTS: dict[str, object] = {
    "FLOAT": 0.5,
    "INT": 3,
    "BOOLEAN": True,
    "FLOAT2": (0.3, 0.6, 0.0),
    "FLOAT_VECTOR": (0.1, 0.2, 0.3),
    "FLOAT_COLOR": (0.1, 0.2, 0.3, 0.4),
    "BYTE_COLOR": (0.2, 0.4, 0.6, 0.8),
}
OF_NODES = ("inner", "outer", "on both", "own", *CONSTANTS)


def lines_of_lines(plate: bpy.types.Object, *, as_instance: bool) -> bpy.types.Object:
    def build(tree: bpy.types.NodeTree) -> Socket:
        index = tree.nodes.new("GeometryNodeInputIndex").outputs[0]
        line = in_line(tree, shown(tree, plate, as_instance=as_instance), 3, (1.25, 0, 0))
        line = with_attribute(tree, line, "inner", "FLOAT", index)
        line = with_attribute(tree, line, "on both", "FLOAT_VECTOR", random_numbers(tree))
        lines = in_line(tree, line, 4, (0, 1.25, 0))
        lines = with_attribute(tree, lines, "outer", "INT", index)
        lines = with_attribute(tree, lines, "on both", "FLOAT", 0.125)
        for kind, value in CONSTANTS.items() if IS_TOLD else ():
            lines = with_attribute(tree, lines, kind, kind, value)
        return lines

    return geometry_nodes("Lines", build)


# Seen to fail with the outermost level first.
@pytest.mark.skipif(not IS_TOLD, reason="Blender 4.5 is the first that tells attributes of instances")
@pytest.mark.parametrize(
    ("name", "output", "as_instance"),
    [
        *((name, "Color", False) for name in OF_NODES),
        ("FLOAT_COLOR", "Alpha", False),
        *((name, "Color", True) for name in OF_NODES[:3]),
    ],
)
def test_attributes_of_geometry_nodes_instances(name: str, output: str, *, as_instance: bool) -> None:
    scene, plate = plate_scene()
    ask(plate, attribute(name, output))
    lines_of_lines(plate, as_instance=as_instance)
    kinds = are_those_of_cycles(scene)
    assert kinds >= {"inner": 3, "outer": 4, "on both": 3}.get(name, 1)


@pytest.mark.skipif(not IS_TOLD, reason="Blender 4.5 is the first that tells attributes of instances")
def test_instances_that_have_ids() -> None:
    """Scattered points have ids that are far from their numbers."""
    scene, plate = plate_scene()
    ask(plate, attribute("tint"))
    plate.scale = (0.3, 0.3, 0.3)

    def build(tree: bpy.types.NodeTree) -> Socket:
        grid, points, placed = map(
            tree.nodes.new,
            ("GeometryNodeMeshGrid", "GeometryNodeDistributePointsOnFaces", "GeometryNodeInstanceOnPoints"),
        )
        grid.inputs["Size X"].default_value = grid.inputs["Size Y"].default_value = 6.0
        points.inputs["Density"].default_value = 1.0
        tree.links.new(grid.outputs[0], points.inputs["Mesh"])
        tree.links.new(points.outputs["Points"], placed.inputs["Points"])
        tree.links.new(shown(tree, plate), placed.inputs["Instance"])
        return with_attribute(tree, placed.outputs[0], "tint", "FLOAT_VECTOR", random_numbers(tree))

    geometry_nodes("Scattered", build).location = (0, 0, 0)
    kinds = are_those_of_cycles(scene, edges=0.06)
    assert kinds > 15


@pytest.mark.skipif(IS_TOLD, reason="told from 4.5 on")
def test_attributes_that_blender_does_not_tell_are_named() -> None:
    scene, plate = plate_scene()
    ask(plate, attribute("inner"))
    lines_of_lines(plate, as_instance=True)
    assert np.isclose(tyndall_pixels(scene), OFFSET + 0.5).all(axis=2).sum() > 20
    reports = (last_render.statistics_of(scene.name) or {})["reports"]
    assert reports == ['Object "Plate": attribute "inner" of its instancer is not known here: mid grey']
