# SPDX-License-Identifier: GPL-3.0-or-later
"""Shafts of many lamps, and of a sky over many triangles, are drawn sample by sample: in the mean what rows find."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.plain_scenes import camera_above, placed, random_smoke, square, translation, unit_cube
from tyndall import Progress
from tyndall.renderer import Film, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    Light,
    LightBody,
    LightKind,
    Material,
    Medium,
    ScatterLobe,
    SceneDescription,
    StrandForm,
    StrandObjects,
    Strands,
    VoxelObjects,
    World,
)
from tyndall.voxel_dag import Config, from_coordinates

SAMPLES = 64
DRAWN = RenderConfig(
    pixel_samples=SAMPLES,
    noise_threshold=0.0,
    passes=frozenset({"Shafts"}),
    shafts=ShaftConfig(method="EPIPOLAR", light_samples=4),
)
ROWS = replace(DRAWN, shafts=replace(DRAWN.shafts, method="EXACT", world_samples=256))


def lamps(count: int) -> tuple[Light, ...]:
    random = np.random.default_rng(4)
    places = random.uniform((-1.8, -1.8, 0.2), (1.8, 1.8, 1.8), (count, 3))
    return tuple(
        Light(
            name=f"Lamp {index}",
            kind=(LightKind.POINT, LightKind.SPOT)[index % 2],
            strength=tuple(random.uniform(0.2, 2.0, 3)),
            world_from_light=translation(*place),
            light_group="even" if index % 2 == 0 else "",
        )
        for index, place in enumerate(places)
    )


def stage(lights: tuple[Light, ...] = (), **changes: object) -> SceneDescription:
    """Fog over a floor, with posts in it."""
    posts = [translation(x, y, 0.0) @ np.diag([0.15, 0.15, 1.5, 1.0]) for x in (-0.9, 0.6) for y in (-0.7, 1.0)]
    scene = SceneDescription(
        instances=(
            placed(square(), np.diag([3.0, 3, 1, 1])),
            placed(unit_cube(), *posts),
            placed(unit_cube(), np.diag([2.0, 2, 2, 1]), materials=(1,)),
        ),
        materials=(Material(name="grey"), Material(name="fog", has_surface=False, medium=0)),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.1, 0.2, 0.3), asymmetry_g=0.3),)),),
        lights=lights,
        light_groups=("even",),
    )
    return replace(scene, **changes)


def rendered(description: SceneDescription, config: RenderConfig, size_px: tuple[int, int] = (12, 8)) -> Film:
    session = Session()
    session.update(description, Progress())
    return session.render(camera_above(size_px=size_px), config, Progress())


def is_drawn(film: Film, what: str) -> bool:
    return any(skipped["what"] == f"light shafts: rows of {what}" for skipped in film.statistics["skipped"])


def with_grid(scene: SceneDescription, cells: int) -> SceneDescription:
    """And 2 x cells x cells triangles far below, which nothing sees: rows would hold them all."""
    side = np.linspace(-3.0, 3.0, cells + 1, dtype=np.float32)
    x, y = np.meshgrid(side, side)
    corner = (np.arange(cells)[:, np.newaxis] * (cells + 1) + np.arange(cells)).ravel()
    quads = np.stack([corner, corner + 1, corner + cells + 2, corner + cells + 1], axis=1)
    floor = replace(
        square("floor"),
        positions=np.stack([x, y, np.full_like(x, -1.0)], axis=-1).reshape(-1, 3),
        triangles=quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3).astype(np.uint32),
        uv_maps=(),
    )
    return replace(scene, instances=(*scene.instances, placed(floor, np.eye(4))))


@pytest.mark.parametrize("samples", [1, 16])
@pytest.mark.parametrize("looks", ["opaque", "half", "clear"])
def test_triangles_that_let_a_part_of_the_light_pass_count_for_what_their_rows_take(looks: str, samples: int) -> None:
    """10,000 far below the fog: of those that stop all light, or none, rows are soon told."""
    passing = {"opaque": 0.0, "half": 0.5, "clear": 1.0}[looks]
    scene = with_grid(stage(world=World(name="sky", radiance=(0.3, 0.5, 0.9))), 70)
    far = replace(scene.instances[-1], materials=(len(scene.materials),))
    veil = Material(name="veil", transparent=(passing,) * 3)
    scene = replace(scene, instances=(*scene.instances[:-1], far), materials=(*scene.materials, veil))
    film = rendered(scene, replace(DRAWN, pixel_samples=samples), (40, 24))
    assert is_drawn(film, "the world") == (looks == "half")


# Seen to fail: with opaque triangles counted as for rows.
def test_with_maps_opaque_triangles_are_no_reason_to_draw_and_those_that_let_light_pass_are() -> None:
    scene = with_grid(stage(world=World(name="sky", radiance=(0.3, 0.5, 0.9))), 300)
    veiled = replace(scene.instances[-1], materials=(len(scene.materials),))
    veil = Material(name="veil", transparent=(0.5,) * 3)
    veils = replace(scene, instances=(*scene.instances[:-1], veiled), materials=(*scene.materials, veil))
    by_maps = replace(DRAWN, shafts=replace(DRAWN.shafts, method="SHADOW_MAP"))
    assert not is_drawn(rendered(scene, by_maps), "the world")
    drawn = rendered(veils, by_maps)
    assert is_drawn(drawn, "the world")
    assert_same_in_the_mean(drawn, rendered(stage(world=scene.world), ROWS))  # the veil lies below all air


def assert_same_in_the_mean(drawn: Film, rows: Film) -> None:
    ours, truth = drawn.planes["Shafts"].astype(float), rows.planes["Shafts"].astype(float)
    difference = (ours - truth).mean(axis=2) / truth.mean()
    noise = difference.std() / np.sqrt(difference.size)
    assert noise < 0.01
    assert abs(difference.mean()) < 4.0 * noise + 2e-3


def test_three_hundred_lamps_light_the_air_in_the_mean_as_exact_rows_say() -> None:
    drawn, rows = (rendered(stage(lamps(300)), config, (20, 12)) for config in (DRAWN, ROWS))
    assert is_drawn(drawn, "lamps")
    assert not is_drawn(rows, "lamps")
    assert_same_in_the_mean(drawn, rows)


#: What draws and rows both know of smoke is told apart from how rows march through it.
TRACKED = replace(ROWS, shafts=replace(ROWS.shafts, grid_method="RATIO_TRACKING", world_samples=2048))


def with_smoke(scene: SceneDescription) -> SceneDescription:
    """And a cloud, which sends on most of the light, in its fog, of another phase function, of random voxels."""
    smoke = Medium(
        name="smoke",
        lobes=(ScatterLobe(sigma_s_per_m=(3.0, 2.0, 2.0), asymmetry_g=-0.4),),
        sigma_a_per_m=(0.5, 1.0, 2.0),
    )
    fog = replace(scene.media[0], lobes=(ScatterLobe(sigma_s_per_m=(0.01, 0.02, 0.02), asymmetry_g=0.3),))
    return replace(scene, volumes=(random_smoke(1),), media=(fog, smoke))


# Seen to fail: with rows wherever there are grids, as it was before; with as many lamps as of even fog; without a tenth
# of what smoke scatters.
@pytest.mark.parametrize("looks", ["smoke", "fog"])
def test_sixty_lamps_light_smoke_in_the_mean_as_exact_rows_say(looks: str) -> None:
    """Rows' rays take steps through smoke for each lamp; without it so many lamps' rows are soon asked."""
    above = translation(0.0, 0.0, 1.4)
    scene = stage(tuple(replace(lamp, world_from_light=above @ lamp.world_from_light) for lamp in lamps(60)))
    scene = with_smoke(scene) if looks == "smoke" else scene
    drawn = rendered(scene, DRAWN, (20, 12))
    assert is_drawn(drawn, "lamps") == (looks == "smoke")
    assert_same_in_the_mean(drawn, rendered(scene, TRACKED, (20, 12)))


def test_a_sky_over_many_triangles_lights_smoke_in_the_mean_as_exact_strata_say() -> None:
    scene = with_smoke(stage(world=World(radiance=(0.5, 0.7, 1.0))))
    drawn = rendered(with_grid(scene, 300), DRAWN)
    assert is_drawn(drawn, "the world")
    assert_same_in_the_mean(drawn, rendered(scene, TRACKED))


# Seen to fail: of one sample, with four draws.
@pytest.mark.parametrize("samples", [1, SAMPLES])
def test_a_sky_over_many_triangles_lights_the_air_in_the_mean_as_exact_strata_say(samples: int) -> None:
    """A draft has as many draws to a pixel as a picture of more samples, and no more noise in its air."""
    scene = stage(world=World(radiance=(0.5, 0.7, 1.0)))
    size_px = (24, 16) if samples == 1 else (12, 8)
    rows = rendered(scene, replace(ROWS, pixel_samples=samples), size_px)
    drawn = rendered(with_grid(scene, 300), replace(DRAWN, pixel_samples=samples), size_px)
    assert is_drawn(drawn, "the world")
    assert_same_in_the_mean(drawn, rows)


# Seen to fail: with triangles alone counted, as it was before.
@pytest.mark.parametrize(
    ("form", "hidden_count"),
    [pytest.param(StrandForm.ROUND_LINEAR, 0, id="traced"), pytest.param(StrandForm.ROUND, 90000, id="many")],
)
def test_a_sky_over_hair_lights_the_air_in_the_mean_as_exact_strata_say(form: StrandForm, hidden_count: int) -> None:
    """Each texel of its rows would ask for cones by a ray, or each of its rows would cut very many hairs."""
    scene = stage(world=World(radiance=(0.5, 0.7, 1.0)))
    hairs = np.array(
        [[x, y, z, 0.1] for x in (-1.0, 0.0, 1.0) for y in (-0.5, 0.5) for z in (0.0, 0.5, 1.0)], np.float32
    )
    one = np.array([[0, 0, z, 0.01] for z in (0.0, 0.02, 0.04)], np.float32)
    points = np.concatenate((hairs, np.tile(one, (hidden_count, 1))))
    strands = Strands(
        key="hair",
        name="hair",
        form=form,
        points=points,
        first_points=np.arange(0, len(points), 3, dtype=np.uint32),
    )
    scene = replace(
        scene,
        strand_objects=(StrandObjects(strands=strands, world_from_object=np.eye(4)[None], object_names=("hair",)),),
    )
    drawn, rows = rendered(scene, DRAWN), rendered(scene, ROWS)
    assert is_drawn(drawn, "the world")
    assert_same_in_the_mean(drawn, rows)


# Seen to fail: with triangles and hair alone counted, as it was before.
@pytest.mark.parametrize("side", [pytest.param(128, id="traced"), pytest.param(100, id="drawn")])
def test_a_sky_over_voxels_lights_the_air_in_the_mean_as_exact_strata_over_their_box_say(side: int) -> None:
    """Of so many voxels that each texel of a row asks for them by a ray, or that each row would draw a million."""
    scene = stage(world=World(radiance=(0.5, 0.7, 1.0)))
    side_m = 0.8 * 128 / side  # of a cube of 128 voxels, of which the lower ones are set
    voxels = Config(resolution=128, bounds_m=((-0.4, -0.4, 0.3), (side_m - 0.4, side_m - 0.4, side_m + 0.3)))
    dag = from_coordinates(np.indices((side,) * 3, np.uint32).reshape(3, -1).T, voxels)
    box = VoxelObjects(dag=dag, world_from_object=np.eye(4)[None], object_names=("box",))
    mesh = placed(unit_cube(), translation(0.0, 0.0, 0.3) @ np.diag([0.4, 0.4, 0.8, 1.0]))
    drawn = rendered(replace(scene, voxel_objects=(box,)), DRAWN)
    assert is_drawn(drawn, "the world")
    assert_same_in_the_mean(drawn, rendered(replace(scene, instances=(*scene.instances, mesh)), ROWS))


# Seen to fail: with the limit asked of 16 strata alone, as it was before.
def test_lamps_whose_penumbrae_ask_for_many_strata_are_drawn() -> None:
    """How many their posts' shadows are worth, a pilot finds; 2 x 16 strata of so many triangles would be no matter."""
    scene = stage(tuple(replace(lamp, radius_m=0.3, body=LightBody.FACING_DISC) for lamp in lamps(2)))
    shafts = ShaftConfig(method="EPIPOLAR", light_samples=16384, error_target=5e-4, adapts_strata=True)
    exact = replace(ROWS, shafts=replace(ROWS.shafts, light_samples=1024))
    drawn, rows = rendered(with_grid(scene, 60), replace(DRAWN, shafts=shafts)), rendered(scene, exact)
    assert is_drawn(drawn, "lamps")
    assert_same_in_the_mean(drawn, rows)
    usual = replace(shafts, light_samples=16)
    assert not is_drawn(rendered(with_grid(scene, 60), replace(DRAWN, shafts=usual)), "lamps")


