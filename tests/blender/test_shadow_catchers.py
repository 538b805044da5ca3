# SPDX-License-Identifier: GPL-3.0-or-later
"""Of shadow catchers a picture shows only the shadows that others cast on them, as in Cycles."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.pass_pictures import render_passes
from support.small_scenes import Build, Node, add, cube, empty_scene, light, material, node, plane

New, Link = Callable[[str], Node], Callable[..., object]
Socket = bpy.types.NodeSocket
WORLD = (0.3, 0.4, 0.6)


def diffuse(albedo: tuple[float, float, float] = (0.8, 0.8, 0.8)) -> Build:
    def build(new: New, _link: Link) -> Socket:
        return node(new, "ShaderNodeBsdfDiffuse", Color=(*albedo, 1.0)).outputs[0]

    return build


def gloss(new: New, _link: Link) -> Socket:
    name = "ShaderNodeBsdfGlossy" if bpy.app.version < (4, 0, 0) else "ShaderNodeBsdfAnisotropic"
    return node(new, name, Roughness=0.3, Color=(0.8, 0.8, 0.8, 1.0)).outputs[0]


def glow(strength: float) -> Build:
    def build(new: New, _link: Link) -> Socket:
        return node(new, "ShaderNodeEmission", Strength=strength).outputs[0]

    return build


def half_clear(new: New, link: Link) -> Socket:
    mix = new("ShaderNodeMixShader")
    link(node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1.0)).outputs[0], mix.inputs[1])
    link(node(new, "ShaderNodeBsdfTransparent", Color=(1.0, 1.0, 1.0, 1.0)).outputs[0], mix.inputs[2])
    mix.inputs[0].default_value = 0.5
    return mix.outputs[0]


def stage(world: tuple[float, float, float] = WORLD) -> tuple[bpy.types.Scene, bpy.types.Object, bpy.types.Object]:
    """A sun, a red slab, and the floor that catches its shadow, seen from above."""
    scene = empty_scene(16)
    scene.camera.data.ortho_scale, scene.camera.location.z = 4.0, 6.0
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (*world, 1.0)
    floor = plane(0.0, material("Floor", surface=diffuse()), half_side=5.0)
    floor.is_shadow_catcher = True
    slab = cube("Slab", material("Slab", surface=diffuse((0.8, 0.1, 0.1))))
    slab.scale, slab.location = (0.5, 0.5, 0.1), (0.0, 0.0, 1.0)
    return scene, floor, slab


def sun(color: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> bpy.types.Object:
    thing = light("SUN", (0, 0, 5), energy=2.0, angle=0.0, color=color)
    thing.rotation_euler = (0.0, 0.8, 0.0)
    return thing


def under_the_sky() -> bpy.types.Scene:
    scene, *_ = stage()
    sun()
    return scene


def of_a_light_that_is_left_out() -> bpy.types.Scene:
    """What only it would light, it brightens; its shadow is none."""
    scene, *_ = stage()
    sun().is_shadow_catcher = False
    return scene


def of_one_colour() -> bpy.types.Scene:
    """Channels without light have no shadow: a third of the grey."""
    scene, *_ = stage((0.0, 0.0, 0.0))
    sun((1.0, 0.0, 0.0))
    return scene


def in_the_dark() -> bpy.types.Scene:
    return stage((0.0, 0.0, 0.0))[0]


def on_gloss() -> bpy.types.Scene:
    scene, floor, _ = stage()
    sun()
    floor.active_material = material("Gloss", surface=gloss)
    return scene


def by_an_area_light() -> bpy.types.Scene:
    scene, *_ = stage((0.0, 0.0, 0.0))
    lamp = light("AREA", (1.0, 0.0, 3.0), energy=100.0, size=1.0)
    lamp.rotation_euler = (0.0, 0.3, 0.0)
    return scene


def by_an_instancer() -> bpy.types.Scene:
    scene, floor, _ = stage()
    sun()
    floor.is_shadow_catcher = False
    collection = bpy.data.collections.new("Floor")
    scene.collection.objects.unlink(floor)
    collection.objects.link(floor)
    empty = add("Instancer", None)
    empty.instance_type, empty.instance_collection, empty.is_shadow_catcher = "COLLECTION", collection, True
    return scene


def by_an_instancer_of_what_stands() -> bpy.types.Scene:
    """The slab is seen, and its copy catches its shadow. Seen to fail: the copy was as the slab."""
    scene, _, slab = stage()
    sun()
    collection = bpy.data.collections.new("Slab")
    collection.objects.link(slab)
    empty = add("Instancer", None)
    empty.instance_type, empty.instance_collection, empty.is_shadow_catcher = "COLLECTION", collection, True
    empty.location = (-0.6, 0.3, -0.7)
    return scene


def among_glowing_things() -> bpy.types.Scene:
    """What glows brightens what a catcher shows, and never makes it darker."""
    scene, _, slab = stage((0.0, 0.0, 0.0))
    sun()
    slab.active_material = material("Glow", surface=glow(3.0))
    return scene


def behind_fog() -> bpy.types.Scene:
    """What the fog takes away is taken from what is put behind."""
    scene = under_the_sky()

    def absorbing(new: New, _link: Link) -> Socket:
        return node(new, "ShaderNodeVolumeAbsorption", Color=(0.0, 0.0, 0.0, 1.0), Density=0.5).outputs[0]

    fog = cube("Fog", material("Fog", volume=absorbing))
    fog.location.z, fog.scale = 3.0, (6.0, 6.0, 1.0)
    return scene


def held_out() -> bpy.types.Scene:
    scene, floor, _ = stage()
    sun()
    floor.is_holdout = True
    return scene


SCENES = [
    under_the_sky,
    of_a_light_that_is_left_out,
    of_one_colour,
    in_the_dark,
    on_gloss,
    by_an_area_light,
    by_an_instancer,
    by_an_instancer_of_what_stands,
    among_glowing_things,
    held_out,
]


@pytest.mark.parametrize("build", [*SCENES[:2], *SCENES[4:8], behind_fog], ids=lambda build: build.__name__)
def test_an_opaque_film_shows_the_world_through_the_shadow(build: Callable[[], bpy.types.Scene]) -> None:
    """As a compositor does that puts it behind the picture of a transparent film."""
    scene = build()
    opaque = tyndall_pixels(scene, 4)
    world = scene.world.node_tree.nodes["Background"].inputs[0].default_value[:3]
    scene.render.film_transparent = True
    over = tyndall_pixels(scene, 4, "RGBA")
    assert over[..., :3] + (1.0 - over[..., 3:]) * np.array(world) == pytest.approx(opaque, abs=2e-6)
    assert over[..., 3].min() < 0.95 < over[..., 3].max()


def test_fog_in_front_dims_what_is_put_behind() -> None:
    """As in Cycles by a transparent film; by an opaque one, Cycles dims twice."""
    scene = behind_fog()
    scene.render.film_transparent = True
    ours, theirs = tyndall_pixels(scene, 64, "RGBA"), cycles_pixels(scene, 64, 1, "RGBA")
    assert np.abs(ours - theirs).mean() < 1e-3
    assert ours[..., 3].min() > 0.8


@pytest.mark.dealt
@pytest.mark.parametrize("film", ["transparent", "opaque"])
@pytest.mark.parametrize("build", SCENES, ids=lambda build: build.__name__)
def test_shadows_are_caught_as_in_cycles(build: Callable[[], bpy.types.Scene], film: str) -> None:
    """Colour and alpha; on an opaque film the world in the catcher's place."""
    scene = build()
    scene.render.film_transparent = film == "transparent"
    # Of a held out catcher Cycles' alpha is 1 on an opaque film, and of what else is held out 0.
    mode = "RGB" if build is held_out else "RGBA"
    ours = tyndall_pixels(scene, 64, mode)
    first, second = (cycles_pixels(scene, 64, seed, mode) for seed in (1, 2))
    noise = np.abs(first - second)
    assert np.abs(ours - (first + second) / 2).mean() < 1e-4 + 1.2 * noise.mean()
    # A quarter of the largest of 256 pixels' noise is rarely that of their mean.
    assert np.abs((ours - (first + second) / 2).mean(axis=(0, 1))).max() < 1e-4 + 0.25 * noise.max()


