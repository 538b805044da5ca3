# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions as datablocks: made, copied, and where a layer's colour ramp is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from .animation_paths import make_actions_own

if TYPE_CHECKING:
    from bpy.types import ColorRamp, Context, NodeTree

    from .properties.light_shafts import TyndallLightShaftSettings
    from .properties.transfer_functions import TyndallTransferState
    from .properties.transfer_layers import TyndallTransferLayer

Rgba = tuple[float, float, float, float]

_RAMP = "ShaderNodeValToRGB"
#: Of one ramp below the other, in the node editor.
_RAMP_SPACING = 260.0


def new_function(name: str) -> NodeTree:
    """A function without layers, which changes nothing; kept by the file until it is removed."""
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    tree.tyndall.is_transfer_function = True
    tree.use_fake_user = True
    return tree


def copy_function(tree: NodeTree) -> NodeTree:
    """All of it, keys and drivers included: a copy of a datablock shares its action, this one has its own."""
    copied = tree.copy()
    copied.use_fake_user = True
    make_actions_own(copied)
    return copied


def keep_ramp(layer: TyndallTransferLayer) -> None:
    """Give a gradient a ramp, black to white, unless it has one or its function is linked."""
    if layer.kind == "GRADIENT" and ramp_of(layer) is None and layer.id_data.library is None:
        nodes = layer.id_data.nodes
        node = nodes.new(_RAMP)
        node.location = (0.0, -_RAMP_SPACING * (len(nodes) - 1))
        node.name = node.label = layer.name
        layer.ramp_node = node.name


def ramp_of(layer: TyndallTransferLayer) -> ColorRamp | None:
    """Of a gradient; None where its node was removed or renamed."""
    node = layer.id_data.nodes.get(layer.ramp_node)
    return node.color_ramp if node is not None and node.bl_idname == _RAMP else None


def remove_ramp(layer: TyndallTransferLayer) -> None:
    """With its keys."""
    if ramp_of(layer) is not None:
        layer.id_data.nodes.remove(layer.id_data.nodes[layer.ramp_node])


def set_stops(ramp: ColorRamp, stops: list[tuple[float, Rgba]]) -> None:
    """Replace what the ramp has: positions in [0, 1], scene-linear colours with alpha; at most 32."""
    while len(ramp.elements) > 1:
        ramp.elements.remove(ramp.elements[-1])
    for number, (position, colour) in enumerate(stops):
        element: Any = ramp.elements[0] if number == 0 else ramp.elements.new(position)
        element.position, element.color = position, colour


def copy_ramp(source: TyndallTransferLayer, target: TyndallTransferLayer) -> None:
    """Of one gradient to another; where one of them has none, nothing."""
    original, ramp = ramp_of(source), ramp_of(target)
    if original is None or ramp is None:
        return
    ramp.color_mode, ramp.hue_interpolation = original.color_mode, original.hue_interpolation
    ramp.interpolation = original.interpolation
    set_stops(ramp, [(element.position, tuple(element.color)) for element in original.elements])


def active_state(shafts: TyndallLightShaftSettings) -> TyndallTransferState | None:
    """The state whose function is shown and edited."""
    states = shafts.transfer_states
    return states[shafts.active_transfer_state] if shafts.active_transfer_state < len(states) else None


def edited_function(context: Context) -> NodeTree | None:
    """That of the scene's active state."""
    state = active_state(context.scene.tyndall.shafts)
    return state.function if state is not None else None


def why_not_editable(tree: NodeTree | None) -> str | None:
    """What a button says that works on the edited function; None: it may."""
    if tree is None:
        return "Make a transfer function first, or choose one"
    if tree.library is not None:
        return "The transfer function is linked: make it local, or a library override of it"
    return None