# Seen to fail: with the rays of the whole picture.
def test_a_part_of_a_pictures_samples_has_rows_only_where_they_pay_for_that_part() -> None:
    """As a moment of motion blur."""
    scene = with_grid(stage(tuple(replace(lamp, radius_m=0.3) for lamp in lamps(2))), 60)
    shafts = replace(DRAWN.shafts, light_samples=16)
    assert not is_drawn(rendered(scene, replace(DRAWN, shafts=shafts)), "lamps")
    assert is_drawn(rendered(scene, replace(DRAWN, shafts=shafts, first_sample=5, sample_count=1)), "lamps")


@pytest.mark.parametrize(
    "config",
    [
        replace(DRAWN, pixel_samples=1),
        replace(DRAWN, shafts=replace(DRAWN.shafts, method="EXACT")),
        replace(DRAWN, passes=frozenset({"Shafts", "Shafts Visibility"})),
    ],
)
def test_rows_stay_where_they_pay_or_are_asked_for(config: RenderConfig) -> None:
    assert not is_drawn(rendered(stage(lamps(300)), config, (4, 4)), "lamps")


def test_few_lamps_and_a_sky_over_little_keep_rows() -> None:
    scene = stage(lamps(8), world=World(radiance=(0.5, 0.7, 1.0)))
    for film in (rendered(scene, DRAWN), rendered(with_smoke(scene), DRAWN)):
        assert not is_drawn(film, "lamps")
        assert not is_drawn(film, "the world")


def test_groups_of_drawn_lamps_add_up_and_tiles_and_threads_keep_the_bits() -> None:
    scene, config = stage(lamps(300)), replace(DRAWN, pixel_samples=16, keeps_light_groups=True)
    scene = replace(
        scene,
        lights=tuple(replace(light, light_group=light.light_group or "odd") for light in scene.lights),
        light_groups=("even", "odd"),
    )
    frame = rendered(scene, config)
    groups = [frame.planes[f"Shafts_{name}"] for name in scene.light_groups]
    assert all(group.mean() > 0.02 * frame.planes["Shafts"].mean() for group in groups)
    assert sum(groups) == pytest.approx(frame.planes["Shafts"], abs=1e-5)
    alone = rendered(scene, replace(config, thread_count=1))
    tile = rendered(scene, replace(config, region_px=(4, 4, 12, 8), is_tile=True))
    for name, plane in frame.planes.items():
        assert np.array_equal(alone.planes[name], plane)
        assert np.array_equal(tile.planes[name], plane[4:8, 4:12])