def test_without_others_nothing_is_caught() -> None:
    """Light among all is light among catchers, bit for bit: also through the floor's own hills, and by soft light."""
    scene, floor, slab = stage()
    light("AREA", (1.0, 0.0, 3.0), energy=100.0, size=1.0)
    hill = cube("Hill", material("Hill", surface=diffuse()))
    hill.is_shadow_catcher = True
    bpy.data.objects.remove(slab)
    scene.render.film_transparent = True
    assert np.array_equal(tyndall_pixels(scene, 4, "RGBA"), np.zeros((16, 16, 4), np.float32))
    scene.render.film_transparent = False
    assert tyndall_pixels(scene, 4) == pytest.approx(np.full((16, 16, 3), WORLD), abs=1e-6)
    floor.is_shadow_catcher = hill.is_shadow_catcher = False
    assert np.ptp(tyndall_pixels(scene, 4)) > 0.1


def test_a_clear_share_catches_less() -> None:
    """Of a floor that half of the light passes, half of the shadow is seen."""
    scene, floor, _ = stage()
    sun()
    scene.render.film_transparent = True
    whole = tyndall_pixels(scene, 16, "RGBA")
    floor.active_material = material("Half", surface=half_clear)
    half = tyndall_pixels(scene, 16, "RGBA")
    is_floor = whole[..., 0] == 0.0
    assert np.count_nonzero(is_floor) > 200
    assert half[is_floor, 3] == pytest.approx(whole[is_floor, 3] / 2, abs=1e-5)
    assert whole[..., 3][is_floor].max() > 0.5


