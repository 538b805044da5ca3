# SPDX-License-Identifier: GPL-3.0-or-later
"""Things other than meshes, and what makes them: curves, hair, volumes, modifiers, instances, libraries."""

from __future__ import annotations

from math import inf, nan
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from support.agreement_shapes import diffuse
from support.damages import Random, Scene, damage, mesh_object, soup


def _linked(name: str, data: bpy.types.ID | None) -> bpy.types.Object:
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


@damage("curves of absurd points and radii", None)
def _(_scene: Scene, random: Random) -> None:
    for kind in ("POLY", "BEZIER", "NURBS"):
        data = bpy.data.curves.new("Curve", "CURVE")
        data.dimensions = "3D"
        spline = data.splines.new(kind)
        if kind == "BEZIER":
            points = spline.bezier_points
            points.add(int(random.integers(0, 4)))
            for point in points:
                point.co = random.choice((0.0, 1.0, nan, 1e30), 3)
        else:
            points = spline.points
            points.add(int(random.integers(0, 4)))
            for point in points:
                point.co = random.choice((0.0, 1.0, nan, 1e30), 4)
        for point in points:
            point.radius = float(random.choice([0.0, -1.0, nan, 1e30]))
        data.bevel_depth = float(random.choice([0.0, 0.1, 1e20]))
        _linked("Curve", data)


@damage("texts, metaballs, lattices and surfaces of nothing", None)
def _(_scene: Scene, random: Random) -> None:
    text = bpy.data.curves.new("Text", "FONT")
    text.body = str(random.choice(["", "\n\n", "\ue000\u0000x".replace("\0", " "), "W" * 500]))
    text.size = float(random.choice([0.01, 100.0]))
    _linked("Text", text)
    ball = bpy.data.metaballs.new("Ball")
    element = ball.elements.new()
    element.radius = float(random.choice([0.0, 1e-9]))
    _linked("Ball", ball)
    _linked("Lattice", bpy.data.lattices.new("Lattice"))
    _linked("Surface", bpy.data.curves.new("Surface", "SURFACE"))
    _linked("Armature", bpy.data.armatures.new("Armature"))


@damage("hair of absurd lengths", None)
def _(_scene: Scene, random: Random) -> None:
    made = mesh_object("Hairy", *soup(random))
    made.modifiers.new("Hair", "PARTICLE_SYSTEM")
    settings = made.particle_systems[0].settings
    settings.type = "HAIR"
    settings.count = int(random.choice([0, 1, 50]))
    settings.hair_length = float(random.choice([0.0, 1.0, 1000.0]))
    settings.root_radius = float(random.choice([0.0, 1.0, 10.0]))
    settings.material = 5
    if random.random() < 0.5:
        made.data.clear_geometry()


@damage("hair curves without guides", None)
def _(_scene: Scene, random: Random) -> None:
    if not hasattr(bpy.data, "hair_curves"):
        return
    data = bpy.data.hair_curves.new("Fur")
    _linked("Fur", data)
    if hasattr(data, "add_curves") and random.random() < 0.7:
        data.add_curves([1, 2, 5])
        data.points.foreach_set("position", random.choice((0.0, 1.0, nan, inf), 24).astype(np.float32))
        data.points.foreach_set("radius", random.choice((0.0, 1.0, nan, -1.0), 8).astype(np.float32))


@damage("a volume whose file is gone", "Lost Volume")
def _(_scene: Scene, random: Random) -> None:
    data = bpy.data.volumes.new("Lost Volume")
    data.filepath = str(random.choice(["//gone.vdb", "/dev/null", "//"]))
    material = bpy.data.materials.new("Smoke")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeVolumePrincipled")
    shader.inputs["Density"].default_value = float(random.choice([1.0, 1e30, -1.0]))
    tree.links.new(shader.outputs[0], output.inputs["Volume"])
    data.materials.append(material)
    _linked("Lost Volume", data)


@damage("modifiers that have nothing to work on", None)
def _(_scene: Scene, random: Random) -> None:
    made = mesh_object("Modified", *soup(random, 6))
    kinds = ("ARRAY", "BOOLEAN", "MIRROR", "SUBSURF", "SOLIDIFY", "DISPLACE", "SKIN", "SCREW", "REMESH", "DECIMATE",
             "ARMATURE", "SHRINKWRAP", "CURVE", "CAST", "WAVE", "EXPLODE", "MASK", "BEVEL")  # fmt: skip
    for kind in random.choice(kinds, 3, replace=False):
        modifier = made.modifiers.new(str(kind), str(kind))
        for name in ("strength", "thickness", "factor", "height", "angle", "width"):
            if hasattr(modifier, name):
                setattr(modifier, name, float(random.choice([0.0, -1.0, 1e20, nan])))
    if random.random() < 0.5:
        made.data.clear_geometry()


@damage("shape keys that are not a number", "Keyed")
def _(_scene: Scene, random: Random) -> None:
    made = mesh_object("Keyed", *soup(random))
    made.shape_key_add(name="Basis")
    key = made.shape_key_add(name="Broken")
    key.data[0].co = (nan, inf, 0.0)
    key.value = 1.0


