# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders around normals that maps and bumps bend reflect light as Cycles' do, each on a ball of every angle."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest

from addon import last_render
from support.closure_scenes import IS_OLD, ball, errors, lamp, shader, sun, world
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, cube, displace, empty_scene, material, node

GOLD, RED = (0.9, 0.6, 0.2, 1.0), (0.8, 0.2, 0.1, 1.0)
BOUND = 0.01
GLOSSY = "ShaderNodeBsdfGlossy" if IS_OLD else "ShaderNodeBsdfAnisotropic"
COAT = "Clearcoat" if IS_OLD else "Coat"
New, Link = Callable[[str], bpy.types.Node], Callable[..., object]


def combined(new: New, link: Link, operation: str, a: object, b: object, c: object = None) -> bpy.types.NodeSocket:
    """A Vector Math node of sockets and values."""
    created = new("ShaderNodeVectorMath")
    created.operation = operation
    for place, value in enumerate((a, b, c)):
        if isinstance(value, bpy.types.NodeSocket):
            link(value, created.inputs[place])
        elif value is not None:
            created.inputs[place].default_value = value
    return created.outputs["Vector"]


def waves(new: New, link: Link) -> bpy.types.NodeSocket:
    """Three of the position, in [-1, 1]."""
    at = new("ShaderNodeNewGeometry").outputs["Position"]
    return combined(new, link, "SINE", combined(new, link, "MULTIPLY", at, (7.0, 6.0, 5.0)), None)


def tangent_map(new: New, link: Link) -> bpy.types.NodeSocket:
    mapped = node(new, "ShaderNodeNormalMap", Strength=0.8)
    link(combined(new, link, "MULTIPLY_ADD", waves(new, link), (0.25, 0.2, 0.05), (0.5, 0.5, 0.9)), mapped.inputs[1])
    return mapped.outputs["Normal"]


