# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups: passes named as Cycles names them, which hold its light, of surfaces and of the air."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from support.pass_pictures import passes_of_both, render_passes
from support.small_scenes import add, cube, empty_scene, light, material, node, plane, read

pytestmark = pytest.mark.dealt

SIZE_PX = 24
GROUPS = ("key", "fill", "sky", "glow")


def in_group(thing: bpy.types.Object | bpy.types.World, name: str) -> None:
    thing.lightgroup = name


@pytest.fixture
def stage() -> bpy.types.Scene:
    """A cube on a floor; spot, point lamp, world and a plate that glows, each in its group; a sun in none."""
    scene = empty_scene(SIZE_PX)
    scene.camera.location, scene.camera.rotation_euler = (0, -8, 6), (0.9, 0, 0)
    scene.camera.data.type = "PERSP"
    plane(half_side=4)
    cube("Box").location = (0.5, 0.5, 1)
    layer = scene.view_layers[0]
    for name in GROUPS:
        layer.lightgroups.add().name = name
    key = light("SPOT", (-3, -2, 5), energy=900.0, color=(1, 0.5, 0.2), shadow_soft_size=0.1, spot_size=1.2)
    key.rotation_euler = (0.5, -0.5, 0)
    in_group(key, "key")
    in_group(light("POINT", (3, -3, 4), energy=300.0, color=(0.2, 0.5, 1), shadow_soft_size=0.2), "fill")
    light("SUN", (0, 0, 5), energy=0.5).rotation_euler = (0.6, 0.3, 0)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.2, 0.15, 1)
    in_group(scene.world, "sky")
    glowing = material(
        "Glowing",
        surface=lambda new, _: node(new, "ShaderNodeEmission", Strength=4.0, Color=(0.2, 1, 0.3, 1)).outputs[0],
    )
    plate = plane(2.0, glowing, half_side=0.5)
    plate.name, plate.location = "Plate", (-2, 1, 0)
    in_group(plate, "glow")
    return scene


def add_fog() -> None:
    """A box of it."""
    fog = material(
        "Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.1, Anisotropy=0.3).outputs[0]
    )
    box = cube("Fog", fog)
    box.scale, box.location = (4, 4, 3), (0, 0, 3.01)


def picture(scene: bpy.types.Scene, folder: Path, samples: int = 16) -> dict[str, NDArray[np.float64]]:
    planes = render_passes(scene, folder, "TYNDALL", samples).planes
    return {name: plane.astype(np.float64) for name, plane in planes.items()}


def largest(values: NDArray[np.float64]) -> float:
    return float(np.abs(values).max())


def test_passes_have_the_names_and_channels_of_cycles(stage: bpy.types.Scene) -> None:
    ours, theirs = ({entry for entry in found if entry[0].startswith("Combined_")} for found in passes_of_both(stage))
    assert ours == theirs
    assert len(theirs) == len(GROUPS)


@pytest.mark.parametrize("is_foggy", [False, True])
def test_groups_and_what_is_in_none_make_combined(stage: bpy.types.Scene, tmp_path: Path, *, is_foggy: bool) -> None:
    """To float precision; and without a light in no group, nothing is left."""
    stage.view_layers[0].tyndall.use_pass_shafts = True
    stage.tyndall.indirect.has_bounce = not is_foggy
    if is_foggy:
        add_fog()
    for is_sun_on in (True, False):
        bpy.data.objects["Sun"].hide_render = not is_sun_on
        found = picture(stage, tmp_path)
        combined, shafts = found["Combined"][..., :3], found["Shafts"]
        rest = combined - sum(found[f"Combined_{name}"] for name in GROUPS)
        rest_of_shafts = shafts - sum(found[f"Shafts_{name}"] for name in GROUPS)
        assert (largest(shafts) > 0.01) is is_foggy
        if is_sun_on:
            assert largest(rest) > 0.02
            assert (largest(rest_of_shafts) > 0.005) is is_foggy
        else:
            assert largest(rest) < 2e-6 * largest(combined)
            assert largest(rest_of_shafts) < 2e-6 * max(largest(shafts), 1e-3)
    for name in GROUPS:
        assert found[f"Combined_{name}"].mean() > 0.005
        assert (found[f"Shafts_{name}"] <= found[f"Combined_{name}"] + 1e-6).all()


def test_groups_change_no_other_pass(stage: bpy.types.Scene, tmp_path: Path) -> None:
    grouped = picture(stage, tmp_path, 4)["Combined"]
    layer = stage.view_layers[0]
    layer.active_lightgroup_index = 0
    assert bpy.ops.scene.view_layer_remove_lightgroup() == {"FINISHED"}
    fewer = picture(stage, tmp_path, 4)
    assert "Combined_key" not in fewer
    while layer.lightgroups:
        bpy.ops.scene.view_layer_remove_lightgroup()
    plain = picture(stage, tmp_path, 4)
    assert np.array_equal(plain["Combined"], grouped)
    assert np.array_equal(fewer["Combined"], grouped)


def test_an_instance_without_a_group_has_that_of_its_instancer(stage: bpy.types.Scene) -> None:
    lamps = bpy.data.collections.new("Lamps")
    lamp = bpy.data.objects["Point"]
    lamps.objects.link(lamp)
    stage.collection.objects.unlink(lamp)
    lamp.lightgroup = ""
    for name in ("sky", "gone", ""):
        placed = add(f"By {name}", None)
        placed.instance_type, placed.instance_collection = "COLLECTION", lamps
        in_group(placed, name)
    groups = [found.light_group for found in read().lights if found.name == "Point"]
    assert sorted(groups) == ["", "", "sky"]


@pytest.mark.parametrize("is_foggy", [False, True])
def test_groups_hold_the_light_that_those_of_cycles_hold(
    stage: bpy.types.Scene, tmp_path: Path, *, is_foggy: bool
) -> None:
    """Their mean, and their blocks of 4 x 4 pixels, to the noise that two seeds of Cycles tell."""
    names = GROUPS
    if is_foggy:
        add_fog()
        names = ("key", "fill", "sky")
    ours = picture(stage, tmp_path, 64)
    first, second = (render_passes(stage, tmp_path, "CYCLES", 256, seed=seed).planes for seed in (1, 2))
    for name in names:
        mine, one, two = (
            planes[f"Combined_{name}"].astype(np.float64).reshape(SIZE_PX // 4, 4, SIZE_PX // 4, 4, 3).mean((1, 3))
            for planes in (ours, first, second)
        )
        theirs, spread = (one + two) / 2, float(np.sqrt(((one - two) ** 2).mean() / 2))
        assert theirs.mean() > 0.005
        assert mine.mean() == pytest.approx(theirs.mean(), rel=0.01)
        assert float(np.sqrt(((mine - theirs) ** 2).mean())) < 2 * spread + 0.01 * theirs.mean()
