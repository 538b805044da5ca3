# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders give the coefficients that Cycles reads from them: a slab of each before a glowing wall."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest

from addon import last_render
from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.cycles_reference import tyndall_pixels as pixels_by_methods
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, Node, block_shadow_rays, cube, empty_scene, light, material, node, plane, read

pytestmark = pytest.mark.dealt

IS_4, HAS_COEFFICIENTS = bpy.app.version >= (4, 0, 0), hasattr(bpy.types, "ShaderNodeVolumeCoefficients")
New, Link = Callable[[str], Node], Callable[..., object]
Socket = bpy.types.NodeSocket
COLOUR = (0.2, 0.5, 0.9, 1.0)


def wall(new: New, link: Link) -> Socket:
    """Glows for the camera only: no light of it is there to be scattered."""
    glow = new("ShaderNodeEmission")
    link(new("ShaderNodeLightPath").outputs["Is Camera Ray"], glow.inputs["Strength"])
    return glow.outputs[0]


def behind_slab(build: Build) -> bpy.types.Scene:
    """Of 1.5 m; the box is a scaled one, which must not matter."""
    scene = empty_scene()
    plane(0.0, material("Wall", surface=wall))
    slab = cube("Slab", material("Slab", volume=build))
    slab.location.z, slab.scale = 1.5, (3.0, 3.0, 0.75)
    return scene


def absorption(new: New, _link: Link) -> Socket:
    return node(new, "ShaderNodeVolumeAbsorption", Color=COLOUR, Density=0.7).outputs[0]


def scatter(new: New, _link: Link) -> Socket:
    return node(new, "ShaderNodeVolumeScatter", Color=COLOUR, Density=0.7, Anisotropy=0.3).outputs[0]


def principled(new: New, _link: Link, colour: tuple[float, ...] = COLOUR, **inputs: object) -> Socket:
    inputs = {"Density": 0.7, "Absorption_Color": (0.3, 0.1, 0.0, 1.0)} | inputs
    return node(new, "ShaderNodeVolumePrincipled", Color=colour, **inputs).outputs[0]


def black_and_glowing(new: New, link: Link) -> Socket:
    """What glows and scatters is lit by itself in Cycles: without scattering, only its emission counts."""
    glow = {"Emission_Strength": 0.4, "Emission_Color": (1.0, 0.5, 0.1, 1.0)}
    return principled(new, link, (0.0, 0.0, 0.0, 1.0), **glow)


def emission(new: New, _link: Link) -> Socket:
    return node(new, "ShaderNodeEmission", Color=(1.0, 0.5, 0.2, 1.0), Strength=0.3).outputs[0]


def flame(new: New, link: Link) -> Socket:
    return principled(new, link, Density=0.0, Blackbody_Intensity=0.8, Temperature=2500.0)


def coefficients(new: New, _link: Link) -> Socket:
    absorbed, emitted = (0.1, 0.2, 0.3), (0.1, 0.2, 0.05)
    inputs = {"Absorption_Coefficients": absorbed, "Emission_Coefficients": emitted}
    return node(new, "ShaderNodeVolumeCoefficients", Scatter_Coefficients=(0, 0, 0), **inputs).outputs[0]


def combined(kind: str, first: Build, second: Build) -> Build:
    def build(new: New, link: Link) -> Socket:
        created = new(kind)
        if kind == "ShaderNodeMixShader":
            created.inputs["Fac"].default_value = 0.3
        shaders = [socket for socket in created.inputs if socket.type == "SHADER"]
        for shader, of in zip(shaders, (first, second), strict=True):
            link(of(new, link), shader)
        return created.outputs[0]

    return build


SLABS: dict[str, Build] = {
    "absorption": absorption,
    "scatter": scatter,
    "principled": principled,
    "principled that glows": black_and_glowing,
    "emission": emission,
    "sum": combined("ShaderNodeAddShader", absorption, scatter),
    "mix": combined("ShaderNodeMixShader", absorption, scatter),
    "mix with a glowing one": combined("ShaderNodeMixShader", absorption, black_and_glowing),
}
if HAS_COEFFICIENTS:
    SLABS["coefficients"] = coefficients


