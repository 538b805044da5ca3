# SPDX-License-Identifier: GPL-3.0-or-later
"""Two nodes in the artist's compositor: one reads the light shafts' scene, one lays them over the picture.

They are known by a mark, not by name, and go between the output node and what fed it; all other nodes and links stay.
From Blender 5.0 on the nodes are a group that scenes may share, and end in its output.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..node_groups import add_socket, mark, part_of
from .compose_group import INPUTS_OF_PASSES, compose_group

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bpy.types import Node, NodeSocket, NodeTree, Scene

HAS_GROUPS = bpy.app.version >= (5, 0, 0)

#: Marks of our nodes.
SHAFTS_LAYER, COMPOSE, MADE_FOR_US = "SHAFTS_LAYER", "COMPOSE", "MADE_FOR_US"
_SWITCHED = {SHAFTS_LAYER, COMPOSE}


def tree_of(scene: Scene) -> NodeTree | None:
    """The nodes that the scene's compositor runs through; None where it has none, or does without."""
    if HAS_GROUPS:
        return scene.compositing_node_group
    return scene.node_tree if scene.use_nodes else None


def why_locked(scene: Scene) -> str | None:
    """Why the compositor's nodes cannot be changed; None: they can."""
    if scene.library is not None or scene.override_library is not None:
        return f'Scene "{scene.name}" is linked: its compositor cannot be changed. Make it local, or append it'
    return _why_group_locked(scene) if HAS_GROUPS else _why_switched_off(scene)


def _why_switched_off(scene: Scene) -> str | None:
    """Up to Blender 4.5: nodes that the artist does without must not come into force by our switch."""
    if scene.use_nodes or scene.node_tree is None or len(scene.node_tree.nodes) == 0:
        return None
    return "The compositor has nodes that Use Nodes switches off: switch it on, or remove them"


def _why_group_locked(scene: Scene) -> str | None:
    tree = scene.compositing_node_group
    if tree is None:
        return None
    if tree.library is not None or tree.override_library is not None:
        return f'The compositor\'s group "{tree.name}" is linked: make it local first'
    sharing = [other.name for other in bpy.data.scenes if other != scene and other.compositing_node_group == tree]
    if sharing:
        return f'The compositor\'s group "{tree.name}" is that of scene "{sharing[0]}", too: make it single-user first'
    return None


def our_nodes(scene: Scene) -> list[Node]:
    """The nodes that the switch mutes."""
    tree = tree_of(scene)
    return [] if tree is None else [node for node in tree.nodes if part_of(node) in _SWITCHED]


def compose_node(scene: Scene) -> Node | None:
    """The one whose inputs are the settings: that before the output, of several the first."""
    return next((node for node in our_nodes(scene) if part_of(node) == COMPOSE), None)


def connect(scene: Scene, shafts: Scene) -> None:
    """Add what is missing of our nodes and their links. Does nothing where all is there."""
    tree = tree_of(scene)
    if tree is None:
        tree = new_tree(scene)
        scene.tyndall.over_engine.has_own_tree = True
    layer = _shafts_layer(tree, shafts)
    if layer.scene != shafts:
        layer.scene = shafts
    _set_layer(layer, shafts)
    for node in [node for node in tree.nodes if part_of(node) == COMPOSE]:
        _mend(tree, layer, node)
    for output in outputs_of(tree):
        if not _has_shafts(output):
            _insert(tree, scene, layer, output)


def disconnect(scene: Scene) -> None:
    """Remove our nodes, and link what they stood between."""
    tree = tree_of(scene)
    if tree is None:
        return
    for node in [node for node in tree.nodes if part_of(node) == COMPOSE]:
        source = _source(node.inputs["Image"]) if "Image" in node.inputs else None
        for link in list(node.outputs["Image"].links) if source is not None else ():
            tree.links.new(source, link.to_socket)
        tree.nodes.remove(node)
    for node in list(tree.nodes):
        if part_of(node) == SHAFTS_LAYER:
            tree.nodes.remove(node)
    _remove_made(scene, tree)


def problems(scene: Scene, shafts: Scene | None) -> list[str]:
    """What keeps our nodes from showing in a render, each with its remedy."""
    tree = tree_of(scene)
    if tree is None:
        return []
    found = []
    layers = [node for node in tree.nodes if part_of(node) == SHAFTS_LAYER]
    if shafts is None:
        found.append("The scene that renders the light shafts was deleted: the picture has none until Set Up Again")
    elif not layers or layers[0].scene != shafts:
        found.append("No node reads the light shafts of this scene: Set Up Again")
    composing = [node for node in tree.nodes if part_of(node) == COMPOSE]
    if any(node.node_tree is None for node in composing):
        found.append("The node group of the light shafts is missing: the picture is black until Set Up Again")
    found += [
        f'The light shafts do not reach "{output.node.name}": Set Up Again, or link them yourself'
        for output in outputs_of(tree)
        if not _has_shafts(output)
    ]
    if scene.tyndall.over_engine.is_enabled and any(node.mute for node in (*layers, *composing)):
        found.append("A node of the light shafts is muted in the compositor")
    if not scene.render.use_compositing:
        found.append("Compositing is off in the Output properties, Post Processing")
    return found