def map_in(space: str, strength: float) -> Build:
    """The surface's own normal with waves."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        mapped = node(new, "ShaderNodeNormalMap", Strength=strength)
        mapped.space = space
        kind = "ShaderNodeTexCoord" if space == "OBJECT" else "ShaderNodeNewGeometry"
        bent = combined(new, link, "MULTIPLY_ADD", waves(new, link), (0.4, 0.3, 0.2), new(kind).outputs["Normal"])
        link(combined(new, link, "MULTIPLY_ADD", bent, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5)), mapped.inputs["Color"])
        return mapped.outputs["Normal"]

    return build


def bump(strength: float = 0.8) -> Build:
    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        created = node(new, "ShaderNodeBump", Strength=strength, Distance=0.08)
        link(waves(new, link), created.inputs["Height"])
        return created.outputs["Normal"]

    return build


NORMALS: dict[str, Build] = {
    "tangent": tangent_map,
    "object": map_in("OBJECT", 1.0),
    "world": map_in("WORLD", 0.7),
    "bump": bump(),
}


def around(build: Build, normal: Build, socket: str = "Normal") -> Build:
    def made(new: New, link: Link) -> bpy.types.NodeSocket:
        surface = build(new, link)
        link(normal(new, link), surface.node.inputs[socket])
        return surface

    return made


def principled(**inputs: object) -> Build:
    return shader("ShaderNodeBsdfPrincipled", **{"Base_Color": RED, "Roughness": 0.4, **inputs})


COATED = principled(**{"Clearcoat" if IS_OLD else "Coat_Weight": 1.0, f"{COAT}_Roughness": 0.3})
SHADERS: dict[str, Build] = {
    "diffuse": shader("ShaderNodeBsdfDiffuse", Color=RED),
    "glossy": shader(GLOSSY, Color=GOLD, Roughness=0.4, node_distribution="GGX"),
    "principled": principled(node_distribution="GGX"),
}
MORE: dict[str, Build] = {
    "rough diffuse": shader("ShaderNodeBsdfDiffuse", Color=RED, Roughness=0.7),
    "metal": principled(Base_Color=GOLD, Metallic=1.0, node_distribution="GGX"),
    "no specular": principled(**{"Specular" if IS_OLD else "Specular_IOR_Level": 0.0}),
    "toon": shader("ShaderNodeBsdfToon", Color=RED, Size=0.5, Smooth=0.3),
    "velvet": shader("ShaderNodeBsdfVelvet", Color=RED, Sigma=0.6)
    if IS_OLD
    else shader("ShaderNodeBsdfSheen", Color=RED, Roughness=0.6, node_distribution="ASHIKHMIN"),
}


def scene_of(build: Build, light_it: Callable[[bpy.types.Scene], object], *, is_smooth: bool) -> bpy.types.Scene:
    scene = empty_scene(64)
    scene.camera.data.ortho_scale = 2.1
    data = ball(material("Shown", build), is_smooth=is_smooth).data
    places = np.array([data.vertices[loop.vertex_index].co for loop in data.loops])
    layer = data.uv_layers.new(name="UV")
    layer.data.foreach_set("uv", (0.5 + 0.5 * places[:, :2]).ravel())
    light_it(scene)
    return scene


def image_world(scene: bpy.types.Scene) -> None:
    """Brighter towards +X and above."""
    image = bpy.data.images.new("Sky", 32, 16, float_buffer=True)
    across, up = np.meshgrid(np.linspace(0.0, 1.0, 32), np.linspace(0.0, 1.0, 16))
    image.pixels.foreach_set(
        np.stack([0.2 + across, 0.4 + up, 0.6 + 0 * up, 1 + 0 * up], -1).astype(np.float32).ravel()
    )
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexEnvironment")
    sky.image = image
    tree.links.new(sky.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    scene.render.film_transparent = True


def check(
    build: Build,
    light_it: Callable[[bpy.types.Scene], object],
    samples: int = 4,
    cycles_samples: int = 8,
    *,
    is_smooth: bool = False,
) -> None:
    scene = scene_of(build, light_it, is_smooth=is_smooth)
    ours, cycles = tyndall_pixels(scene, samples), cycles_pixels(scene, cycles_samples, seed=1)
    mean, median = errors(ours, cycles)
    print(f"mean {mean:.4f}, median block {median:.4f}")
    assert mean <= BOUND
    assert median <= BOUND


# Seen to fail: all around the surface's own normal; half of them without what bumps shadow.
@pytest.mark.dealt
@pytest.mark.parametrize("tilt", [40.0, 80.0])
@pytest.mark.parametrize("normal", NORMALS)
@pytest.mark.parametrize("name", SHADERS)
def test_a_shader_around_a_normal(name: str, normal: str, tilt: float) -> None:
    check(around(SHADERS[name], NORMALS[normal]), sun(tilt))


@pytest.mark.dealt
@pytest.mark.parametrize("name", MORE)
def test_other_shaders_around_a_bump(name: str) -> None:
    check(around(MORE[name], bump()), sun(60.0))


@pytest.mark.parametrize("sockets", [("Normal",), (f"{COAT} Normal",), ("Normal", f"{COAT} Normal")])
def test_a_coat_has_a_normal_of_its_own(sockets: tuple[str, ...]) -> None:
    build = COATED
    for socket, normal in zip(sockets, (bump(), NORMALS["object"]), strict=False):
        build = around(build, normal, socket)
    check(build, sun(50.0))


@pytest.mark.dealt
@pytest.mark.parametrize("name", SHADERS)
@pytest.mark.parametrize("light_it", [lamp(0.3), world()], ids=["lamp", "world"])
def test_lights_with_a_size_on_bumps(name: str, light_it: Callable[[bpy.types.Scene], object]) -> None:
    check(around(SHADERS[name], bump()), light_it, 128, 512)


@pytest.mark.parametrize("name", SHADERS)
def test_a_smooth_ball_with_bumps_under_a_lamp(name: str) -> None:
    check(around(SHADERS[name], bump()), lamp(0.0), is_smooth=True)


def steep_map(new: New, link: Link) -> bpy.types.NodeSocket:
    """Nearly flat to the surface: what mirrors around it looks along that, before and behind smooth normals."""
    mapped = node(new, "ShaderNodeNormalMap", Strength=4.0, Color=(0.9, 0.2, 0.9, 1.0))
    return mapped.outputs["Normal"]


# Seen to fail: with gloss that sends nothing back of light behind the smooth normal, 5 % too dark under an even world.
@pytest.mark.dealt
@pytest.mark.parametrize("name", ["glossy", "principled"])
@pytest.mark.parametrize("light_it", [world(), image_world], ids=["even world", "image"])
def test_a_smooth_ball_with_a_steep_map_mirrors_the_world(
    name: str, light_it: Callable[[bpy.types.Scene], object]
) -> None:
    check(around(SHADERS[name], steep_map), light_it, 128, 512, is_smooth=True)


#: Up to 3.5 what is diffuse has such normals, too; ours has them for gloss alone.
SMOOTHED = {"glossy": SHADERS["glossy"], "principled": SHADERS["principled"], "coated": COATED, "metal": MORE["metal"]}


# Seen to fail: with smooth normals as they are; turned, too, where nothing is to be corrected.
@pytest.mark.parametrize("corrects", [True, False])
@pytest.mark.parametrize("tilt", [20.0, 100.0])
@pytest.mark.parametrize("name", SMOOTHED)
def test_gloss_on_a_smooth_cube_is_mirrored_by_normals_that_a_mirror_could_have(
    name: str, tilt: float, *, corrects: bool
) -> None:
    """Smooth normals lean so far there that they would mirror what the faces' backs see."""
    if IS_OLD and (not corrects or name != "glossy"):
        pytest.skip("3.4 has no such setting, and turns the normals of what is diffuse, too")
    scene = empty_scene(64)
    scene.camera.data.ortho_scale = 4.0
    body = cube("Body", material("Shown", SMOOTHED[name]))
    body.data.polygons.foreach_set("use_smooth", [True] * len(body.data.polygons))
    body.rotation_euler = (0.6, 0.5, 0.3)
    sun(tilt)(scene)
    if not IS_OLD:
        bpy.data.materials["Shown"].cycles.use_bump_map_correction = corrects
    mean, median = errors(tyndall_pixels(scene, 8), cycles_pixels(scene, 32, seed=1))
    print(f"mean {mean:.4f}, median block {median:.4f}")
    assert max(mean, median) <= 0.5 * BOUND