@pytest.mark.parametrize("name", SLABS)
def test_a_slab_lets_through_what_it_does_in_cycles(name: str) -> None:
    """Cycles scatters or not by chance: 65,536 rays leave 0.2 %, and 3 sigma are allowed."""
    scene = behind_slab(SLABS[name])
    ours = tyndall_pixels(scene).mean(axis=(0, 1))
    cycles = cycles_pixels(scene, samples=1024, seed=1).mean(axis=(0, 1))
    assert ours == pytest.approx(cycles, rel=6e-3)


def test_a_flame_has_the_colour_of_its_heat() -> None:
    """Two fits of the colour of a black body differ by up to 1.5 %; the wall's 1 is not part of that."""
    scene = behind_slab(flame)
    ours = tyndall_pixels(scene).mean(axis=(0, 1)) - 1.0
    cycles = cycles_pixels(scene, samples=16, seed=1).mean(axis=(0, 1)) - 1.0
    assert ours == pytest.approx(cycles, rel=0.015, abs=2e-3)


def test_lobes_keep_their_own_direction() -> None:
    """Two scatter nodes are two lobes; equal ones are one."""

    def build(new: New, link: Link) -> Socket:
        different = combined("ShaderNodeAddShader", scatter, lambda *_: backward(new))
        return combined("ShaderNodeAddShader", different, scatter)(new, link)

    def backward(new: New) -> Socket:
        return node(new, "ShaderNodeVolumeScatter", Density=0.2, Anisotropy=-0.5).outputs[0]

    behind_slab(build)
    (medium,) = read().media
    lobes = {round(lobe.asymmetry_g, 3): np.array(lobe.sigma_s_per_m) for lobe in medium.lobes}
    assert set(lobes) == {0.3, -0.5}
    assert lobes[0.3] == pytest.approx(2 * 0.7 * np.array(COLOUR[:3]))


def test_a_fog_box_has_no_surface_and_a_glass_of_milk_has_one() -> None:
    behind_slab(scatter)
    milk = material("Milk", surface=lambda new, _: node(new, "ShaderNodeBsdfTransparent").outputs[0], volume=scatter)
    cube("Milk", milk)
    described = {described.name: described for described in read().materials}
    assert not described["Slab"].has_surface
    assert described["Milk"].has_surface
    assert described["Milk"].medium >= 0


def test_a_volume_shader_that_does_nothing_is_no_medium() -> None:
    """It costs nothing, and its box still does not occlude."""
    behind_slab(lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.0).outputs[0])
    described = read()
    assert described.media == ()
    assert not next(described for described in described.materials if described.name == "Slab").has_surface


def test_a_medium_that_fills_the_world() -> None:
    scene = empty_scene()
    tree = scene.world.node_tree
    tree.links.new(scatter(tree.nodes.new, tree.links.new), tree.nodes["World Output"].inputs["Volume"])
    described = read()
    assert described.media[described.world.medium].name == "World"


# Seen to fail: with fog that ends where the camera's clipping does, behind which the world shows.
def test_fog_of_the_world_does_not_end_where_surfaces_are_clipped() -> None:
    """A camera that clips at 2 m sees a lamp's light in all of the fog, and nothing of the world behind it."""
    scene = empty_scene()
    tree = scene.world.node_tree
    tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
    fog = node(tree.nodes.new, "ShaderNodeVolumeScatter", Color=COLOUR, Density=0.3).outputs[0]
    tree.links.new(fog, tree.nodes["World Output"].inputs["Volume"])
    scene.camera.data.clip_end = 2.0
    light("POINT", (1.0, 0.5, -2.0), energy=100.0)
    ours = pixels_by_methods(scene, ["EXACT", "EPIPOLAR"], light_samples=4, world_samples=1)
    reference = cycles_pixels(scene, 64, 1).mean(axis=(0, 1))
    for picture in ours:
        assert picture.mean(axis=(0, 1)) == pytest.approx(reference, rel=0.01)


