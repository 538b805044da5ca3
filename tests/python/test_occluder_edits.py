# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of occluders change the air's light alone, mean the objects that they name, and never cost their light."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from support.plain_scenes import camera_above, placed, square, sun, translation, unit_cube
from tyndall import InvalidInput, Progress
from tyndall.renderer import Film, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    EditKind,
    HoleNoise,
    Light,
    LightKind,
    LightMask,
    Material,
    Medium,
    OccluderEdit,
    ScatterLobe,
    SceneDescription,
)

METHODS = ("EXACT", "EPIPOLAR", "SHADOW_MAP")
WIDE = np.diag([40.0, 40.0, 1.0, 1.0])
HOLE_M = 1.0


def lamp() -> Light:
    return Light(name="Lamp", kind=LightKind.POINT, strength=(30.0,) * 3, world_from_light=translation(0.3, 0.2, 3.0))


def fog_below_shutters(light: Light, *edits: OccluderEdit) -> SceneDescription:
    """A metre of fog on the ground; two shutters above it leave a gap of a metre along y."""
    shutters = [translation(side * (20 + HOLE_M / 2), 0, 1.2) @ np.diag([20.0, 40.0, 1.0, 1.0]) for side in (-1, 1)]
    hidden = replace(placed(square("shutter"), *shutters), is_camera_visible=False)
    return SceneDescription(
        instances=(placed(square(), WIDE), hidden, placed(unit_cube(), WIDE, materials=(1,))),
        materials=(Material(name="grey"), Material(name="fog", has_surface=False, medium=0)),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.05,) * 3),)),),
        lights=(replace(light, occluder_edits=edits),),
    )


def rendered(description: SceneDescription, method: str = "EPIPOLAR") -> tuple[Film, list[str]]:
    session = Session()
    session.update(description, Progress())
    config = RenderConfig(
        pixel_samples=1,
        passes=frozenset({"Shafts"}),
        shafts=ShaftConfig(method=method, resolution=1024, light_samples=1),
    )
    film = session.render(camera_above(size_px=(24, 24)), config, Progress())
    return film, film.statistics["reports"]


def shafts(description: SceneDescription, method: str = "EPIPOLAR") -> float:
    return float(rendered(description, method)[0].planes["Shafts"].mean())


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("make_light", [sun, lamp])
def test_a_gap_closes_for_the_air_under_every_method_and_light(method: str, make_light: object) -> None:
    light = make_light()  # type: ignore[operator]
    open_air = shafts(fog_below_shutters(light), method)
    assert open_air > 0
    # The lamp stands 1.8 m above the shutters: there the gap is as wide as its size says.
    wide = OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=1.5 * HOLE_M, distance_m=1.8)
    assert shafts(fog_below_shutters(light, wide), method) < 0.02 * open_air
    narrow = OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=0.5 * HOLE_M, distance_m=1.8)
    assert shafts(fog_below_shutters(light, narrow), method) == pytest.approx(open_air, rel=0.02)


@pytest.mark.parametrize("make_light", [sun, lamp])
def test_a_kernel_larger_than_the_world_fills_what_there_is(make_light: object) -> None:
    light = make_light()  # type: ignore[operator]
    open_air = shafts(fog_below_shutters(light))
    edits = [OccluderEdit(name="huge", kind=kind, size_m=1e6) for kind in EditKind if kind != EditKind.HOLES]
    assert shafts(fog_below_shutters(light, edits[0])) < 0.1 * open_air
    assert shafts(fog_below_shutters(light, *edits)) < 0.1 * open_air


@pytest.mark.parametrize("method", METHODS)
def test_along_the_view_a_gap_closes_where_it_is_crossed(method: str) -> None:
    """The camera looks straight down at the sun's foot: all its planes cross the gap there but those along it."""
    light = sun()
    open_air = shafts(fog_below_shutters(light), method)
    close = OccluderEdit(name="close", kind=EditKind.EPIPOLAR_CLOSE, size_m=1.5 * HOLE_M)
    # Of a gap of width w, a plane at an angle a to it crosses w / sin(a): up to a = asin(1 / 1.5) it stays open.
    closed = shafts(fog_below_shutters(light, close), method)
    assert 0.3 * open_air < closed < 0.9 * open_air


def test_surfaces_keep_their_own_shadows() -> None:
    close = OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=2.0)
    film, _ = rendered(fog_below_shutters(sun(), close))
    before, _ = rendered(fog_below_shutters(sun()))
    ground = film.planes["Combined"][..., :3] - film.planes["Shafts"]
    assert np.allclose(ground, before.planes["Combined"][..., :3] - before.planes["Shafts"], atol=1e-6)
    assert ground.max() > 0.9 / math.pi * 0.8


def test_holes_that_are_meant_for_surfaces_let_light_onto_them() -> None:
    everywhere = OccluderEdit(name="holes", kind=EditKind.HOLES, noise=HoleNoise(probability=1.0))
    for light in (sun(), lamp()):
        without, _ = rendered(replace(fog_below_shutters(light), instances=fog_below_shutters(light).instances[::2]))
        both, _ = rendered(fog_below_shutters(light, replace(everywhere, affects_surfaces=True)))
        assert np.allclose(both.planes["Combined"], without.planes["Combined"], rtol=0.01, atol=1e-6)
        # Half of the ground shows through holes of half the area; its shadows and the air's are of the same holes.
        some = replace(everywhere, noise=HoleNoise(scale_m=0.05, probability=0.5), affects_surfaces=True)
        ground = [
            film.planes["Combined"][..., :3].mean() - film.planes["Shafts"].mean()
            for film in (rendered(fog_below_shutters(light))[0], rendered(fog_below_shutters(light, some))[0], without)
        ]
        assert ground[0] < ground[1] < ground[2]
        assert ground[1] == pytest.approx((ground[0] + ground[2]) / 2, rel=0.1)


