# SPDX-License-Identifier: GPL-3.0-or-later
"""All that a tool of ours may change in a file, as plain values: equal states are the same work of an artist.

Pixels of images are left out: Blender's undo does not keep what a script writes there.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import Any

import bpy

from addon.animation_paths import animated_paths
from addon.shader_nodes import shader_tree


def file_state() -> dict[str, Any]:
    """Of the open file, by where it is."""
    scene = bpy.context.scene
    owners = [*bpy.data.scenes, *bpy.data.lights, *bpy.data.objects, *bpy.data.node_groups, *scene.view_layers]
    return {
        **{repr(owner): _of_group(owner.tyndall) for owner in owners if hasattr(owner, "tyndall")},
        **{f"voxels of {thing!r}": _of_group(thing.tyndall_voxels) for thing in bpy.data.objects},
        "corners": [(data.name, [tuple(vertex.co) for vertex in data.vertices]) for data in bpy.data.meshes],
        **{f"keys of {owner!r}": _keys(owner) for owner in (*bpy.data.scenes, *bpy.data.lights, *bpy.data.node_groups)},
        **{f"nodes of {tree!r}": _nodes(tree) for tree in _trees()},
        "objects": [(thing.name, thing.select_get(), tuple(map(tuple, thing.matrix_world))) for thing in scene.objects],
        "active": getattr(bpy.context.view_layer.objects.active, "name", None),
        "images": [(image.name, tuple(image.size)) for image in bpy.data.images],
        "frame": scene.frame_current_final,
    }


def _of_group(group: bpy.types.PropertyGroup) -> dict[str, Any]:
    return {
        name: _of_value(getattr(group, name), rna)
        for name, rna in group.bl_rna.properties.items()
        if name not in {"rna_type", "name"} or rna.type == "STRING"
    }


def _of_value(value: Any, rna: bpy.types.Property) -> Any:
    if rna.type == "COLLECTION":
        return [_of_group(item) for item in value]
    if rna.type == "POINTER":
        return value.name if isinstance(value, bpy.types.ID) else value and _of_group(value)
    return tuple(value) if getattr(rna, "is_array", False) else value


def _keys(owner: bpy.types.ID) -> list[Any]:
    keyed, driven = animated_paths(owner)
    curves = [(curve.data_path, curve.array_index, _keys_of(curve)) for curve in chain(*keyed.values())]
    return [sorted(curves), sorted(driven)]


def _keys_of(curve: bpy.types.FCurve) -> list[Any]:
    return [(*key.co, key.interpolation) for key in curve.keyframe_points]


def _trees() -> Iterator[bpy.types.NodeTree]:
    yield from bpy.data.node_groups
    yield from (tree for owner in (*bpy.data.materials, *bpy.data.worlds) if (tree := shader_tree(owner)) is not None)
    if (compositor := getattr(bpy.context.scene, "node_tree", None)) is not None:  # a node group from 5.0 on
        yield compositor


def _nodes(tree: bpy.types.NodeTree) -> list[Any]:
    nodes = [(node.name, node.mute, _stops(node)) for node in tree.nodes]
    links = [
        (link.from_node.name, link.from_socket.name, link.to_node.name, link.to_socket.name) for link in tree.links
    ]
    return [sorted(nodes), sorted(links)]


def _stops(node: bpy.types.Node) -> list[Any]:
    ramp = getattr(node, "color_ramp", None)
    return [] if ramp is None else [(stop.position, tuple(stop.color)) for stop in ramp.elements]
