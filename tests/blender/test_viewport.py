# SPDX-License-Identifier: GPL-3.0-or-later
"""The rendered viewport without its window: what it looks through, reads, and shows first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

from addon.engine import viewport
from addon.engine.viewport_camera import camera_of_view
from addon.engine.viewport_worker import SCALES, View, coarser
from addon.sync import scene as sync_scene
from addon.sync.cameras import read_camera
from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.viewport_views import a_view
from tyndall.scene_description import CameraKind, Lens, Panorama

SIZES_PX = ((640, 360), (300, 500), (64, 64))


def projection_of(camera: bpy.types.Object, size_px: tuple[int, int], pixel_aspect_y: float = 1.0) -> np.ndarray:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    matrix = camera.calc_matrix_camera(depsgraph, x=size_px[0], y=size_px[1], scale_x=1.0, scale_y=pixel_aspect_y)
    return np.array(matrix)


@pytest.mark.parametrize("size_px", SIZES_PX)
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_a_camera_view_looks_through_the_camera(
    scene: bpy.types.Scene, kind: str, fit: str, size_px: tuple[int, int]
) -> None:
    """Undoing the viewport's matrix gives the camera that a final render reads from the same object."""
    thing = scene.camera
    thing.data.type, thing.data.sensor_fit = kind, fit
    thing.data.shift_x, thing.data.shift_y = 0.13, -0.21
    expected = read_camera(thing, scene.render, size_px, Reports())
    camera_from_world = np.array(thing.matrix_world.normalized().inverted())
    seen = camera_of_view(projection_of(thing, size_px), camera_from_world, size_px, expected.clip_m)
    assert seen.kind == expected.kind
    assert seen.window == pytest.approx(expected.window, rel=1e-5, abs=1e-6)
    assert seen.clip_m == pytest.approx(expected.clip_m)
    assert seen.world_from_camera == pytest.approx(expected.world_from_camera, abs=1e-5)


@pytest.mark.parametrize("perspective", ["CAMERA", "PERSP"])
def test_a_view_ends_where_it_says_however_near_it_begins(scene: bpy.types.Scene, perspective: str) -> None:
    """From a ratio of 1e8 on Blender's matrix knows no far plane: all was beyond it, and the view empty."""
    lens = scene.camera.data
    lens.clip_start, lens.clip_end = clip_m = 0.001, 100000.0
    clipped = SimpleNamespace(clip_start=lens.clip_start, clip_end=lens.clip_end)
    of_view = SimpleNamespace(clip_start=0.1, clip_end=1.0)
    context = SimpleNamespace(
        space_data=SimpleNamespace(camera=scene.camera, **vars(of_view if perspective == "CAMERA" else clipped)),
        region_data=SimpleNamespace(
            window_matrix=projection_of(scene.camera, (64, 36)),
            view_matrix=scene.camera.matrix_world.normalized().inverted(),
            view_perspective=perspective,
        ),
    )
    seen = viewport._camera_of(context, bpy.context.evaluated_depsgraph_get(), (64, 36))  # noqa: SLF001
    assert seen.clip_m == pytest.approx(clip_m)


def test_a_free_orthographic_view_sees_behind_its_centre() -> None:
    """Its near plane is negative; our camera steps back and sees the same points at the same pixels."""
    half_width_m, near_m, far_m = 4.0, -1000.0, 1000.0
    projection = np.diag([1 / half_width_m, 1 / half_width_m, -2 / (far_m - near_m), 1.0])
    projection[2, 3] = -(far_m + near_m) / (far_m - near_m)
    camera = camera_of_view(projection, np.eye(4), (100, 100), (0.1, 1.0))
    assert camera.kind == CameraKind.ORTHOGRAPHIC
    assert camera.window == pytest.approx((-4, 4, -4, 4))
    assert camera.clip_m == pytest.approx((0, 2000))
    assert camera.world_from_camera[:3, 3] == pytest.approx((0, 0, 1000))


class OutOfTimeError(Exception):
    pass


def test_a_scene_read_in_slices_goes_on_where_it_was(scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """A large scene must not hold up the window: reading stops, and lets the window draw."""
    for index in range(40):
        mesh = bpy.data.meshes.new("mesh")
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, index)], [], [(0, 1, 2)])
        scene.collection.objects.link(bpy.data.objects.new("object", mesh))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    read: list[str] = []
    monkeypatch.setattr(sync_scene, "read_mesh", counting(sync_scene.read_mesh, read))
    reader = SceneReader()
    slices, reads_left = 0, 0

    def poll() -> None:
        if len(read) >= reads_left:
            raise OutOfTimeError

    description = None
    while description is None:
        slices, reads_left = slices + 1, len(read) + 8
        try:
            description = reader.read(depsgraph, Reports(), poll, is_live=True)
        except OutOfTimeError:
            continue
    assert slices > 4
    assert len(read) == 41  # none is read again
    assert sum(len(group.object_names) for group in description.instances) == 41


def counting(function: Callable[..., Any], calls: list[str]) -> Callable[..., Any]:
    def counted(mesh: bpy.types.Mesh, *arguments: Any, **options: Any) -> Any:
        calls.append(mesh.name)
        return function(mesh, *arguments, **options)

    return counted


@pytest.mark.parametrize("scale", SCALES)
def test_a_coarse_picture_covers_whole_blocks_of_pixels(scale: int) -> None:
    """Its pixels are ``scale`` times as large, from the same corner, so that nothing jumps when the finer one comes."""
    view = a_view()
    rough = coarser(view, scale)
    for axis in (0, 1):
        low, high = view.camera.window[2 * axis : 2 * axis + 2]
        rough_low, rough_high = rough.camera.window[2 * axis : 2 * axis + 2]
        pixel_m = (high - low) / view.camera.size_px[axis]
        assert rough_low == low
        assert (rough_high - rough_low) / rough.camera.size_px[axis] == pytest.approx(scale * pixel_m)
        assert rough_high >= high


def test_a_first_picture_asks_one_place_on_each_lamp_in_fog() -> None:
    """A map of light is made for each, which does not care how few pixels there are: eleven times as long as one."""
    view = a_view()
    for asked, expected in ((8, [1, 2, 4]), (2, [1, 2, 2])):
        shafts = replace(view.config.shafts, light_samples=asked)
        fine = View(camera=view.camera, config=replace(view.config, shafts=shafts))
        assert [coarser(fine, scale).config.shafts.light_samples for scale in SCALES] == expected


def test_a_view_is_another_with_any_other_camera() -> None:
    """Also where only the rim of a fisheye is."""
    view = a_view()
    assert view.is_like(a_view())
    for change in (
        {"world_from_camera": np.eye(4) * 2.0},
        {"kind": CameraKind.PANORAMIC},
        {"window": (-1.0, 1.0, -0.5, 0.6)},
        {"clip_m": (0.2, 100.0)},
        {"lens": Lens(radius_m=0.1, focus_m=2.0)},
        {"panorama": Panorama(rim=0.5)},
    ):
        assert not view.is_like(replace(view, camera=replace(view.camera, **change))), change
