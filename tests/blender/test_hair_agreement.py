# SPDX-License-Identifier: GPL-3.0-or-later
"""Is hair as in Cycles? Particle hair, hair curves and point clouds under a sun, their shadows, and their shafts."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from support.cycles_reference import rendered_pixels
from support.hair_scenes import agree, block_means, both_engines, diffuse, furry, made_by_nodes, stage
from support.small_scenes import CUBE_FACES, add, material, mesh, node, read


@pytest.mark.dealt
@pytest.mark.parametrize("shape", ["RIBBONS", "THICK"])
def test_particle_hair_is_lit_and_throws_shadows_as_in_cycles(shape: str) -> None:
    scene = stage()
    patch = furry(scene, shape)
    ours, cycles = both_engines(scene)
    agree(f"particles_{shape.lower()}", ours, cycles)
    patch.modifiers[0].show_render = False
    scene.render.engine = "TYNDALL"
    assert np.abs(rendered_pixels(scene) - ours).mean() > 0.1 * ours.mean()  # the hair is what was compared


@pytest.mark.dealt
def test_children_and_hidden_emitters_are_as_in_cycles() -> None:
    scene = stage()
    patch = furry(scene, "RIBBONS")
    settings = patch.particle_systems[0].settings
    settings.count, settings.child_type = 40, "SIMPLE"
    settings.rendered_child_count = 10
    settings.child_radius = 0.15
    patch.show_instancer_for_render = False
    agree("children", *both_engines(scene))


@pytest.mark.dealt
@pytest.mark.parametrize("shape", ["RIBBONS", "THICK"])
def test_hair_curves_are_as_in_cycles(shape: str) -> None:
    """A thick arc that turns in space."""
    scene = stage()
    scene.cycles_curves.shape = shape
    arc = {"Resolution": 7, "Start": (-0.8, 0.0, -0.3), "Middle": (0.0, 0.8, 1.6), "End": (0.8, -0.3, -0.3)}
    look = {"Material": diffuse("Hair", (0.7, 0.45, 0.2, 1))}
    thing = made_by_nodes(
        bpy.data.hair_curves.new("Hair"),
        [
            ("GeometryNodeCurveQuadraticBezier", arc),
            ("GeometryNodeCurveSplineType", {}),
            ("GeometryNodeSetCurveRadius", {"Radius": 0.1}),
            ("GeometryNodeSetMaterial", look),
        ],
    )
    assert thing.type == "CURVES"
    assert len(read().strand_objects) == 1
    agree(f"curves_{shape.lower()}", *both_engines(scene))


IN_4 = pytest.mark.skipif(bpy.app.version < (4, 0, 0), reason="3.x makes balls of what is drawn once")


@pytest.mark.dealt
@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), pytest.param((0.5, 1.2, -1.5), marks=IN_4)])
def test_point_clouds_are_as_in_cycles(scale: tuple[float, float, float]) -> None:
    """Seen to fail with the normals of the ellipsoids that points are under an uneven scale."""
    scene = stage()
    corners = [(0.3 * x, 0.3 * y, 0.3 * z) for x in (-2, -1, 1, 2) for y in (-1, 1) for z in (1, 3)]
    look = {"Material": diffuse("Beads", (0.7, 0.45, 0.2, 1))}
    beads = made_by_nodes(
        mesh("Corners", corners, []),
        [("GeometryNodeMeshToPoints", {"Radius": 0.13}), ("GeometryNodeSetMaterial", look)],
    )
    beads.scale = scale
    assert sum(len(group.object_names) for group in read().strand_objects) == 1
    agree(f"points_{scale[0]}", *both_engines(scene))


@pytest.mark.dealt
@pytest.mark.parametrize("output", ["Intercept", "Length", "Thickness", "Random", "Tangent Normal"])
def test_hair_info_is_as_in_cycles(output: str) -> None:
    """As colours that glow: where a point lies on its hair, how thick that is, and the direction to the viewer."""
    scale = 10.0 if output == "Thickness" else 1.0
    scene = stage()
    patch = furry(scene, "THICK")

    def glowing(new, link):  # noqa: ANN001, ANN202
        info = new("ShaderNodeHairInfo")
        times = new("ShaderNodeVectorMath")
        times.operation = "ABSOLUTE"
        link(info.outputs[output], times.inputs[0])
        emission = node(new, "ShaderNodeEmission", Strength=scale)
        link(times.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    patch.data.materials[1] = material(f"Hair {output}", glowing)
    for name in ("Floor", "Skin"):  # Cycles lights them by the hair
        bpy.data.materials[name].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0, 0, 0, 1)
    ours, cycles = both_engines(scene)
    agree("info_" + output.lower().replace(" ", "_"), ours, cycles)


@pytest.mark.dealt
@pytest.mark.parametrize("source", ["ShaderNodeUVMap", "ShaderNodeVertexColor"])
@pytest.mark.parametrize("child_type", ["NONE", "SIMPLE"])
def test_hair_has_the_colours_of_its_emitter_as_in_cycles(source: str, child_type: str) -> None:
    """Seen to fail: both were asked for without the names of what Blender lets be left out, which is an error."""
    scene = stage()
    patch = furry(scene, "THICK")
    settings = patch.particle_systems[0].settings
    settings.child_type, settings.rendered_child_count = child_type, 3
    settings.count = 300 if child_type == "NONE" else 100
    patch.data.uv_layers.new(name="Rooted")
    patch.data.vertex_colors.new(name="Painted")
    for corner, (u, v) in enumerate([(0, 0), (1, 0.2), (0.8, 1), (0.1, 0.7)]):
        patch.data.uv_layers["Rooted"].data[corner].uv = (u, v)
        patch.data.vertex_colors["Painted"].data[corner].color = (u, v, 0.3, 1.0)

    def painted(new, link):  # noqa: ANN001, ANN202
        bsdf = new("ShaderNodeBsdfDiffuse")
        read_from = new(source)
        if source == "ShaderNodeVertexColor":
            read_from.layer_name = "Painted"  # without a name, Cycles' hair is black
        link(read_from.outputs[0], bsdf.inputs["Color"])
        return bsdf.outputs[0]

    patch.data.materials[1] = material("Painted hair", painted)
    ours, cycles = both_engines(scene)
    agree(f"{source}_{child_type}".lower(), ours, cycles)
    patch.data.materials[1] = diffuse("Grey hair", (0.5, 0.5, 0.5, 1))
    scene.render.engine = "TYNDALL"
    assert np.abs(rendered_pixels(scene) - ours).mean() > 0.05 * ours.mean()


@pytest.mark.dealt
@pytest.mark.parametrize("shape", ["mesh", "points", "hair"])
def test_what_goes_by_no_colours_name_is_black_without_colours_as_in_cycles(shape: str) -> None:
    """Beside another attribute that the material reads. Seen to fail: that answered, and on hair the first colour."""

    def painted(new, link):  # noqa: ANN001, ANN202
        bsdf, both = new("ShaderNodeBsdfDiffuse"), new("ShaderNodeMixRGB")
        both.blend_type = "ADD"
        other = node(new, "ShaderNodeAttribute")
        other.attribute_name = "Painted" if shape == "hair" else "UVMap" if shape == "mesh" else "radius"
        link(new("ShaderNodeVertexColor").outputs[0], both.inputs[1])
        link(other.outputs["Color"], both.inputs[2])
        link(both.outputs[0], bsdf.inputs["Color"])
        return bsdf.outputs[0]

    scene, look = stage(), material("Painted", painted)
    if shape == "hair":
        patch = furry(scene, "THICK")
        patch.data.vertex_colors.new(name="Painted")
        for corner in patch.data.vertex_colors["Painted"].data:
            corner.color = (0.3, 0.6, 0.9, 1.0)
        patch.data.materials[1] = look
    elif shape == "points":
        made_by_nodes(
            mesh("Corners", [(0.3 * x, 0.3 * y, 0.5) for x in (-2, -1, 1, 2) for y in (-1, 1)], []),
            [("GeometryNodeMeshToPoints", {"Radius": 0.13}), ("GeometryNodeSetMaterial", {"Material": look})],
        )
    else:
        add("Sheet", mesh("Sheet", [(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], [(0, 1, 2, 3)], look))
        bpy.data.meshes["Sheet"].uv_layers.new(name="UVMap")
    ours, cycles = both_engines(scene)
    agree(f"no_name_{shape}", ours, cycles)
    scene.render.engine = "TYNDALL"
    tree = look.node_tree
    tree.links.remove(next(one for one in tree.links if one.from_node.bl_idname == "ShaderNodeAttribute"))
    assert np.abs(rendered_pixels(scene) - ours).mean() > 0.01 * ours.mean()  # the other attribute is seen


def in_fog(scene: bpy.types.Scene, method: str) -> None:
    fog = material("Fog", None, lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.4).outputs[0])
    box = add("Fog", mesh("Fog", [(x, y, z) for x in (-3, 3) for y in (-6, 3) for z in (-2, 4)], CUBE_FACES, fog))
    box.display_type = "WIRE"
    scene.tyndall.shafts.method, scene.tyndall.shafts.resolution = method, 4096


@pytest.mark.dealt
@pytest.mark.parametrize("method", ["EPIPOLAR", pytest.param("SHADOW_MAP", marks=pytest.mark.long), "EXACT"])
def test_a_lock_of_hair_throws_shafts_as_in_cycles(method: str) -> None:
    """A furry patch hangs over a box of fog's floor, and dims the sun in the fog below."""
    scene = stage()
    patch = furry(scene, "RIBBONS")
    patch.location = (0.0, 0.0, 0.6)
    patch.show_instancer_for_render = False
    in_fog(scene, method)
    agree(f"shafts_{method.lower()}", *both_engines(scene))


