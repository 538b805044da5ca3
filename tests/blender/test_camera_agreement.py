# SPDX-License-Identifier: GPL-3.0-or-later
"""Are equirectangular panoramas and depth of field as in Cycles? Surfaces that glow, a sun's shadows, fog, and passes.

The other panoramas: test_panoramas.py.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from addon import last_render
from addon.engine.view_rays import place_in_frame, share_of_frame
from addon.sync.cameras import read_camera
from addon.sync.reports import Reports
from support.camera_stage import SIZE_PX, agree, build_stage, cycles, fog, lens, ours, panorama
from support.cycles_reference import block_means, rendered_pixels
from support.pass_pictures import render_passes
from support.small_scenes import add, cube, empty_scene, light
from tyndall.scene_description import Camera


@pytest.fixture
def stage() -> bpy.types.Scene:
    """Coloured cubes all around, above and below, on a floor under a hard sun."""
    return build_stage()


WINDOWS = (
    ((-math.pi, math.pi), (-math.pi / 2, math.pi / 2)),
    ((-0.5, 2.5), (-1.2, 0.4)),
    ((1.0, 1.0 + 2 * math.pi), (-math.pi / 2, math.pi / 2)),  # beyond half a turn
    ((1.5, -1.0), (-0.7, 0.7)),  # mirrored
)


@pytest.mark.dealt
@pytest.mark.parametrize("window", range(len(WINDOWS)))
def test_panoramas(stage: bpy.types.Scene, window: int) -> None:
    panorama(stage, *WINDOWS[window])
    agree(f"panorama_{window}", ours(stage, 64), cycles(stage, 64))


def test_the_passes_of_a_panorama(stage: bpy.types.Scene, tmp_path: Path) -> None:
    """Depth is the distance from the camera."""
    panorama(stage, *WINDOWS[0])
    layer = stage.view_layers[0]
    layer.use_pass_z = layer.use_pass_position = layer.use_pass_mist = True
    stage.world = stage.world or bpy.data.worlds.new("World")
    stage.world.mist_settings.start, stage.world.mist_settings.depth = 1.0, 8.0
    here, there = (
        render_passes(stage, tmp_path, engine, 1, is_filtered=False).planes for engine in ("TYNDALL", "CYCLES")
    )
    for name in ("Depth", "Position", "Mist"):
        off = np.abs(here[name].astype(np.float64) - there[name])
        assert np.median(off) < 1e-3, name
        assert (off < 0.05).mean() > 0.95, name  # the rest lies on edges
    place = here["Position"].reshape(-1, here["Position"].shape[-1])[:, :3]
    far = np.linalg.norm(place - np.array(stage.camera.location), axis=1)
    depth = here["Depth"].reshape(far.shape[0], -1)[:, 0]
    seen = depth < 1e4
    assert seen.sum() > 100
    assert depth[seen] == pytest.approx(far[seen], rel=1e-5)


@pytest.mark.dealt
@pytest.mark.parametrize("method", ["EXACT", "EPIPOLAR", "SHADOW_MAP"])
def test_shafts_all_around(stage: bpy.types.Scene, method: str) -> None:
    """Towards the sun and away from it, in one picture. Nothing glows: that would light Cycles' fog alone."""
    panorama(stage, *WINDOWS[0])
    for thing in stage.objects:
        if thing.type == "MESH":
            thing.data.materials[0] = bpy.data.materials["Grey"]
    fog(0.05, 0.3)
    stage.tyndall.shafts.method = method
    agree(f"shafts_{method}", ours(stage, 16), cycles(stage, 400), 0.01, 0.015)