BROAD = {name: MORE[name] for name in ("rough diffuse", "toon", "velvet")}
if not IS_OLD:
    BROAD["sheen"] = shader("ShaderNodeBsdfSheen", Color=RED, Roughness=0.5, node_distribution="MICROFIBER")
    BROAD["sheen on a surface"] = principled(Sheen_Weight=1.0)


# Seen to fail: without light where the viewer is behind the smooth normal (sheen: half of all it sends).
@pytest.mark.skipif(IS_OLD, reason="3.4 turns the normals of what is diffuse")
@pytest.mark.parametrize("light_it", [sun(80.0), world()], ids=["sun", "world"])
@pytest.mark.parametrize("name", BROAD)
def test_what_is_broad_on_a_smooth_cone_is_seen_past_its_normals(
    name: str, light_it: Callable[[bpy.types.Scene], object]
) -> None:
    scene = empty_scene(64)
    scene.camera.data.ortho_scale = 2.6
    bpy.ops.mesh.primitive_cone_add(vertices=8)
    body = bpy.context.object
    body.data.materials.append(material("Shown", BROAD[name]))
    bpy.ops.object.shade_smooth()
    body.rotation_euler = (1.3, 0.2, 0.3)
    light_it(scene)
    mean, median = errors(tyndall_pixels(scene, 64), cycles_pixels(scene, 256, seed=1))
    print(f"mean {mean:.4f}, median block {median:.4f}")
    assert max(mean, median) <= BOUND


@pytest.mark.skipif(IS_OLD, reason="a setting of 4.0")
@pytest.mark.parametrize("name", SHADERS)
def test_a_material_may_leave_bumps_uncorrected(name: str) -> None:
    scene = scene_of(around(SHADERS[name], tangent_map), sun(80.0), is_smooth=False)
    corrected = tyndall_pixels(scene, 4)
    bpy.data.materials["Shown"].cycles.use_bump_map_correction = False
    ours, cycles = tyndall_pixels(scene, 4), cycles_pixels(scene, 8, seed=1)
    assert max(errors(ours, cycles)) <= BOUND
    assert name != "diffuse" or ours.mean() > 1.02 * corrected.mean()


def bump_of(output: str) -> Build:
    """Waves of a texture coordinate."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        created = node(new, "ShaderNodeBump", Strength=0.8, Distance=0.08)
        scaled = combined(new, link, "MULTIPLY", new("ShaderNodeTexCoord").outputs[output], (14.0, 12.0, 10.0))
        link(combined(new, link, "SINE", scaled, None), created.inputs["Height"])
        return created.outputs["Normal"]

    return build


@pytest.mark.dealt
@pytest.mark.parametrize("coordinate", ["UV", "Generated", "Object"])
@pytest.mark.parametrize("is_flipped", [False, True], ids=["front", "back"])
def test_bumps_on_back_faces_go_the_way_that_they_go_in_cycles(coordinate: str, *, is_flipped: bool) -> None:
    """It turns them around where a coordinate belongs to triangles."""
    scene = scene_of(around(SHADERS["glossy"], bump_of(coordinate)), sun(50.0), is_smooth=False)
    if is_flipped:
        next(each for each in scene.objects if each.type == "MESH").data.flip_normals()
    ours, cycles = tyndall_pixels(scene, 4), cycles_pixels(scene, 8, seed=1)
    assert max(errors(ours, cycles)) <= BOUND


def displacement(space: str) -> Build:
    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        created = node(new, "ShaderNodeDisplacement", Midlevel=0.3, Scale=0.1)
        created.space = space
        link(waves(new, link), created.inputs["Height"])
        return created.outputs["Displacement"]

    return build


def vector_displacement(space: str) -> Build:
    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        created = node(new, "ShaderNodeVectorDisplacement", Scale=0.1)
        created.space = space
        link(waves(new, link), created.inputs["Vector"])
        return created.outputs["Displacement"]

    return build


def bare_vector(new: New, link: Link) -> bpy.types.NodeSocket:
    return combined(new, link, "MULTIPLY", waves(new, link), (0.05, 0.1, 0.08))


def mixed(first: Build, second: Build) -> Build:
    """As files do that displace ground and water by turns."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        mix = node(new, "ShaderNodeMixRGB", Fac=0.3)
        link(first(new, link), mix.inputs["Color1"])
        link(second(new, link), mix.inputs["Color2"])
        return mix.outputs[0]

    return build