def partly_clear(name: str, info: str = "") -> bpy.types.Material:
    """Diffuse, of which a tinted part lets light pass: 0.6 of it, or what Hair Info's output says."""

    def shader(new, link):  # noqa: ANN001, ANN202
        mix = node(new, "ShaderNodeMixShader", Fac=0.6)
        if info:
            link(new("ShaderNodeHairInfo").outputs[info], mix.inputs["Fac"])
        solid = node(new, "ShaderNodeBsdfDiffuse", Color=(0.7, 0.45, 0.2, 1))
        clear = node(new, "ShaderNodeBsdfTransparent", Color=(0.9, 1.0, 0.7, 1))
        link(solid.outputs[0], mix.inputs[1])
        link(clear.outputs[0], mix.inputs[2])
        return mix.outputs[0]

    return material(name, shader)


@pytest.mark.dealt
@pytest.mark.parametrize("info", ["", "Intercept"])
@pytest.mark.parametrize("shape", ["RIBBONS", "THICK"])
def test_hair_lets_a_part_of_the_light_pass_as_in_cycles(shape: str, info: str) -> None:
    """On the way of camera and sun, all of a hair alike, or less towards its tip. Seen to fail: hair was opaque."""
    scene = stage()
    patch = furry(scene, shape)
    opaque, _ = both_engines(scene, 16)
    patch.data.materials[1] = partly_clear("Clear", info)
    ours, cycles = both_engines(scene)
    # Cycles' rays leave out the piece of a tube that they meet, and not the next ones, which they may be within.
    bound = 0.01 if shape == "RIBBONS" else 0.025
    agree(f"clear_{shape.lower()}_{info or 'even'}", ours, cycles, mean_bound=bound, median_bound=bound)
    assert np.abs(ours - opaque).mean() > 0.05 * opaque.mean()