@pytest.mark.dealt
def test_air_all_around(stage: bpy.types.Scene) -> None:
    """Noise in the air is the same, seen by the half of a panorama or by the other, whatever columns it is kept in."""
    fog(0.1, 0.0)
    air = stage.tyndall.heterogeneity
    air.is_enabled = True
    panorama(stage, *WINDOWS[0])
    whole = ours(stage, 4)
    panorama(stage, (0.0, math.pi), WINDOWS[0][1])
    half = ours(stage, 4)
    assert half.std() > 0.01
    across = whole[:, SIZE_PX // 2 :].mean(axis=(0, 1)), half.mean(axis=(0, 1))
    assert across[0] == pytest.approx(across[1], rel=0.02)
    air.is_enabled = False
    assert ours(stage, 4).mean() != pytest.approx(half.mean(), rel=1e-4)


LENSES: dict[str, tuple[str, dict[str, Any]]] = {
    "disc": ("PERSP", {"focus_distance": 2.0, "aperture_fstop": 0.1}),
    "blades": (
        "PERSP",
        {"focus_distance": 8.0, "aperture_fstop": 0.08, "aperture_blades": 5, "aperture_rotation": 0.5},
    ),
    "anamorphic": ("PERSP", {"focus_distance": 8.0, "aperture_fstop": 0.08, "aperture_ratio": 2.0}),
    "orthographic": ("ORTHO", {"focus_distance": 1.0, "aperture_fstop": 8.0}),
    "panorama": ("PANO", {"focus_distance": 1.5, "aperture_fstop": 0.1}),
}


@pytest.mark.dealt
@pytest.mark.parametrize("name", list(LENSES))
def test_depth_of_field(stage: bpy.types.Scene, name: str) -> None:
    kind, focus = LENSES[name]
    if kind == "PANO":
        panorama(stage, *WINDOWS[0])
    lens(stage, kind, **focus)
    blurred = ours(stage)
    agree(f"lens_{name}", blurred, cycles(stage))
    stage.camera.data.dof.use_dof = False
    assert np.abs(ours(stage, 16) - blurred).mean() > 0.02 * blurred.mean()


def sheets_of_light() -> bpy.types.Scene:
    """A low sun through slits beside the view, one to two metres ahead: sheets of light that the camera looks along."""
    scene = empty_scene(SIZE_PX)
    scene.render.resolution_percentage = 100
    bars = [((-1.2, 0.75, 0.3 * index - 2.0), (0.02, 0.75, 0.08)) for index in range(16)]
    walls = [((-1.2, 5.5, 0.0), (0.02, 4.0, 5.0)), ((-1.2, -4.0, 0.0), (0.02, 4.0, 5.0))]
    for index, (place, half_sides) in enumerate(bars + walls):
        thing = cube(f"Bar{index}")
        thing.location, thing.scale = place, half_sides
    sun = light("SUN", (0, 0, 5), energy=20.0)
    sun.data.angle, sun.rotation_euler = 0.0, (0.0, math.radians(-80.0), 0.0)
    scene.camera.location, scene.camera.rotation_euler = (0.0, -1.0, 0.0), (math.pi / 2, 0.0, 0.0)
    scene.camera.data.clip_start = 0.01
    fog(0.05, 0.3)
    return scene


@pytest.mark.costly
def test_shafts_behind_a_lens() -> None:
    """What is near blurs, what lies in focus does not; through one place of the lens all is sharp.

    Pictures through many places may each have a larger error: their mean has what is asked for.
    """
    scene = sheets_of_light()
    lens(scene, "PERSP", focus_distance=5.0, aperture_fstop=0.1, aperture_blades=5, aperture_ratio=1.5)
    shafts = scene.tyndall.shafts
    reference, found = cycles(scene, 900), {}
    for shafts.method in ("EXACT", "EPIPOLAR", "SHADOW_MAP"):
        found[shafts.method] = ours(scene, 32)
        agree(f"lens_shafts_{shafts.method}", found[shafts.method], reference, 0.004, 0.01)
        off = np.sqrt(np.square(found[shafts.method] - found["EXACT"]).mean()) / found["EXACT"].mean()
        assert off < 1.5 * shafts.error_target, shafts.method
    shafts.lens_steps = 1
    off = [np.abs(block_means(one) - block_means(reference)).mean() for one in (ours(scene, 32), found["EXACT"])]
    assert off[0] > 3.0 * off[1]


@pytest.mark.dealt
@pytest.mark.parametrize("method", ["EXACT", "EPIPOLAR"])
def test_air_behind_a_lens_is_as_bright_as_without_with_every_seed(method: str) -> None:
    """Places on the lens have the light samples of one picture among them: an aperture that blurs nothing leaves it.

    A sky lights a box of fog.
    """
    scene = empty_scene(24)
    scene.render.resolution_percentage = 100
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.5, 1)
    cube("Thing")
    scene.camera.location.z = 5.0
    fog(0.2, -0.3)
    lens(scene, "PERSP", focus_distance=5.0, aperture_fstop=1000.0)
    scene.tyndall.shafts.method, scene.tyndall.shafts.world_samples = method, 64

    def level(seed: int) -> float:
        scene.tyndall.seed = seed
        return float(ours(scene, 8).mean())

    through_the_lens = [level(seed) for seed in range(4)]
    scene.camera.data.dof.use_dof = False
    assert through_the_lens == pytest.approx([level(seed) for seed in range(4)], rel=0.005)