# Seen to fail: with fog between a lamp without shadows and what it lights.
@pytest.mark.parametrize("kind", ["POINT", "SUN"])
def test_fog_does_not_dim_a_lamp_that_casts_no_shadow(kind: str) -> None:
    """As in Cycles, to which fog is a shadow: on its way neither to air nor to a floor, if through a world of it."""
    scene = empty_scene()
    floor = material("Floor", surface=lambda new, _: new("ShaderNodeBsdfDiffuse").outputs[0])
    plane(0.0, floor, half_side=5.0)
    if kind == "SUN":
        tree = scene.world.node_tree
        tree.links.new(scatter(tree.nodes.new, tree.links.new), tree.nodes["World Output"].inputs["Volume"])
    else:
        cube("Fog", material("Fog", volume=scatter)).scale = (4.0, 4.0, 4.0)
    lamp = light(kind, (1.0, 0.5, 2.5), energy=100.0 if kind == "POINT" else 1.0)
    if kind == "SUN":  # without a size: what is drawn by surfaces meets a lamp only where nothing is between
        lamp.data.angle = 0.0
    else:
        lamp.data.shadow_soft_size = 0.0
    if bpy.app.version >= (4, 2, 0):
        lamp.data.use_shadow = False
    else:
        lamp.data.cycles.cast_shadow = False
    ours = pixels_by_methods(scene, ["EXACT", "EPIPOLAR"], light_samples=1, world_samples=1)
    reference = cycles_pixels(scene, 256, 1).mean(axis=(0, 1))
    for picture in ours:
        assert picture.mean(axis=(0, 1)) == pytest.approx(reference, rel=0.01)


def test_a_varying_anisotropy_is_read_as_its_middle_and_named() -> None:
    def build(new: New, link: Link) -> Socket:
        created = node(new, "ShaderNodeVolumePrincipled", Color=(0.5, 0.5, 0.5, 1), Density=1.0)
        link(new("ShaderNodeTexNoise").outputs[0], created.inputs["Anisotropy"])
        return created.outputs[0]

    behind_slab(build)
    reports = Reports()
    described = SceneReader().read(bpy.context.evaluated_depsgraph_get(), reports, lambda: None)
    (lobe,) = described.media[0].lobes
    assert lobe.asymmetry_g == 0.5
    assert sum('"Slab"' in line for line in described.reports) == 1


@pytest.mark.parametrize("method", ["EXACT", "EPIPOLAR", "SHADOW_MAP"])
def test_a_pane_without_transparent_shadows_blocks_shafts_that_the_camera_sees_through_it(method: str) -> None:
    """As black card that the camera does not see. Above the fog, in a sun of 1 W/m^2."""
    scene = empty_scene(16)
    scene.camera.location.z = 9.0
    scene.tyndall.shafts.method = method
    light("SUN", (0, 0, 0), energy=1.0, angle=0.0).rotation_euler = (0.1, 0.0, 0.0)
    behind = material("Fog", volume=scatter)
    cube("Fog", behind).scale = (3.0, 3.0, 1.0)
    clear = material("Pane", surface=lambda new, _: new("ShaderNodeBsdfTransparent").outputs[0])
    pane = plane(3.0, clear, half_side=0.4)
    free = tyndall_pixels(scene)
    block_shadow_rays(clear)
    blocked = tyndall_pixels(scene)
    pane.data.materials[0] = material(
        "Card", surface=lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0, 0, 0, 1)).outputs[0]
    )
    pane.visible_camera = False
    assert blocked.mean() < 0.98 * free.mean()
    assert blocked == pytest.approx(tyndall_pixels(scene), rel=1e-3, abs=1e-5)


@pytest.mark.parametrize(
    ("anisotropy", "world_samples", "advice"),
    [
        (0.7, 256, ""),
        (0.7, 16, "112 would do"),
        (0.9, 256, "1000 would do"),
        (0.9, 1024, ""),
        (0.999, 256, "cannot be had"),
        (0.999, 0, ""),
    ],
)
def test_too_few_directions_for_forward_fog_are_named(anisotropy: float, world_samples: int, advice: str) -> None:
    def forward(new: New, _: Link) -> Socket:
        return node(new, "ShaderNodeVolumeScatter", Density=0.5, Anisotropy=anisotropy).outputs[0]

    scene = empty_scene(size_px=4)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    scene.tyndall.shafts.world_samples = world_samples
    cube("Fog", material("Fog", volume=forward))
    tyndall_pixels(scene)

    def reports() -> list[str]:
        return [line for line in last_render.statistics_of(scene.name)["reports"] if "World Samples" in line]

    assert len(reports()) == bool(advice)
    assert all(advice in line and f"{anisotropy:g}" in line for line in reports())
    scene.tyndall.shafts.method, scene.tyndall.pixel_samples = "EPIPOLAR", 16  # of which each draws some
    bpy.ops.render.render(scene=scene.name)
    assert bool(reports()) == (bool(advice) and anisotropy < 0.8)