def test_the_pass_holds_what_the_picture_then_leaves_out(tmp_path: Path) -> None:
    """A photograph times the pass, under the picture without it, is the picture with the world as that photograph."""
    scene, *_ = stage((0.5, 0.5, 0.5))
    sun()
    together = tyndall_pixels(scene, 16)
    scene.view_layers[0].tyndall.use_pass_shadow_catcher = True
    scene.render.film_transparent = True
    apart = render_passes(scene, tmp_path, "TYNDALL", 16, is_filtered=False).planes
    caught, picture = apart["Shadow Catcher"], apart["Combined"]
    assert picture[..., :3] + (1.0 - picture[..., 3:]) * 0.5 * caught == pytest.approx(together, abs=2e-6)
    assert caught.min() < 0.7


def test_mirrors_show_catchers_as_they_are() -> None:
    """Only cameras see no more than the shadows."""
    scene, floor, slab = stage()
    floor.active_material = material("Floor glows", surface=glow(0.7))
    sharp = {"Roughness": 0.0, "Color": (0.9, 0.9, 0.9, 1.0)}
    name = "ShaderNodeBsdfGlossy" if bpy.app.version < (4, 0, 0) else "ShaderNodeBsdfAnisotropic"
    slab.active_material = material("Mirror", surface=lambda new, _link: node(new, name, **sharp).outputs[0])
    slab.rotation_euler = (0.0, 1.1, 0.0)
    scene.tyndall.indirect.has_mirrors = True
    scene.render.film_transparent = True
    caught = tyndall_pixels(scene, 4, "RGBA")
    shows_floor = np.isclose(caught[..., 0], 0.9 * 0.7, atol=1e-3)
    assert np.count_nonzero(shows_floor) > 4
    floor.is_shadow_catcher = False
    assert np.array_equal(caught[shows_floor], tyndall_pixels(scene, 4, "RGBA")[shows_floor])


def test_what_catchers_would_mirror_alone_meets_no_others_at_any_depth() -> None:
    """Between two mirrors a slab stops light that goes up from the floor and comes back: half of half of what glows."""

    def mirror(share: float) -> Build:
        name = "ShaderNodeBsdfGlossy" if bpy.app.version < (4, 0, 0) else "ShaderNodeBsdfAnisotropic"

        def build(new: New, link: Link) -> Socket:
            mix = new("ShaderNodeMixShader")
            mix.inputs[0].default_value = share
            link(node(new, "ShaderNodeEmission", Strength=1.0).outputs[0], mix.inputs[1])
            link(node(new, name, Roughness=0.0, Color=(1.0, 1.0, 1.0, 1.0)).outputs[0], mix.inputs[2])
            return mix.outputs[0]

        return build

    scene, floor, slab = stage((0.0, 0.0, 0.0))
    floor.active_material = material("Half a mirror", surface=mirror(0.5))
    ceiling = plane(3.0, material("Mirror", surface=mirror(1.0)), half_side=5.0)
    slab.scale, slab.active_material = (8.0, 8.0, 0.1), material("Black", surface=diffuse((0.0, 0.0, 0.0)))
    ceiling.is_shadow_catcher, ceiling.visible_camera, slab.visible_camera = True, False, False
    scene.tyndall.indirect.has_mirrors, scene.tyndall.indirect.mirror_depth = True, 1
    scene.render.film_transparent = True
    kept = 0.5 / (0.5 + 0.5 * 0.5)
    assert tyndall_pixels(scene, 1, "RGBA")[..., 3] == pytest.approx(np.full((16, 16), 1.0 - kept), abs=1e-4)
