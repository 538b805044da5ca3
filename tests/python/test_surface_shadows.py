# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits that shadow surfaces: a floor is dark where the air above it is, and no surface shadows itself."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from support.plain_scenes import camera_above, placed, square, sun, translation, unit_cube
from tyndall import Progress
from tyndall.renderer import Film, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    Camera,
    CameraKind,
    EditKind,
    HoleNoise,
    Instances,
    KernelShape,
    Light,
    LightKind,
    Material,
    Medium,
    Mesh,
    OccluderEdit,
    ScatterLobe,
    SceneDescription,
)

SIZE_PX = (96, 96)
SEEN_M = 4.5  #: of the ground, by camera_above
ROOF_M = 1.5
LAMP_M = 4.5  #: above the ground: what it throws there is half as large again as at the roof
HOLE_M = 1.2
EDITS = {
    kind: OccluderEdit(name=kind.name, kind=kind, size_m=0.3, affects_surfaces=True)
    for kind in EditKind
    if kind != EditKind.HOLES
}


def plate_with_hole(hole_m: float) -> Instances:
    """Four plates around a square hole over the origin; the camera looks through them."""
    outer = 20.0
    sides = [translation(x * (outer + hole_m / 2), 0, ROOF_M) @ np.diag([outer, 40.0, 1.0, 1.0]) for x in (-1, 1)] + [
        translation(0, y * (outer + hole_m / 2), ROOF_M) @ np.diag([hole_m / 2, outer, 1.0, 1.0]) for y in (-1, 1)
    ]
    return replace(placed(square("roof"), *sides), is_camera_visible=False)


GROUND = placed(square("ground"), np.diag([40.0, 40.0, 1.0, 1.0]))


def scene(light: Light, *edits: OccluderEdit, things: Iterable[Instances] = ()) -> SceneDescription:
    return SceneDescription(
        instances=(GROUND, *things),
        materials=(Material(name="grey"), Material(name="fog", has_surface=False, medium=0)),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.05,) * 3),)),),
        lights=(replace(light, occluder_edits=edits),),
    )


def picture(
    description: SceneDescription, camera: Camera | None = None, config: RenderConfig | None = None
) -> tuple[NDArray[np.float32], Film]:
    """What surfaces send (rows from below), and the film."""
    session = Session()
    session.update(description, Progress())
    film = session.render(camera or camera_above(size_px=SIZE_PX), config or still(), Progress())
    return film.planes["Combined"][..., 0] - film.planes["Shafts"][..., 0], film


def still(**shafts: object) -> RenderConfig:
    """Pixels' centres."""
    settings: dict[str, object] = {"method": "SHADOW_MAP", "resolution": 2048}
    return RenderConfig(pixel_samples=1, passes=frozenset({"Shafts"}), shafts=ShaftConfig(**(settings | shafts)))  # type: ignore[arg-type]


def lamp(**changes: object) -> Light:
    light = Light(name="Lamp", kind=LightKind.POINT, strength=(30.0,) * 3, world_from_light=translation(0, 0, LAMP_M))
    return replace(light, **changes)  # type: ignore[arg-type]


def spot() -> Light:
    return lamp(kind=LightKind.SPOT, spot_half_angle_rad=0.7)


#: With the width on the ground of what is a metre wide at the roof.
LIGHTS = [(sun(), 1.0), (lamp(), LAMP_M / (LAMP_M - ROOF_M)), (spot(), LAMP_M / (LAMP_M - ROOF_M))]
LIGHT_NAMES = ["sun", "point", "spot"]


def places_m() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """X and y on the ground, of pixels' centres."""
    at = (np.arange(SIZE_PX[0]) + 0.5) / SIZE_PX[0] * SEEN_M - SEEN_M / 2
    return np.meshgrid(at, at)