@damage("instances on faces without an area and on vertices that are not a number", None)
def _(_scene: Scene, random: Random) -> None:
    points, faces = soup(random, 6)
    points[::2] = random.choice((0.0, nan, 1e30))
    parent = mesh_object("Giver", points, faces)
    parent.instance_type = str(random.choice(["VERTS", "FACES"]))
    parent.use_instance_faces_scale = parent.use_instance_vertices_rotation = True
    mesh_object("Given", *soup(random, 4)).parent = parent


@damage("collections in a circle, as far as Blender lets them", None)
def _(scene: Scene, random: Random) -> None:
    one, two = bpy.data.collections.new("One"), bpy.data.collections.new("Two")
    scene.collection.children.link(one)
    for holder, held in ((one, two), (two, one)):
        instancer = bpy.data.objects.new("Instancer", None)
        try:
            holder.objects.link(instancer)
            instancer.instance_type, instancer.instance_collection = "COLLECTION", held
            holder.children.link(held)
        except RuntimeError:
            pass  # refused
    two.objects.link(bpy.data.objects.new("Seed", mesh_object("Seed", *soup(random, 3)).data))


@damage("thirty-two thousand instances of instances", None)
def _(scene: Scene, random: Random) -> None:
    held = bpy.data.collections.new("Leaf")
    held.objects.link(bpy.data.objects.new("Leaf", mesh_object("Leaf", *soup(random, 2)).data))
    for _depth in range(5):
        holder = bpy.data.collections.new("Branch")
        for _index in range(8):
            instancer = bpy.data.objects.new("Branch", None)
            instancer.instance_type, instancer.instance_collection = "COLLECTION", held
            instancer.location = random.normal(size=3) + np.array((5.0, 0.0, 0.0))
            holder.objects.link(instancer)
        held = holder
    top = bpy.data.objects.new("Tree", None)
    top.instance_type, top.instance_collection = "COLLECTION", held
    scene.collection.objects.link(top)


@damage("parents of no scale, and constraints without targets", None)
def _(_scene: Scene, random: Random) -> None:
    parent = _linked("Nobody", None)
    parent.scale = (0.0, 1.0, float(random.choice([0.0, 1e-30])))
    child = mesh_object("Child", *soup(random))
    child.parent = parent
    child.matrix_parent_inverse = Matrix(((0.0,) * 4,) * 4)
    for kind in ("TRACK_TO", "COPY_TRANSFORMS", "CHILD_OF", "FOLLOW_PATH"):
        child.constraints.new(kind)
    child.constraints[0].target = child


@damage("names of nothing but quotes, breaks and accents", None)
def _(_scene: Scene, random: Random) -> None:
    for name in ('"', "\n", "\u00e9" * 30, " ", "%s {0}", "\\"):
        made = mesh_object(name, *soup(random, 2))
        material = diffuse((0.5, 0.5, 0.5))
        material.name = name
        made.data.materials.append(material)


@damage("a library that is gone", None)
def _(_scene: Scene, random: Random) -> None:
    folder = Path(bpy.app.tempdir)
    first, second = folder / "first.blend", folder / "second.blend"
    thing = bpy.data.objects.new("Borrowed", mesh_object("Borrowed", *soup(random)).data)
    bpy.data.libraries.write(str(first), {thing})
    with bpy.data.libraries.load(str(first), link=True) as (_there, here):
        here.objects = [thing.name]
    holder = bpy.data.collections.new("Holder")
    holder.objects.link(here.objects[0])
    bpy.data.libraries.write(str(second), {holder})
    bpy.data.libraries.remove(bpy.data.libraries["first.blend"])
    bpy.data.collections.remove(holder)
    first.unlink()
    with bpy.data.libraries.load(str(second), link=True) as (_there, here):
        here.collections = ["Holder"]
    bpy.context.scene.collection.children.link(here.collections[0])


@damage("objects beyond all measure, and the smallest", None)
def _(_scene: Scene, random: Random) -> None:
    for distance in (1e12, 1e30, 3e38):
        mesh_object(f"Far {distance}", *soup(random)).location = (distance, 0.0, -distance)
    points, faces = soup(random)
    mesh_object("Dust", points * np.float32(1e-38), faces)


@damage("geometry nodes that move points to nowhere", "Scattered")
def _(_scene: Scene, random: Random) -> None:
    made = mesh_object("Scattered", *soup(random))
    group = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        group.inputs.new("NodeSocketGeometry", "Geometry")
        group.outputs.new("NodeSocketGeometry", "Geometry")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    move = group.nodes.new("GeometryNodeSetPosition")
    move.inputs["Offset"].default_value = (float(random.choice([nan, inf])), 0.0, 0.0)
    group.links.new(start.outputs[0], move.inputs[0])
    group.links.new(move.outputs[0], end.inputs[0])
    made.modifiers.new("Scatter", "NODES").node_group = group
