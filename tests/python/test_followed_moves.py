# SPDX-License-Identifier: GPL-3.0-or-later
"""Descriptions that share all but a few groups with the last one: these alone are looked at; no picture can tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from support.plain_scenes import placed, square, sun, translation, unit_cube
from tyndall import Progress
from tyndall.moved_instances import is_same, moved_groups, sharing
from tyndall.renderer import RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    Camera,
    CameraKind,
    Instances,
    Material,
    Medium,
    ScatterLobe,
    SceneDescription,
    World,
)
from tyndall.scene_origin import free_places, origin_of

CONFIG = RenderConfig(
    pixel_samples=2,
    passes=frozenset({"Shadow", "Normal", "Position"}),
    shafts=ShaftConfig(method="SHADOW_MAP", resolution=64, light_samples=2, world_samples=2),
)
FLOOR, FIRST_CUBE, PANES, FOG = 0, 1, 9, 10  #: Groups.


def scene() -> SceneDescription:
    """A floor, cubes in a group each, two panes in one, and a box of fog."""
    rng = np.random.default_rng(4)
    cubes = [translation(*rng.uniform(-2.0, 2.0, 2), 0.1) @ np.diag([0.2, 0.3, 0.5, 1.0]) for _ in range(8)]
    return SceneDescription(
        instances=(
            placed(square("floor"), np.diag([9.0, 9.0, 1.0, 1.0])),
            *(placed(unit_cube(), matrix) for matrix in cubes),
            placed(square("pane"), translation(0.0, 0.0, 1.2), translation(0.5, 1.0, 1.4), materials=(1,)),
            placed(
                replace(unit_cube(), key="fog"), translation(0, 0, -0.5) @ np.diag([3.0, 3.0, 3.0, 1.0]), materials=(2,)
            ),
        ),
        materials=(
            Material(name="grey"),
            Material(name="pane", transparent=(0.7, 0.5, 0.3), diffuse=(0.1,) * 3),
            Material(name="fog", has_surface=False, medium=0),
        ),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.05,) * 3),)),),
        lights=(sun(),),
        world=World(radiance=(0.3, 0.4, 0.5)),
    )


def camera() -> Camera:
    """From above."""
    return Camera(
        kind=CameraKind.PERSPECTIVE,
        world_from_camera=translation(0.0, 0.0, 8.0),
        window=(-0.5, 0.5, -0.3, 0.3),
        clip_m=(0.1, 100.0),
        size_px=(60, 36),
    )


def with_group(description: SceneDescription, index: int, change: Callable[[Instances], Instances]) -> SceneDescription:
    """All other groups are the same objects."""
    groups = list(description.instances)
    groups[index] = change(groups[index])
    return replace(description, instances=tuple(groups))


def moved(description: SceneDescription, index: int, by: NDArray[np.float64]) -> SceneDescription:
    """By a matrix in the world."""
    return with_group(description, index, lambda group: replace(group, world_from_object=by @ group.world_from_object))


def updated(session: Session, description: SceneDescription) -> dict[str, float]:
    """After it draws what a session draws that saw nothing before."""
    session.update(description, Progress())
    fresh = Session()
    fresh.update(description, Progress())
    counts = session.statistics["counts"]
    film, expected = (one.render(camera(), CONFIG, Progress()) for one in (session, fresh))
    for name, plane in expected.planes.items():
        assert np.array_equal(film.planes[name], plane), name
    assert session.statistics["reports"] == fresh.statistics["reports"]
    return counts


@pytest.mark.parametrize(
    ("index", "by"),
    [
        (FIRST_CUBE, translation(0.3, 0.1, 0.2)),
        (FIRST_CUBE + 3, translation(0.0, 0.0, 50.0)),  # beyond all the others
        (FLOOR, np.diag([0.2, 0.2, 1.0, 1.0])),  # which reached furthest
        (FIRST_CUBE, np.diag([-1.0, 1.0, 1.0, 1.0])),
        (FIRST_CUBE, np.diag([1.0, 1.0, 0.0, 1.0])),  # flat
        (PANES, translation(0.4, 0.0, 0.1)),
        (FOG, translation(1.0, 0.0, 0.0)),
    ],
)
def test_a_few_that_moved_make_no_new_scene(index: int, by: NDArray[np.float64]) -> None:
    session = Session(follows_moves=True)
    before = scene()
    assert updated(session, before)["scene rebuilt"] == 1
    after = moved(before, index, by)
    counts = updated(session, after)
    assert (counts["scene rebuilt"], counts["scene moved"]) == (0, 1)
    assert counts["meshes reused"] == 4
    counts = updated(session, moved(after, FIRST_CUBE + 5, translation(0.1, 0.0, 0.0)))  # from there on
    assert (counts["scene rebuilt"], counts["scene moved"]) == (0, 1)
    counts = updated(session, after)
    assert (counts["scene rebuilt"], counts["scene moved"]) == (0, 1)
    counts = updated(session, replace(after, lights=(sun(2.0),)))
    assert (counts["scene rebuilt"], counts["scene moved"], counts["scene relit"]) == (0, 0, 1)
    counts = updated(session, replace(after, lights=(sun(2.0),)))
    assert not any(counts[name] for name in ("scene rebuilt", "scene moved", "scene relit"))


@pytest.mark.parametrize(
    "change",
    [
        lambda group: replace(group, world_from_object=np.full((1, 4, 4), np.nan)),
        lambda group: replace(group, world_from_object=np.zeros((1, 4, 4))),
        lambda group: replace(group, is_camera_visible=False),
        lambda group: replace(group, materials=(1,)),
        lambda group: replace(group, mesh=square("another")),
        lambda group: replace(group, random=np.array([0.5], np.float32)),
        lambda group: placed(group.mesh, translation(0, 0, 1), translation(0, 1, 1)),
    ],
)
def test_whatever_else_changes_makes_one(change: Callable[[Instances], Instances]) -> None:
    """And where something was left out, what moves next does, too."""
    session = Session(follows_moves=True)
    updated(session, scene())
    after = with_group(scene(), FIRST_CUBE, change)
    assert updated(session, after)["scene rebuilt"] == 1
    updated(session, moved(after, FIRST_CUBE + 1, translation(0.1, 0.0, 0.0)))


def test_a_scene_that_moves_as_a_whole_gets_a_new_origin() -> None:
    session = Session(follows_moves=True)
    description = scene()
    updated(session, description)
    for index in range(len(description.instances)):
        description = moved(description, index, translation(500.0, 0.0, 0.0))
    assert updated(session, description)["scene rebuilt"] == 1


@pytest.mark.parametrize("seed", range(12))
def test_free_places_may_go_anywhere_and_the_origin_stays(seed: int) -> None:
    """The worst that they can do: all to one side, from the other or from the middle, or be lost.

    Seen to fail where a median is thought to move by half as many steps.
    """
    rng = np.random.default_rng(seed)
    spread_m = 10.0 ** rng.uniform(-1, 4)
    # So that a coordinate of the median is not far from where it is rounded to another.
    places = rng.normal(size=(rng.integers(3000, 9000), 3), scale=spread_m) + rng.uniform(-9, 9, 3) * spread_m
    count = free_places(places)
    origin = origin_of(places)
    for axis in range(3):
        for side in (-1.0, 1.0):
            for first in np.argsort(-side * places[:, axis]), np.argsort(np.abs(places - origin).max(axis=1)):
                for target in (side * 1e9, np.nan):
                    moved = places.copy()
                    moved[first[:count]] = target
                    assert np.array_equal(origin_of(moved), origin)


def test_origins_of_even_scenes_stay_where_hundreds_move() -> None:
    places = np.random.default_rng(1).uniform(-4.0, 4.0, (100_000, 3))
    assert free_places(places) >= 512
    on_edge = places - np.median(places, axis=0) + (8.0, 0.0, 0.0)
    assert free_places(on_edge) == 0, "it is rounded to one side or to the other"
    assert free_places(places[:3]) == free_places(places[:0]) == 0


def test_trees_of_thousands_are_kept_and_no_picture_can_tell() -> None:
    """Fog that moves with them takes no tree; what had moved before is met where it is now."""
    rng = np.random.default_rng(6)
    session = Session(follows_moves=True, keeps_trees=True)
    swarm = rng.uniform((-4, -3, 0.3), (4, 3, 2.0), (4200, 3))
    small = np.diag([0.03, 0.03, 0.03, 1.0])
    description = scene()
    for index in range(FIRST_CUBE, FOG):  # which of two faces in one plane shows may change
        description = moved(description, index, translation(0.0, 0.0, rng.uniform(0.0, 0.2)))
    gnats = placed(replace(unit_cube(), key="gnat"), *(translation(*place) @ small for place in swarm))
    description = replace(description, instances=(*description.instances, gnats))
    updated(session, description)
    for _ in range(16):
        for _ in range(rng.integers(1, 3)):
            index = int(rng.integers(FLOOR, FOG + 1))
            mirror = np.diag([1.0, rng.choice([-1.0, 1.0]), 1.0, 1.0])
            description = moved(description, index, translation(*rng.normal(size=3, scale=0.3)) @ mirror)
        counts = updated(session, description)
        assert counts["scene rebuilt"] + counts["scene moved"] == 1


def test_equal_descriptions_that_share_nothing_change_nothing() -> None:
    session = Session(follows_moves=True)
    updated(session, scene())
    counts = updated(session, scene())
    assert not any(counts[name] for name in ("scene rebuilt", "scene moved", "scene relit"))


def test_what_two_descriptions_share_is_found_by_content() -> None:
    """Read twice, nothing is the same object; it is followed all the same, and told apart by what it shows."""
    before, again = scene(), scene()
    assert moved_groups(before, again) is None, "materials are other objects"
    assert is_same(before, again)
    shared = sharing(before, again)
    assert moved_groups(before, shared) == []
    assert is_same(before, shared)
    elsewhere = replace(again.instances[FIRST_CUBE], world_from_object=np.eye(4)[None])
    moved = replace(again, instances=(again.instances[FLOOR], elsewhere, *again.instances[FIRST_CUBE + 1 :]))
    assert moved_groups(before, sharing(before, moved)) == [FIRST_CUBE]
    assert not is_same(before, moved)
    assert not is_same(before, sharing(before, moved))
    brighter = replace(again, lights=(replace(sun(), strength=(2.0,) * 3),))
    assert not is_same(before, brighter)
    assert not is_same(before, sharing(before, brighter))
    assert not is_same(before, replace(again, instances=again.instances[:-1]))
    assert is_same(before, replace(again, reports=("a report",)))