def test_places_on_the_lens_join_moments_of_the_shutter(stage: bpy.types.Scene) -> None:
    """Each moment has one, so that both blurs take as many renders as the finer one; without fog there is one."""
    stage.render.resolution_percentage = 30
    stage.tyndall.pixel_samples, stage.tyndall.motion_steps, stage.tyndall.shafts.lens_steps = 8, 2, 4
    lens(stage, "PERSP", focus_distance=2.0, aperture_fstop=0.1)
    assert "light shafts: places on the lens" not in counts_of(stage)
    fog(0.05, 0.3)
    assert counts_of(stage)["light shafts: places on the lens"] == 4
    stage.render.use_motion_blur = True
    counts = counts_of(stage)
    assert counts["light shafts: places on the lens"] == counts["motion blur: renders"] == 4
    stage.tyndall.shafts.lens_steps = 1
    assert counts_of(stage)["motion blur: renders"] == 1  # nothing moves


def counts_of(scene: bpy.types.Scene) -> dict[str, float]:
    scene.render.engine = "TYNDALL"
    rendered_pixels(scene)
    counts: dict[str, float] = (last_render.statistics_of(scene.name) or {})["counts"]
    return counts


@pytest.mark.dealt
def test_focus_on_an_object(stage: bpy.types.Scene) -> None:
    """Along the view, not as the crow flies; and what is in focus is sharp."""
    there = add("There", None)
    there.location = (2.5, 2.0, -1.0)
    lens(stage, "PERSP", focus_object=there, aperture_fstop=0.1)
    agree("focus_object", ours(stage), cycles(stage))


def what_the_camera_reports(scene: bpy.types.Scene) -> tuple[Camera, tuple[str, ...]]:
    reports = Reports()
    thing = scene.camera.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return read_camera(thing, scene.render, (SIZE_PX, SIZE_PX), reports), reports.lines()


def test_nothing_in_focus_is_said(stage: bpy.types.Scene) -> None:
    lens(stage, "PERSP", focus_distance=0.0)
    camera, (line,) = what_the_camera_reports(stage)
    assert camera.lens is None
    assert 'Camera "Camera"' in line
    assert "focuses at 0 m" in line


def test_an_empty_panorama_is_refused(stage: bpy.types.Scene) -> None:
    panorama(stage, (0.5, 0.5), (-1.0, 1.0))
    with pytest.raises(ValueError, match=r'Camera "Camera": .* are equal'):
        what_the_camera_reports(stage)


@pytest.mark.parametrize("window", range(len(WINDOWS)))
def test_a_point_shows_where_the_ray_through_it_is(stage: bpy.types.Scene, window: int) -> None:
    """What picks constraints and what marks them are each other's inverse."""
    panorama(stage, *WINDOWS[window])
    for place_px in ((3.0, 5.0), (80.0, 60.0), (45.0, 45.0)):
        ray = place_in_frame(bpy.context.evaluated_depsgraph_get(), place_px).ray()
        assert ray is not None
        origin, direction = ray
        assert (origin - stage.camera.location).length == pytest.approx(0.01, rel=1e-3)
        at = share_of_frame(bpy.context, stage, origin + 3.0 * direction)
        assert at is not None
        assert np.array(at) * SIZE_PX == pytest.approx(np.array(place_px), abs=1e-3)
