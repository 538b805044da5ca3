# SPDX-License-Identifier: GPL-3.0-or-later
"""Level of detail of voxels in pictures: far voxels cover, and look, as all of them together would."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from support.plain_scenes import translation
from tyndall import InvalidInput, Progress, voxel_dag
from tyndall.renderer import Film, RenderConfig, Session
from tyndall.scene_description import (
    Camera,
    CameraKind,
    Light,
    LightKind,
    Material,
    SceneDescription,
    VoxelObjects,
)
from tyndall.voxel_dag import VoxelDag

SIDE = 256
PIXELS = 16  #: A side, so that 16 x 16 voxels of a plane fit into one.
GLOW = Material(name="glow", diffuse=(0.0,) * 3, emission=(1.0,) * 3)
Sheet = Callable[[NDArray[np.int64], NDArray[np.int64]], NDArray[np.bool_]]
SHEETS: dict[str, tuple[Sheet, float]] = {
    "checker": (lambda x, y: (x + y) % 2 == 0, 0.5),
    "fence": (lambda x, y: (x % 8 < 3) | (y % 64 < 4), 0.375 + 0.625 / 16),
    "wires": (lambda x, y: (x % 16 == 5) | (y % 64 == 9), 1 / 16 + 15 / 16 / 64),
    "dots": (lambda x, y: (x % 16 == 3) & (y % 16 == 7), 1 / 256),
    "full": (lambda x, y: x + y >= 0, 1.0),
}


def sheets(*names: str, colors: bool = False) -> VoxelDag:
    """One voxel thick, across y, apart from each other; in a cube of 1 m."""
    x, z = np.meshgrid(np.arange(SIDE), np.arange(SIDE), indexing="ij")
    places = []
    for i, name in enumerate(names):
        is_there = SHEETS[name][0](x, z)
        places.append(np.stack([x[is_there], np.full(is_there.sum(), 37 + 100 * i), z[is_there]], -1))
    voxels = np.concatenate(places)
    config = voxel_dag.Config(resolution=SIDE, bounds_m=((0, 0, 0), (1, 1, 1)))
    if colors:
        checks = np.where((voxels[:, :1] + voxels[:, 2:]) % 2 == 0, (255, 0, 0), (0, 0, 255)).astype(np.uint8)
        config = replace(config, colors=checks)
    return voxel_dag.from_coordinates(voxels, config)


def camera(kind: CameraKind, turn_rad: float = 0.0) -> Camera:
    """Looks along y, or turned about the cube's middle, and sees all of the cube."""
    place = translation(0.5, 0.5, 0.5)
    place[:3, :3] = [[np.cos(turn_rad), 0, np.sin(turn_rad)], [np.sin(turn_rad), 0, -np.cos(turn_rad)], [0, 1, 0]]
    place[:3, 3] += place[:3, 2] * 100.0
    half = 0.5 if kind is CameraKind.ORTHOGRAPHIC else 0.005
    return Camera(
        kind=kind,
        world_from_camera=place,
        window=(-half, half, -half, half),
        clip_m=(1.0, 200.0),
        size_px=(PIXELS, PIXELS),
    )


def aimed(back: NDArray[np.float64], distance_m: float) -> NDArray[np.float64]:
    """From there to the cube's middle, looking along -Z."""
    back = back / np.linalg.norm(back)
    right = np.cross([0.3, 0.2, 1.0], back)
    right /= np.linalg.norm(right)
    place = translation(*(0.5 + distance_m * back))
    place[:3, :3] = np.stack([right, np.cross(back, right), back], -1)
    return place


def picture(
    seen: Camera,
    thing: VoxelDag,
    material: Material = GLOW,
    sun: tuple[float, float, float] | None = None,
    **settings: object,
) -> Film:
    """Under a sun, from the camera unless it is said whence."""
    session = Session()
    where = VoxelObjects(dag=thing, world_from_object=np.eye(4)[None], object_names=("thing",), material=0)
    place = seen.world_from_camera if sun is None else aimed(np.array(sun), 1.0)
    light = Light(name="sun", kind=LightKind.SUN, strength=(1.0,) * 3, world_from_light=place)
    session.update(SceneDescription(voxel_objects=(where,), materials=(material,), lights=(light,)), Progress())
    config = RenderConfig(film_transparent=True, **settings)  # type: ignore[arg-type]
    return session.render(seen, config, Progress())


def coverage(*arguments: object, **settings: object) -> NDArray[np.float32]:
    film = picture(*arguments, **settings)  # type: ignore[arg-type]
    return film.planes["Combined"][2:-2, 2:-2, 3]  # away from the edges


@pytest.mark.parametrize("name", SHEETS)
@pytest.mark.parametrize("kind", CameraKind)
@pytest.mark.parametrize("detail_px", [0.1, 0.3, 1.0])
def test_far_sheets_cover_what_their_voxels_cover(name: str, kind: CameraKind, detail_px: float) -> None:
    # Pixels apart may see more or less of a fence; together they see its share.
    settings = {"pixel_samples": 64, "voxel_detail_px": detail_px}
    found = coverage(camera(kind), sheets(name), **settings)
    share = SHEETS[name][1]
    assert abs(found.mean() - share) < 0.01 + 0.02 * share
    assert found.std() < 0.07
    if name == "full":
        assert found.min() == 1.0