def test_an_edit_means_the_objects_that_it_names() -> None:
    everything = HoleNoise(probability=1.0)
    one = OccluderEdit(name="holes", kind=EditKind.HOLES, noise=everything, objects=("shutter.0",))
    both = replace(one, objects=("shutter.0", "shutter.1"))
    nobody = replace(one, objects=("not there",))
    light = sun()
    gap, half, full = (shafts(fog_below_shutters(light, edit)) for edit in (nobody, one, both))
    assert gap == shafts(fog_below_shutters(light))
    # The picture sees 4.5 m of ground, the gap in its middle: fog above it sees a little less.
    assert gap < half < full
    assert half == pytest.approx((gap + full) / 2, rel=0.02)


def test_a_mask_keeps_holes_on_its_white_side() -> None:
    mask = LightMask(name="left", values=np.repeat([[1.0, 0.0]], 2, axis=0).astype(np.float32), size_m=80.0)
    holes = OccluderEdit(name="holes", kind=EditKind.HOLES, noise=HoleNoise(probability=1.0), mask=mask)
    light = sun()
    gap = shafts(fog_below_shutters(light))
    full = shafts(fog_below_shutters(light, replace(holes, mask=None)))
    assert shafts(fog_below_shutters(light, holes)) == pytest.approx((gap + full) / 2, rel=0.02)


@pytest.mark.parametrize(
    ("broken", "culprit"),
    [
        (OccluderEdit(name="Bad", kind=EditKind.CLOSE, size_m=float("nan")), "size_m"),
        (OccluderEdit(name="Bad", kind=EditKind.CLOSE, distance_m=0.0), "distance_m"),
        (OccluderEdit(name="Bad", kind=EditKind.HOLES, noise=HoleNoise(octaves=0)), "octaves"),
        (OccluderEdit(name="Bad", kind=EditKind.HOLES, noise=HoleNoise(probability=2.0)), "probability"),
        (
            OccluderEdit(
                name="Bad", kind=EditKind.HOLES, mask=LightMask(name="empty", values=np.zeros((0, 0), np.float32))
            ),
            'mask "empty"',
        ),
    ],
    ids=["size", "distance", "octaves", "probability", "mask"],
)
def test_a_broken_edit_is_named_and_its_light_keeps_the_others(broken: OccluderEdit, culprit: str) -> None:
    good = OccluderEdit(name="good", kind=EditKind.CLOSE, size_m=2.0)
    film, reports = rendered(fog_below_shutters(sun(), broken, good))
    assert any('"Sun"' in report and '"Bad"' in report and culprit in report for report in reports)
    alone, _ = rendered(fog_below_shutters(sun(), good))
    assert np.array_equal(film.planes["Combined"], alone.planes["Combined"])


def test_the_number_of_threads_changes_no_bit() -> None:
    edits = (
        OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=0.3),
        OccluderEdit(name="holes", kind=EditKind.HOLES, noise=HoleNoise(scale_m=0.4)),
        OccluderEdit(name="grow", kind=EditKind.SILHOUETTE, size_m=0.2),
    )
    session = Session()
    session.update(fog_below_shutters(sun(), *edits), Progress())
    configs = [RenderConfig(pixel_samples=1, thread_count=n, shafts=ShaftConfig(resolution=512)) for n in (1, 2)]
    films = [session.render(camera_above(size_px=(24, 24)), config, Progress()) for config in configs]
    assert np.array_equal(films[0].planes["Combined"], films[1].planes["Combined"])


def depth_pictures(light: Light, *edits: OccluderEdit) -> tuple[np.ndarray, np.ndarray]:
    session = Session()
    session.update(fog_below_shutters(light, *edits), Progress())
    return session.light_depth_picture(light.name, 256, Progress())


def test_the_picture_of_a_suns_depth_map_shows_the_gap_and_that_it_closes() -> None:
    before, after = depth_pictures(sun(), OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=2 * HOLE_M))
    assert before.shape == after.shape
    assert before.min() == 0.0
    middle = before.shape[0] // 2
    # The shutters, 1.2 m above the ground, are nearest; the ground in the gap is farthest.
    gap_m = float((before[middle] == 1.0).sum()) * 81.0 / before.shape[1]
    assert gap_m > 0.5 * HOLE_M
    inner = slice(before.shape[1] // 4, -before.shape[1] // 4)
    assert (before[middle, inner] == 1.0).any()
    assert (after[middle, inner] == 0.0).all()


def test_the_pictures_of_a_lamp_are_the_faces_of_a_cube() -> None:
    holes = OccluderEdit(name="holes", kind=EditKind.HOLES, noise=HoleNoise(probability=1.0))
    before, after = depth_pictures(lamp(), holes)
    assert before.shape[1] * 2 == before.shape[0] * 3
    assert (before < 1.0).any()
    assert (after == 1.0).all()


def test_a_light_that_is_not_there_is_named() -> None:
    session = Session()
    session.update(fog_below_shutters(sun()), Progress())
    with pytest.raises(InvalidInput, match="Moon"):
        session.light_depth_picture("Moon", 256, Progress())
    with pytest.raises(InvalidInput, match="resolution"):
        session.light_depth_picture("Sun", 8, Progress())
