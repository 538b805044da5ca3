# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Denoise node on our denoising data: put into the artist's compositor, and taken out of it.

A node goes between each Render Layers node of the scene and what its picture fed; all other nodes and links stay. It is
Blender's own, with OpenImageDenoise inside where Blender was built with it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from .node_groups import mark, part_of
from .over_engine.compositor import new_tree, outputs_of, tree_of, why_locked

if TYPE_CHECKING:
    from bpy.types import Node, NodeTree, Scene

#: Mark of our nodes.
DENOISE = "DENOISE"
#: Inputs of Blender's node by the pass that goes in.
_INPUTS = {"Denoising Normal": "Normal", "Denoising Albedo": "Albedo"}


def is_built_in() -> bool:
    """Whether this Blender has OpenImageDenoise; Debian's has not. Cycles' module knows."""
    try:
        cycles = importlib.import_module("_cycles")
    except ImportError:
        return False
    return bool(getattr(cycles, "with_openimagedenoise", False))


def why_not(scene: Scene) -> str | None:
    """Why the picture cannot be denoised; None: it can."""
    if not is_built_in():
        return "This Blender was built without OpenImageDenoise: its Denoise node would do nothing"
    return why_locked(scene)


def nodes_of(scene: Scene) -> list[Node]:
    """Those that were put in."""
    tree = tree_of(scene)
    return [] if tree is None else [node for node in tree.nodes if part_of(node) == DENOISE]


def set_up(scene: Scene) -> None:
    """Put in what is missing, with the passes that it asks for."""
    tree = tree_of(scene) or new_tree(scene)
    layers = [node for node in tree.nodes if node.bl_idname == "CompositorNodeRLayers" and node.scene == scene]
    if not layers:
        layers = [_new_layer(tree, scene)]
    for layer in layers:
        scene.view_layers[layer.layer].tyndall.use_pass_denoising_data = True
    for layer in layers:
        _denoise(tree, layer)
    scene.render.use_compositing = True


def remove(scene: Scene) -> None:
    """Link what the nodes stood between. The passes stay."""
    tree = tree_of(scene)
    for node in nodes_of(scene):
        picture = node.inputs["Image"]
        if picture.is_linked:
            source = picture.links[0].from_socket
            for link in list(node.outputs["Image"].links):
                tree.links.new(source, link.to_socket)
        tree.nodes.remove(node)


def _new_layer(tree: NodeTree, scene: Scene) -> Node:
    layer = tree.nodes.new("CompositorNodeRLayers")
    layer.scene = scene
    for output in outputs_of(tree):
        if not output.is_linked:
            layer.location = (output.node.location.x - 560.0, output.node.location.y)
            tree.links.new(layer.outputs["Image"], output)
    return layer


def _denoise(tree: NodeTree, layer: Node) -> None:
    fed = [link.to_socket for link in layer.outputs["Image"].links]
    node = next((socket.node for socket in fed if part_of(socket.node) == DENOISE), None)
    if node is None:
        if not fed:
            return  # nobody sees its picture
        node = tree.nodes.new("CompositorNodeDenoise")
        node.name = node.label = "Denoise"
        node.location = (layer.location.x + 300.0, layer.location.y + 40.0)
        mark(node, DENOISE)
        tree.links.new(layer.outputs["Image"], node.inputs["Image"])
        for socket in fed:
            tree.links.new(node.outputs["Image"], socket)
    for output, socket in _INPUTS.items():
        if not node.inputs[socket].is_linked:
            tree.links.new(layer.outputs[output], node.inputs[socket])