DISPLACEMENTS: dict[str, Build] = {
    "world": displacement("WORLD"),
    "object": displacement("OBJECT"),
    "vector in world": vector_displacement("WORLD"),
    "vector in object": vector_displacement("OBJECT"),
    "vector in tangent": vector_displacement("TANGENT"),
    "any vector": bare_vector,
    "mixed": mixed(displacement("OBJECT"), vector_displacement("WORLD")),
}


def fresnel_glow(new: New, link: Link) -> bpy.types.NodeSocket:
    """Of all that asks for the surface's normal by itself."""
    glow = node(new, "ShaderNodeEmission")
    seen = combined(new, link, "ADD", new("ShaderNodeNewGeometry").outputs["Normal"], (4.0, 4.0, 4.0))
    for name in ("Normal", "Reflection"):
        seen = combined(new, link, "ADD", seen, new("ShaderNodeTexCoord").outputs[name])
    link(combined(new, link, "ADD", seen, new("ShaderNodeFresnel").outputs[0]), glow.inputs["Color"])
    return glow.outputs["Emission"]


def displaced_scene(surface: Build, moved: Build, method: str = "BUMP") -> bpy.types.Scene:
    scene = scene_of(surface, sun(50.0), is_smooth=True)
    thing = next(each for each in scene.objects if each.type == "MESH")
    thing.scale = (1.0, 0.8, 0.7)  # spaces differ
    displace(bpy.data.materials["Shown"], moved, method)
    return scene


# Seen to fail: without the spaces' scales, without the middle's height, around the surface's own normal.
@pytest.mark.dealt
@pytest.mark.parametrize("moved", DISPLACEMENTS)
@pytest.mark.parametrize("name", ["diffuse", "principled"])
def test_displacement_is_a_bump(name: str, moved: str) -> None:
    scene = displaced_scene(SHADERS[name], DISPLACEMENTS[moved])
    ours, cycles = tyndall_pixels(scene, 4), cycles_pixels(scene, 8, seed=1)
    assert max(errors(ours, cycles)) <= BOUND


def test_all_that_asks_for_the_normal_finds_the_displaced_one() -> None:
    scene = displaced_scene(fresnel_glow, DISPLACEMENTS["object"])
    ours, cycles = tyndall_pixels(scene, 4), cycles_pixels(scene, 8, seed=1)
    assert max(errors(ours, cycles)) <= BOUND


def test_a_bump_lies_on_the_displaced_surface() -> None:
    """What the bump shadows is measured from the mesh's own normal, which is off in the last degrees before dark."""
    scene = displaced_scene(around(SHADERS["diffuse"], bump()), DISPLACEMENTS["world"])
    mean, median = errors(tyndall_pixels(scene, 4), cycles_pixels(scene, 8, seed=1))
    assert median <= BOUND
    assert mean <= (0.07 if IS_OLD else 0.03)


@pytest.mark.dealt
@pytest.mark.parametrize("moved", DISPLACEMENTS)
def test_a_mesh_that_is_moved_is_as_in_cycles(moved: str) -> None:
    scene = displaced_scene(SHADERS["diffuse"], DISPLACEMENTS[moved], "DISPLACEMENT")
    ours, cycles = tyndall_pixels(scene, 4), cycles_pixels(scene, 8, seed=1)
    assert max(errors(ours, cycles)) <= BOUND


def test_what_is_as_high_everywhere_costs_nothing() -> None:
    """The same bits as without it."""

    def flat(new: New, _: Link) -> bpy.types.NodeSocket:
        created = node(new, "ShaderNodeDisplacement", Height=2.0)
        created.space = "WORLD"
        return created.outputs["Displacement"]

    scene = displaced_scene(SHADERS["diffuse"], flat)
    displaced = tyndall_pixels(scene, 1)
    tree = bpy.data.materials["Shown"].node_tree
    tree.links.remove(next(link for link in tree.links if link.to_socket.name == "Displacement"))
    assert (tyndall_pixels(scene, 1) == displaced).all()


def test_what_ignores_its_normal_says_so() -> None:
    leaf = around(shader("ShaderNodeBsdfTranslucent", Color=RED), bump())
    scene = scene_of(leaf, sun(40.0), is_smooth=False)
    tyndall_pixels(scene)
    reports = last_render.statistics_of("Scene")["reports"]
    assert any("translucent" in line and "Shown" in line for line in reports)