@pytest.mark.parametrize(("light", "spread"), LIGHTS, ids=LIGHT_NAMES)
@pytest.mark.parametrize("shape", KernelShape)
def test_the_floor_is_lit_where_a_kernel_fits_into_the_hole(light: Light, spread: float, shape: KernelShape) -> None:
    """What a closing leaves of a square hole is where its kernel fits in: a disc rounds its corners.

    In the analytic set's border of two texels and a pixel anything may be; elsewhere every pixel agrees.
    """
    size_m = 0.8 * HOLE_M
    close = OccluderEdit(
        name="c", kind=EditKind.CLOSE, shape=shape, size_m=size_m, distance_m=LAMP_M - ROOF_M, affects_surfaces=True
    )
    floor, _ = picture(scene(light, close, things=[plate_with_hole(HOLE_M)]))
    x, y = places_m()
    half, radius = spread * HOLE_M / 2, spread * size_m / 2
    if shape == KernelShape.SQUARE:
        outside_m = np.maximum(np.abs(x), np.abs(y)) - half
    else:
        inner = half - radius
        outside_m = np.hypot(np.maximum(np.abs(x) - inner, 0), np.maximum(np.abs(y) - inner, 0)) - radius
    is_clear = np.abs(outside_m) > 0.03 * spread
    assert np.array_equal((floor > 0)[is_clear], (outside_m < 0)[is_clear])
    assert is_clear.mean() > 0.9
    # A disc of 0.8 of the side leaves out (1 - pi / 4) of its square: these pixels are what makes it a disc.
    open_floor, _ = picture(scene(light, things=[plate_with_hole(HOLE_M)]))
    assert np.array_equal(floor[floor > 0], open_floor[floor > 0])
    assert ((open_floor > 0) & (floor == 0)).sum() > (40 if shape == KernelShape.DISC else -1)


@pytest.mark.parametrize(("light", "spread"), LIGHTS, ids=LIGHT_NAMES)
def test_under_a_closed_hole_floor_and_air_are_dark(light: Light, spread: float) -> None:
    """A hole that is narrower than the kernel: no light is left, neither on the floor nor in the air below the roof."""
    del spread
    fog = placed(unit_cube(), np.diag([40.0, 40.0, ROOF_M - 0.01, 1.0]), materials=(1,))
    close = OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=2 * HOLE_M, distance_m=LAMP_M - ROOF_M)
    things = [plate_with_hole(HOLE_M), fog]
    before, film_before = picture(scene(light, things=things))
    for_air, film = picture(scene(light, close, things=things))
    assert np.array_equal(for_air > 0, before > 0)
    assert film.planes["Shafts"].mean() < 0.02 * film_before.planes["Shafts"].mean()
    for_both, film = picture(scene(light, replace(close, affects_surfaces=True), things=things))
    assert for_both.max() == 0.0
    assert film.planes["Shafts"].mean() < 0.02 * film_before.planes["Shafts"].mean()


@pytest.mark.parametrize("kind", EDITS)
@pytest.mark.parametrize(("light", "spread"), LIGHTS, ids=LIGHT_NAMES)
def test_an_edit_that_changes_nothing_changes_no_bit(light: Light, spread: float, kind: EditKind) -> None:
    """Of a floor alone there is nothing to fill; and what is drawn out of a floor is floor, however low the light."""
    del spread
    low = np.eye(4)
    low[0, [0, 2]], low[2, [0, 2]] = (math.cos(1.2), math.sin(1.2)), (-math.sin(1.2), math.cos(1.2))
    for place in (np.eye(4), low) if light.kind == LightKind.SUN else (light.world_from_light, translation(3, 1, 0.8)):
        moved = replace(light, world_from_light=place)
        without, _ = picture(scene(moved))
        assert without.max() > 0 or light.kind == LightKind.SPOT
        film = picture(scene(moved, EDITS[kind]))[0]
        assert np.array_equal(film, without)


@pytest.mark.parametrize("kind", EDITS)
def test_creases_and_pits_do_not_shadow_themselves(kind: EditKind) -> None:
    """Steps of 10 cm under kernels of 30 cm: the sun's own shadows stay, and nothing else gets dark."""
    steps = placed(unit_cube(), *(translation(0.2 * i, 0, 0) @ np.diag([0.05, 3.0, 0.1, 1.0]) for i in range(-9, 10)))
    tilted = np.eye(4)
    tilted[0, [0, 2]], tilted[2, [0, 2]] = (math.cos(0.5), math.sin(0.5)), (-math.sin(0.5), math.cos(0.5))
    light = replace(sun(), world_from_light=tilted)
    without, _ = picture(scene(light, things=[steps]))
    assert np.array_equal(picture(scene(light, EDITS[kind], things=[steps]))[0], without)