@pytest.mark.dealt
def test_points_let_a_part_of_the_light_pass_as_in_cycles() -> None:
    """One sphere stands for one layer, as Cycles culls what is met from within."""
    scene = stage()
    corners = [(0.3 * x, 0.3 * y, 0.3 * z) for x in (-2, -1, 1, 2) for y in (-1, 1) for z in (1, 3)]
    look = {"Material": partly_clear("Clear beads")}
    made_by_nodes(
        mesh("Corners", corners, []),
        [("GeometryNodeMeshToPoints", {"Radius": 0.2}), ("GeometryNodeSetMaterial", look)],
    )
    agree("clear_points", *both_engines(scene))


@pytest.mark.dealt
@pytest.mark.parametrize("method", ["EPIPOLAR", pytest.param("SHADOW_MAP", marks=pytest.mark.long), "EXACT"])
def test_hair_that_lets_light_pass_throws_shafts_as_much_weaker(method: str) -> None:
    """Less towards the tips. Nothing is seen but fog. Seen to fail: as opaque hair, and as none, does.

    Thin hair: Cycles' bands let rays pass that begin within two radii of them, and fog there is lit.
    """
    scene = stage()
    patch = furry(scene, "RIBBONS")
    settings = patch.particle_systems[0].settings
    settings.radius_scale, settings.count = 0.2, 1500
    patch.location = (0.0, 0.0, 0.6)
    patch.show_instancer_for_render = False
    patch.data.materials[1] = partly_clear("Clear", "Intercept")
    patch.visible_camera = bpy.data.objects["Plane"].visible_camera = False
    in_fog(scene, method)
    ours, cycles = both_engines(scene)
    agree(f"clear_shafts_{method.lower()}", ours, cycles)
    patch.hide_render = True
    scene.render.engine = "TYNDALL"
    shade = block_means(rendered_pixels(scene)) - block_means(cycles)
    left = block_means(ours) - block_means(cycles)
    print("of the shade", left.mean() / shade.mean(), np.abs(left).mean() / np.abs(shade).mean())
    assert abs(left.mean()) < 0.05 * shade.mean()
    assert np.abs(left).mean() < 0.1 * np.abs(shade).mean()


def test_an_empty_system_and_broken_radii_are_named_once() -> None:
    scene = stage()
    patch = furry(scene, "RIBBONS")
    patch.particle_systems[0].settings.count = 0
    assert [line for line in read().reports if "Patch" in line] == [
        'Object "Patch", particle system "Fur": has no hair'
    ]
    patch.particle_systems[0].settings.count = 10
    patch.particle_systems[0].settings.radius_scale = 0.0
    groups = read().strand_objects
    assert len(groups) == 1
    assert not groups[0].strands.points[:, 3].any()
