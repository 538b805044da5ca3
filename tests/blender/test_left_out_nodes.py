# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that Cycles does not know: their links are as if they were not there, and a report says so once."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import pytest

from addon import last_render
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.patch_nodes import Link, New, Socket
from support.small_scenes import Node, empty_scene, material, node, plane

KINDS = ["ShaderNodeShaderToRGB", "ShaderNodeSqueeze"]
Way = Callable[[New, Link, Socket, Socket], None]


def straight(_: New, link: Link, source: Socket, target: Socket) -> None:
    link(source, target)


def by_a_reroute(new: New, link: Link, source: Socket, target: Socket) -> None:
    reroute = new("NodeReroute")
    link(source, reroute.inputs[0])
    link(reroute.outputs[0], target)


def into_a_group(new: New, link: Link, source: Socket, target: Socket) -> None:
    inner = bpy.data.node_groups.new("Passes on", "ShaderNodeTree")
    if hasattr(inner, "interface"):
        for way in ("INPUT", "OUTPUT"):
            inner.interface.new_socket("Color", in_out=way, socket_type="NodeSocketColor")
    else:
        inner.inputs.new("NodeSocketColor", "Color")
        inner.outputs.new("NodeSocketColor", "Color")
    inner.links.new(inner.nodes.new("NodeGroupInput").outputs[0], inner.nodes.new("NodeGroupOutput").inputs[0])
    group = new("ShaderNodeGroup")
    group.node_tree = inner
    group.inputs[0].default_value = (0.15, 0.25, 0.55, 1.0)
    link(source, group.inputs[0])
    link(group.outputs[0], target)


def out_of_a_group(new: New, link: Link, source: Socket, target: Socket) -> None:
    inner = bpy.data.node_groups.new("Holds it", "ShaderNodeTree")
    if hasattr(inner, "interface"):
        inner.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    else:
        inner.outputs.new("NodeSocketColor", "Color")
    end = inner.nodes.new("NodeGroupOutput")
    end.inputs[0].default_value = (0.25, 0.35, 0.45, 1.0)
    inner.links.new(inner.nodes.new(source.node.bl_idname).outputs[0], end.inputs[0])
    group = new("ShaderNodeGroup")
    group.node_tree = inner
    link(group.outputs[0], target)


def shown(end: Callable[[New, Link, Node], Socket]) -> bpy.types.Scene:
    def build(kind: str) -> Callable[[New, Link], Socket]:
        def built(new: New, link: Link) -> Socket:
            left_out = new(kind)
            if left_out.inputs[0].type == "SHADER":
                link(node(new, "ShaderNodeBsdfDiffuse", Color=(0.2, 0.9, 0.1, 1.0)).outputs[0], left_out.inputs[0])
            return end(new, link, left_out)

        return built

    scene = empty_scene(4)
    for kind in KINDS:
        plane(0.0 if kind == KINDS[0] else -1.0, material(kind, build(kind)))
    return scene


def agree(scene: bpy.types.Scene) -> None:
    for thing in [thing for thing in scene.objects if thing.type == "MESH"]:
        others = [other for other in scene.objects if other.type == "MESH" and other != thing]
        for other in others:
            other.hide_render = True
        assert tyndall_pixels(scene) == pytest.approx(cycles_pixels(scene, samples=1, seed=1), abs=1e-6)
        name = thing.data.materials[0].name
        reports = [line for line in last_render.statistics_of("Scene")["reports"] if name in line]
        assert len(reports) == 1
        assert reports[0].endswith("is left out, as in Cycles: what it feeds keeps its own value")
        for other in others:
            other.hide_render = False


# Seen to fail with the groups' own values in 5.0, and without them before.
@pytest.mark.parametrize("way", [straight, by_a_reroute, into_a_group, out_of_a_group])
def test_what_they_feed_keeps_its_own_value(way: Way) -> None:
    def end(new: New, link: Link, left_out: Node) -> Socket:
        emission = node(new, "ShaderNodeEmission", Color=(0.3, 0.6, 0.9, 1.0))
        way(new, link, left_out.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    agree(shown(end))


def test_a_reroute_without_a_source_is_as_in_cycles() -> None:
    """0 up to 4.x, and then the value of the input."""

    def build(new: New, link: Link) -> Socket:
        emission = node(new, "ShaderNodeEmission", Color=(0.3, 0.6, 0.9, 1.0))
        link(new("NodeReroute").outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    scene = empty_scene(4)
    plane(0.0, material("Loose", build))
    assert tyndall_pixels(scene) == pytest.approx(cycles_pixels(scene, samples=1, seed=1), abs=1e-6)


def test_in_place_of_a_shader_they_are_none() -> None:
    def end(new: New, link: Link, left_out: Node) -> Socket:
        both = node(new, "ShaderNodeMixShader", Fac=0.3)
        link(left_out.outputs[0], both.inputs[1])
        link(new("ShaderNodeEmission").outputs[0], both.inputs[2])
        return both.outputs[0]

    agree(shown(end))
    agree(shown(lambda _new, _link, left_out: left_out.outputs[0]))