def test_a_silhouette_that_is_drawn_out_shadows_the_floor_behind_it() -> None:
    """Away from the camera only: the shadow of a bar gets longer on the one side, by what it grows."""
    bar = replace(
        placed(square("bar"), translation(0.8, 0, ROOF_M) @ np.diag([0.1, 3.0, 1.0, 1.0])), is_camera_visible=False
    )
    grown = OccluderEdit(name="s", kind=EditKind.SILHOUETTE, size_m=0.4, affects_surfaces=True)
    config = still()
    row = SIZE_PX[1] // 2
    before = picture(scene(sun(), things=[bar]), config=config)[0][row]
    after = picture(scene(sun(), grown, things=[bar]), config=config)[0][row]
    x = places_m()[0][row]
    # The camera stands over the origin: away from it is towards +x.
    assert np.array_equal(before == 0, (x > 0.7) & (x < 0.9))
    assert np.array_equal(after[np.abs(x - 1.3) > 0.05] == 0, ((x > 0.7) & (x < 1.3))[np.abs(x - 1.3) > 0.05])


def test_filling_along_the_view_darkens_the_floor_below_the_sheet_that_it_spans() -> None:
    """In each plane of the light the hole is closed by what the camera sees edge on: its line of sight past the rim.

    Floor that lies clearly below that line is dark, floor above it, which the camera sees through the hole, is lit.
    """
    length_m, camera_m, camera_z = 1.2 * HOLE_M, 3.0, 5.0
    along = OccluderEdit(name="e", kind=EditKind.EPIPOLAR_CLOSE, size_m=length_m, affects_surfaces=True)
    camera = replace(camera_above(translation(camera_m, 0, 0), size_px=SIZE_PX), window=(-0.8, 0.0, -0.4, 0.4))
    open_floor, _ = picture(scene(sun(), things=[plate_with_hole(HOLE_M)]), camera)
    floor, _ = picture(scene(sun(), along, things=[plate_with_hole(HOLE_M)]), camera)
    at = (np.arange(SIZE_PX[0]) + 0.5) / SIZE_PX[0] * 0.8 * camera_z
    x, y = np.meshgrid(at - 0.8 * camera_z, at - 0.4 * camera_z)  # from the camera's foot
    radius = np.hypot(x, y)
    near = np.maximum((camera_m - HOLE_M / 2) / -x, 0) * radius
    far = np.minimum((camera_m + HOLE_M / 2) / -x, HOLE_M / 2 / np.maximum(np.abs(y), 1e-9)) * radius
    below_m = camera_z - (camera_z - ROOF_M) * radius / near
    is_open = open_floor > 0
    is_dark = is_open & (far - near < length_m - 0.05) & (below_m > length_m / 4 + 0.1)
    is_lit = is_open & (below_m < length_m / 4 - 0.1)
    assert is_dark.sum() > 100 < is_lit.sum()
    assert floor[is_dark].max() == 0.0
    assert np.array_equal(floor[is_lit], open_floor[is_lit])


def test_close_to_the_line_to_the_light_through_the_camera_rows_are_closed_from_one_side_and_not_for_surfaces() -> None:
    """There a hole would be filled by its far rim alone: the floor keeps its light."""
    along = OccluderEdit(name="e", kind=EditKind.EPIPOLAR_CLOSE, size_m=1.2 * HOLE_M, affects_surfaces=True)
    open_floor, _ = picture(scene(sun(), things=[plate_with_hole(HOLE_M)]))
    assert np.array_equal(picture(scene(sun(), along, things=[plate_with_hole(HOLE_M)]))[0], open_floor)


def test_holes_made_before_filling_are_filled_and_those_made_after_it_stay() -> None:
    """In the order of the list, on the floor as in the air; fine noise that kernels of half a metre close."""
    roof = replace(
        placed(square("roof"), translation(0, 0, ROOF_M) @ np.diag([40.0, 40.0, 1.0, 1.0])), is_camera_visible=False
    )
    noise = HoleNoise(scale_m=0.3, probability=0.3)
    holes = OccluderEdit(name="holes", kind=EditKind.HOLES, noise=noise, affects_surfaces=True)
    close = OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=0.6, affects_surfaces=True)
    alone, after, before = (
        (picture(scene(sun(), *edits, things=[roof]))[0] > 0).mean()
        for edits in ((holes,), (close, holes), (holes, close))
    )
    assert 0.2 < alone < 0.4
    assert after == alone
    assert before < 0.02