@pytest.mark.parametrize("name", ["fence", "wires", "full"])  # of a checker, voxels show their sides then
@pytest.mark.parametrize("turn_rad", [0.4, 0.9])
def test_turned_sheets_cover_what_256_samples_of_every_voxel_find(name: str, turn_rad: float) -> None:
    seen, thing = camera(CameraKind.PERSPECTIVE, turn_rad), sheets(name)
    truth = coverage(seen, thing, pixel_samples=256, voxel_detail_px=0.0)
    found = coverage(seen, thing, pixel_samples=256, voxel_detail_px=1.0)
    inner = slice(4, -4)  # of a sheet that is narrower now
    assert abs(found[:, inner].mean() - truth[:, inner].mean()) < 0.05


def test_sheets_one_behind_the_other_hide_each_other_by_chance() -> None:
    thing = sheets("checker", "fence")
    found = coverage(camera(CameraKind.ORTHOGRAPHIC), thing, pixel_samples=64, voxel_detail_px=1.0)
    checker, fence = SHEETS["checker"][1], SHEETS["fence"][1]
    assert abs(found.mean() - (checker + fence - checker * fence)) < 0.02


def test_without_shares_of_their_own_cubes_would_have_covered_all() -> None:
    """A sheet of dots covers 1 / 256 of a picture, and not all of it, as the cube around each dot would."""
    found = coverage(camera(CameraKind.ORTHOGRAPHIC), sheets("dots"), pixel_samples=256, voxel_detail_px=1.0)
    assert 0.5 / 256 < found.mean() < 2 / 256


def test_a_cube_has_the_mean_colour_of_its_voxels_and_is_lit_as_they_are() -> None:
    thing = sheets("full", colors=True)
    seen = camera(CameraKind.ORTHOGRAPHIC)
    far = picture(seen, thing, WHITE, pixel_samples=16, voxel_detail_px=1.0).planes["Combined"][3:-3, 3:-3, :3]
    near = picture(seen, thing, WHITE, pixel_samples=1024, voxel_detail_px=0.0).planes["Combined"][3:-3, 3:-3, :3]
    np.testing.assert_allclose(near.mean((0, 1)), [0.5 / np.pi, 0.0, 0.5 / np.pi], rtol=0.02)
    np.testing.assert_allclose(far, np.broadcast_to(near.mean((0, 1)), far.shape), rtol=0.02, atol=1e-6)


SLOPE = np.array([(0, 0, 0.1), (1, 0, 0.45), (1, 1, 0.63), (0, 1, 0.28)])
WHITE = Material(name="white", diffuse=(1.0,) * 3)


def slope(normals: str | None, sun: tuple[float, float, float], detail_px: float) -> Film:
    config = voxel_dag.Config(resolution=512, bounds_m=((0, 0, 0), (1, 1, 1)), normals=normals, normal_bits=16)
    thing = voxel_dag.voxelize(SLOPE, np.array([(0, 1, 2), (0, 2, 3)]), config)
    seen = replace(
        camera(CameraKind.ORTHOGRAPHIC),
        world_from_camera=aimed(np.array([0.2, -0.3, 0.9]), 50.0),
        window=(-0.2, 0.2, -0.2, 0.2),
    )
    return picture(seen, thing, WHITE, sun=sun, pixel_samples=64, voxel_detail_px=detail_px)


@pytest.mark.parametrize("detail_px", [0.2, 0.7, 1.4])
@pytest.mark.parametrize("sun", [(0.0, 0.0, 1.0), (-0.9, 0.0, 0.4), (0.0, -0.97, 0.25), (0.7, 0.1, 0.5)])
def test_a_far_slope_is_lit_by_its_normals_and_does_not_shadow_itself(
    sun: tuple[float, float, float], detail_px: float
) -> None:
    """As a smooth slope: neither a cube nor its neighbours shadow it."""
    normal = np.cross(SLOPE[1] - SLOPE[0], SLOPE[3] - SLOPE[0])
    cosine = normal @ sun / np.linalg.norm(normal) / np.linalg.norm(sun)
    light = slope("faces", sun, detail_px).planes["Combined"]
    assert light[..., 3].min() > 0.98
    if detail_px > 0.5:  # else voxels are met, whose neighbours shadow them
        np.testing.assert_allclose(light[..., 0].mean(), cosine / np.pi, rtol=0.02)


@pytest.mark.parametrize("sun", [(0.0, 0.0, 1.0), (-0.9, 0.0, 0.4), (0.5, 0.3, 0.8)])
def test_a_far_slope_without_normals_is_as_bright_as_its_steps(sun: tuple[float, float, float]) -> None:
    near, far = (slope(None, sun, detail_px).planes["Combined"] for detail_px in (0.0, 0.7))
    assert far[..., 3].min() > 0.98
    np.testing.assert_allclose(far[..., 0].mean(), near[..., 0].mean(), rtol=0.03)


def test_pictures_do_not_depend_on_threads_and_kept_ones_are_the_same() -> None:
    thing, seen = sheets("checker", "wires"), camera(CameraKind.PERSPECTIVE, 0.3)
    one, two = (
        picture(seen, thing, pixel_samples=4, voxel_detail_px=1.0, thread_count=count).planes["Combined"]
        for count in (1, 2)
    )
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("detail_px", [-1.0, 65.0, np.nan])
def test_a_detail_that_means_nothing_is_refused(detail_px: float) -> None:
    with pytest.raises(InvalidInput, match="voxel_detail_px"):
        picture(camera(CameraKind.ORTHOGRAPHIC), sheets("dots"), pixel_samples=1, voxel_detail_px=detail_px)
