# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and objects that are broken."""

from __future__ import annotations

from math import inf, nan

import bpy
import numpy as np

from support.damages import Random, Scene, damage, mesh_object, soup, spoiled_soup, textured


# --- meshes ----------------------------------------------------------------------------------------------------------
@damage("vertices that are not a number", "NaN Mesh")
def _(_scene: Scene, random: Random) -> None:
    spoiled_soup("NaN Mesh", random, nan)


@damage("vertices at infinity", "Infinite Mesh")
def _(_scene: Scene, random: Random) -> None:
    spoiled_soup("Infinite Mesh", random, float(random.choice([inf, -inf])))


@damage("vertices whose squares overflow", None)
def _(_scene: Scene, random: Random) -> None:
    spoiled_soup("Huge Mesh", random, float(random.choice([1e15, -1e25, 3e38])))


@damage("a mesh of nothing", None)
def _(_scene: Scene, random: Random) -> None:
    mesh_object("Empty Mesh", np.zeros((int(random.integers(0, 3)), 3)), [])


@damage("triangles without an area", None)
def _(_scene: Scene, random: Random) -> None:
    points, faces = soup(random)
    points[1::3], points[2::3] = (
        points[0::3],
        points[0::3] + random.choice([0.0, 1e-30, 1e-6]),
    )
    mesh_object("Flat Mesh", points, faces)


@damage("UVs that are not a number", None)
def _(_scene: Scene, random: Random) -> None:
    made = mesh_object("NaN UV", *soup(random))
    layer = made.data.uv_layers.new(name="UVMap")
    layer.data.foreach_set("uv", np.full(len(made.data.loops) * 2, nan, np.float32))
    made.data.materials.append(textured(bpy.data.images.new("White", 4, 4)))


@damage("more material slots asked for than there are", None)
def _(_scene: Scene, random: Random) -> None:
    made = mesh_object("Wrong Slots", *soup(random))
    made.data.polygons.foreach_set(
        "material_index",
        random.integers(0, 30000, len(made.data.polygons)).astype(np.int32),
    )


@damage("twenty thousand slivers in one place", None)
def _(_scene: Scene, random: Random) -> None:
    points = random.normal(size=(3 * 20000, 3)).astype(np.float32) * (
        1e-5,
        1e-5,
        1.0,
    ) + (1.5, 1.5, 1.5)
    mesh_object("Slivers", points, [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(20000)])


# --- objects ---------------------------------------------------------------------------------------------------------
@damage("a scale of zero", None)
def _(_scene: Scene, random: Random) -> None:
    scale = np.where(random.random(3) < 0.5, 0.0, 1.0)
    scale[random.integers(3)] = 0.0
    mesh_object("No Scale", *soup(random)).scale = scale


@damage("a matrix that is not a number", "NaN Object")
def _(_scene: Scene, random: Random) -> None:
    made = mesh_object("NaN Object", *soup(random))
    made.location[int(random.integers(3))] = nan
    made.scale[int(random.integers(3))] = float(random.choice([nan, 1.0]))


@damage("an object at infinity", "Lost Object")
def _(_scene: Scene, random: Random) -> None:
    mesh_object("Lost Object", *soup(random)).location[int(random.integers(3))] = float(random.choice([inf, -inf]))


@damage("scales from tiny to huge", None)
def _(_scene: Scene, random: Random) -> None:
    for exponent in (-38, -20, 20):
        mesh_object(f"Scale 1e{exponent}", *soup(random)).scale = (10.0**exponent,) * 3


@damage("an instance of nothing, and one of an empty collection", None)
def _(scene: Scene, _random: Random) -> None:
    for name, collection in (
        ("Instance of None", None),
        ("Instance of Nothing", bpy.data.collections.new("Nothing")),
    ):
        made = bpy.data.objects.new(name, None)
        made.instance_type, made.instance_collection = "COLLECTION", collection
        scene.collection.objects.link(made)


@damage("instances under a scale of zero and of not a number", "Shared")
def _(scene: Scene, random: Random) -> None:
    inside = bpy.data.collections.new("Shared")
    inside.objects.link(bpy.data.objects.new("Shared", mesh_object("Shared", *soup(random)).data))
    for name, scale in (("Flat Instance", 0.0), ("NaN Instance", nan)):
        made = bpy.data.objects.new(name, None)
        made.instance_type, made.instance_collection, made.scale = (
            "COLLECTION",
            inside,
            (1, scale, 1),
        )
        scene.collection.objects.link(made)


@damage("geometry nodes without an output", None)
def _(_scene: Scene, random: Random) -> None:
    made = mesh_object("No Output", *soup(random))
    made.modifiers.new("Nodes", "NODES").node_group = bpy.data.node_groups.new("Void", "GeometryNodeTree")