def test_a_light_with_a_size_fills_what_every_part_of_it_sees() -> None:
    """A disc in a square takes the corners' light, (1 - pi / 4) size^2 of side^2, whatever the penumbra.

    Rays go by the nearest stratum: along the corners' borders they are off by up to its distance. The more strata, the
    less light comes past what was filled.
    """
    wide = replace(sun(), half_angle_rad=0.1)
    size_m = 0.8 * HOLE_M
    close = OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=size_m, affects_surfaces=True)
    share = 1 - (1 - math.pi / 4) * (size_m / HOLE_M) ** 2
    before = picture(scene(wide, things=[plate_with_hole(HOLE_M)]), config=replace(still(), pixel_samples=64))[0]
    errors = []
    for strata in (4, 64):
        config = replace(still(light_samples=strata), pixel_samples=64)
        after = picture(scene(wide, close, things=[plate_with_hole(HOLE_M)]), config=config)[0]
        assert (after <= before + 1e-6).all()
        errors.append(after.sum() / before.sum() - share)
    assert abs(errors[1]) < 0.02
    assert 1.5 * abs(errors[1]) < abs(errors[0]) < 0.2


def test_without_a_medium_and_seen_in_parallel_edits_shadow_surfaces_all_the_same() -> None:
    close = OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=2 * HOLE_M, affects_surfaces=True)
    clear = replace(scene(sun(), close, things=[plate_with_hole(HOLE_M)]), media=())
    clear = replace(clear, materials=clear.materials[:1])
    assert picture(clear)[0].max() == 0.0
    parallel = replace(camera_above(size_px=SIZE_PX), kind=CameraKind.ORTHOGRAPHIC, window=(-2, 2, -2, 2))
    assert picture(clear, parallel)[0].max() == 0.0


def test_edits_along_a_view_that_the_sun_shines_along_are_named() -> None:
    along = OccluderEdit(name="e", kind=EditKind.SILHOUETTE, size_m=0.5, affects_surfaces=True)
    parallel = replace(camera_above(size_px=SIZE_PX), kind=CameraKind.ORTHOGRAPHIC, window=(-2, 2, -2, 2))
    description = scene(sun(), along, things=[plate_with_hole(HOLE_M)])
    floor, film = picture(description, parallel)
    assert np.array_equal(floor, picture(scene(sun(), things=[plate_with_hole(HOLE_M)]), parallel)[0])
    assert any("Sun" in line and "shines along the view" in line for line in film.statistics["reports"])


def test_an_edit_finer_than_a_texel_is_named() -> None:
    fine = OccluderEdit(name="fine", kind=EditKind.CLOSE, size_m=1e-5, affects_surfaces=True)
    _, film = picture(scene(sun(), fine, things=[plate_with_hole(HOLE_M)]), config=still(resolution=64))
    assert any('"fine" is too fine to show on surfaces' in line for line in film.statistics["reports"])


def test_a_leaf_shadows_neither_itself_nor_its_neighbour() -> None:
    """A sphere of facets, lit from the side, under every edit at once: no pixel of its lit side gets dark."""
    rings, turns = 24, 48
    up, around = np.meshgrid(np.linspace(0, math.pi, rings + 1), np.linspace(0, 2 * math.pi, turns + 1), indexing="ij")
    positions = np.stack([np.sin(up) * np.cos(around), np.sin(up) * np.sin(around), np.cos(up)], -1).reshape(-1, 3)
    index = np.arange((rings + 1) * (turns + 1)).reshape(rings + 1, turns + 1)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    mesh = Mesh(key="ball", name="ball", positions=positions.astype(np.float32), triangles=triangles.astype(np.uint32))
    ball = placed(mesh, translation(0, 0, 1.2))
    tilted = np.eye(4)
    tilted[0, [0, 2]], tilted[2, [0, 2]] = (math.cos(0.8), math.sin(0.8)), (-math.sin(0.8), math.cos(0.8))
    light = replace(sun(), world_from_light=tilted)
    without, film = picture(scene(light, things=[ball]))
    edited, _ = picture(scene(light, *EDITS.values(), things=[ball]))
    x, y = places_m()
    is_ball = np.hypot(x, y) < 0.95  # at least: it stands nearer to the camera
    assert np.array_equal(edited[is_ball], without[is_ball])
    assert (edited[is_ball] > 0).mean() > 0.6
    assert film.planes["Combined"].shape == (*SIZE_PX, 4)
