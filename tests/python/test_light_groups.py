# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups without Blender: planes add up, whatever gives the light; recolouring the air leaves them alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from support.plain_scenes import camera_above, placed, square, sun, translation, unit_cube
from tyndall import InvalidInput, Progress
from tyndall.renderer import Film, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    Light,
    LightKind,
    LobeModel,
    Lobes,
    Material,
    Medium,
    ObjectLighting,
    ScatterLobe,
    SceneDescription,
    World,
)
from tyndall.transfer_functions import Layer, TransferFunction, WeightedFunction

GROUPS = ("a", "b", "world")
GLOSSY = Lobes(model=LobeModel.GLOSSY, inputs=((1.0,) * 3, (0.9, 0.7, 0.4), (0.25,) * 3), registers=(-1,) * 3)
ALL = RenderConfig(pixel_samples=4, passes=frozenset({"Shafts"}), keeps_light_groups=True)


def lamp(index: int, group: str) -> Light:
    """In a ring above the floor, with a size, so that pixels share its strata."""
    place = translation(1.5 * np.cos(index), 1.5 * np.sin(index), 1.5 + 0.1 * (index % 5))
    return Light(
        name=f"Lamp {index}",
        kind=LightKind.POINT,
        strength=(0.3, 0.2 + 0.1 * (index % 3), 0.1),
        world_from_light=place,
        radius_m=0.3,
        light_group=group,
    )


def stage(lamp_count: int, *, is_foggy: bool) -> SceneDescription:
    """A floor, a cube, a plate that glows in group "b", and lamps of both groups; fog."""
    plate = replace(placed(square(), translation(-1, 0, 2.5), materials=(1,)), lighting=ObjectLighting(light_group="b"))
    floor, block = placed(square(), np.diag([3.0, 3, 1, 1])), placed(unit_cube(), np.diag([0.4, 0.4, 0.4, 1]))
    fog = placed(unit_cube(), np.diag([2.0, 2, 2, 1]) @ translation(0, 0, 0.01), materials=(2,))
    return SceneDescription(
        instances=(floor, block, plate, *((fog,) if is_foggy else ())),
        materials=(
            Material(name="grey", lobes=(GLOSSY,)),
            Material(name="glow", emission=(1.0, 2.0, 0.5)),
            Material(name="fog", has_surface=False, medium=0),
        ),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.2, 0.2, 0.2), asymmetry_g=0.3),)),),
        lights=tuple(lamp(index, "ab"[index % 2]) for index in range(lamp_count)),
        world=World(radiance=(0.1, 0.1, 0.3), light_group="world"),
        light_groups=GROUPS,
    )


def rendered(description: SceneDescription, config: RenderConfig = ALL) -> Film:
    session = Session()
    session.update(description, Progress())
    return session.render(camera_above(size_px=(16, 16)), config, Progress())


def sum_of_groups(film: Film, kind: str = "Combined") -> NDArray[np.float64]:
    return np.sum([film.planes[f"{kind}_{name}"].astype(np.float64) for name in GROUPS], axis=0)


@pytest.mark.parametrize("is_foggy", [False, True])
@pytest.mark.parametrize("lamp_count", [2, 40])
def test_the_planes_of_all_groups_make_the_picture(lamp_count: int, *, is_foggy: bool) -> None:
    """Asked each, or drawn from the light tree, with and without pixels that share strata; to float precision."""
    description = stage(lamp_count, is_foggy=is_foggy)
    film = rendered(description)
    combined = film.planes["Combined"][..., :3].astype(np.float64)
    assert np.abs(sum_of_groups(film) - combined).max() < 2e-6 * combined.max()
    assert all(film.planes[f"Combined_{name}"].max() > 0.01 for name in GROUPS)
    if is_foggy:
        shafts = film.planes["Shafts"].astype(np.float64)
        assert shafts.max() > 0.01
        assert np.abs(sum_of_groups(film, "Shafts") - shafts).max() < 2e-6 * shafts.max()


def test_light_of_no_group_is_in_none() -> None:
    description = stage(2, is_foggy=False)
    both = rendered(replace(description, lights=(*description.lights, sun(0.5))))
    alone = rendered(replace(description, lights=(sun(0.5),), world=World(), instances=description.instances[:2]))
    rest = both.planes["Combined"][..., :3] - sum_of_groups(both)
    # The plate shadows the sun in the first picture only.
    shown = alone.planes["Combined"][8:, 9:, :3]
    assert np.abs(rest[8:, 9:] - shown).max() < 1e-5


def test_planes_have_the_same_bits_by_any_number_of_threads_and_in_tiles() -> None:
    description = stage(40, is_foggy=True)
    film = rendered(description)
    alone = rendered(description, replace(ALL, thread_count=1))
    tile = rendered(description, replace(ALL, region_px=(4, 4, 12, 12), is_tile=True))
    for name, plane in film.planes.items():
        assert np.array_equal(alone.planes[name], plane)
        assert np.array_equal(tile.planes[name], plane[4:12, 4:12])


def test_transfer_functions_recolour_the_picture_and_no_group() -> None:
    description = stage(2, is_foggy=True)
    red = TransferFunction(name="red", layers=(Layer(name="red", colour=(1.0, 0.0, 0.0, 1.0)),))
    plain = rendered(description)
    recoloured = rendered(description, replace(ALL, transfer_functions=(WeightedFunction(function=red),)))
    assert not np.array_equal(recoloured.planes["Combined"], plain.planes["Combined"])
    for name in GROUPS:
        for kind in ("Combined", "Shafts"):
            assert np.array_equal(recoloured.planes[f"{kind}_{name}"], plain.planes[f"{kind}_{name}"])


def test_without_shared_strata_groups_change_no_more_than_the_order_of_additions() -> None:
    description = stage(40, is_foggy=True)
    config = replace(ALL, shafts=ShaftConfig(shares_strata=False))
    grouped, plain = (rendered(description, replace(config, keeps_light_groups=on)) for on in (True, False))
    assert not [name for name in plain.planes if "_" in name]
    # The shafts of each group are added up before those of all are: another order, the same light.
    assert np.abs(grouped.planes["Shafts"] - plain.planes["Shafts"]).max() < 1e-6
    assert np.abs(grouped.planes["Combined"] - plain.planes["Combined"]).max() < 1e-6


def test_a_session_follows_groups_that_change() -> None:
    description = stage(2, is_foggy=False)
    session = Session(follows_moves=True)
    session.update(description, Progress())
    renamed = replace(
        description,
        light_groups=("b", "a", "world"),
        lights=tuple(replace(light, light_group="a") for light in description.lights),
    )
    session.update(renamed, Progress())
    film = session.render(camera_above(size_px=(16, 16)), ALL, Progress())
    assert film.planes["Combined_a"].max() > 0.01
    assert film.planes["Combined_b"].max() > 0.1  # the plate, which the camera sees
    fresh = rendered(renamed)
    assert all(np.array_equal(film.planes[name], fresh.planes[name]) for name in fresh.planes)


def test_two_groups_of_one_name_are_refused() -> None:
    with pytest.raises(InvalidInput, match='two light groups "a"'):
        rendered(replace(stage(2, is_foggy=False), light_groups=("a", "a")))