def new_tree(scene: Scene) -> NodeTree:
    """For a scene that has none: with an output and nothing else."""
    if HAS_GROUPS:
        tree = bpy.data.node_groups.new(f"{scene.name} Compositing", "CompositorNodeTree")
        add_socket(tree, "Image", "NodeSocketColor", is_output=True)
        scene.compositing_node_group = tree
        mark(tree.nodes.new("NodeGroupOutput"), MADE_FOR_US)
        return tree
    scene.use_nodes = True
    tree = tree_of(scene)
    tree.nodes.clear()  # Blender's defaults
    mark(tree.nodes.new("CompositorNodeComposite"), MADE_FOR_US)
    return tree


def _remove_made(scene: Scene, tree: NodeTree) -> None:
    """What was made because the artist had nothing there, unless it has been worked with since."""
    made = [node for node in tree.nodes if part_of(node) == MADE_FOR_US]
    if scene.tyndall.over_engine.has_own_tree:
        scene.tyndall.over_engine.has_own_tree = False
        if len(made) < len(tree.nodes):
            return
        if HAS_GROUPS:
            bpy.data.node_groups.remove(tree)
        else:
            tree.nodes.clear()
            scene.use_nodes = False
        return
    outputs = outputs_of(tree)
    for node in made:
        if all(link.to_socket in outputs for link in node.outputs["Image"].links):
            tree.nodes.remove(node)


def outputs_of(tree: NodeTree) -> list[NodeSocket]:
    """The image inputs of the nodes that a render ends in."""
    if HAS_GROUPS:
        nodes = [node for node in tree.nodes if node.bl_idname == "NodeGroupOutput" and node.is_active_output]
        return [next(socket for socket in node.inputs if socket.type == "RGBA") for node in nodes if node.inputs]
    return [node.inputs["Image"] for node in tree.nodes if node.bl_idname == "CompositorNodeComposite"]


def _source(socket: NodeSocket) -> NodeSocket | None:
    return socket.links[0].from_socket if socket.is_linked else None


def _has_shafts(output: NodeSocket) -> bool:
    return any(part_of(node) == COMPOSE for node in _upstream(output.node))


def _upstream(node: Node) -> Iterator[Node]:
    """All nodes that feed this one."""
    seen, waiting = set(), [node]
    while waiting:
        for socket in waiting.pop().inputs:
            for link in socket.links:
                if link.from_node not in seen:
                    seen.add(link.from_node)
                    waiting.append(link.from_node)
                    yield link.from_node


def _shafts_layer(tree: NodeTree, shafts: Scene) -> Node:
    """The node that reads the shafts' scene; made where there is none."""
    for node in tree.nodes:
        if part_of(node) == SHAFTS_LAYER:
            return node
    node = tree.nodes.new("CompositorNodeRLayers")
    node.name, node.label = "Light Shafts Layer", "Light Shafts"
    mark(node, SHAFTS_LAYER)
    node.scene = shafts
    outputs = outputs_of(tree)
    if outputs:
        x, y = outputs[0].node.location
        node.location = (x - 560.0, y + 460.0)
    return node


def _set_layer(layer: Node, shafts: Scene) -> None:
    if layer.layer != shafts.view_layers[0].name:
        layer.layer = shafts.view_layers[0].name


def _mend(tree: NodeTree, layer: Node, node: Node) -> None:
    """Give a node its group and its links from the shafts' scene, where they are missing."""
    if node.node_tree is None:
        node.node_tree = compose_group()
    for name, output in INPUTS_OF_PASSES.items():
        socket = node.inputs[name]
        if not socket.is_linked:
            tree.links.new(layer.outputs[output], socket)


def _insert(tree: NodeTree, scene: Scene, layer: Node, output: NodeSocket) -> None:
    """Between an output and what feeds it; where nothing does, the scene's own picture."""
    source = _source(output)
    if source is None:
        picture = tree.nodes.new("CompositorNodeRLayers")
        picture.scene = scene
        picture.location = (output.node.location.x - 560.0, output.node.location.y)
        mark(picture, MADE_FOR_US)
        source = picture.outputs["Image"]
    node = tree.nodes.new("CompositorNodeGroup")
    node.node_tree = compose_group()
    node.name = node.label = "Light Shafts"
    node.location = (output.node.location.x - 240.0, output.node.location.y + 220.0)
    node.width = 200.0
    mark(node, COMPOSE)
    _mend(tree, layer, node)
    tree.links.new(source, node.inputs["Image"])
    tree.links.new(node.outputs["Image"], output)
