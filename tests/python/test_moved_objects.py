# SPDX-License-Identifier: GPL-3.0-or-later
"""Moved objects: what they cannot have changed stays, and no picture can tell."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from support.plain_scenes import placed, square, translation, unit_cube
from tyndall import Cancelled, Progress
from tyndall.renderer import Film, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    Camera,
    CameraKind,
    Code,
    EditKind,
    HoleNoise,
    Image,
    Light,
    LightKind,
    LobeModel,
    Lobes,
    Material,
    Medium,
    OccluderEdit,
    ScatterLobe,
    SceneDescription,
    SurfaceOp,
    TextureUse,
    World,
)
from tyndall.surface_inputs import PointInput

ROOM_BYTES = 64 << 20
SIZE_PX = (160, 24)  # blocks of 64 x 4 pixels
NO_ROOM_FOR_POINTS_BYTES_PER_PX = 400  # but for samples
Matrix = NDArray[np.float64]

LEAF = Image(
    key="leaf",
    name="leaf",
    pixels=np.random.default_rng(3).choice([0, 90, 255], (16, 16, 4)).astype(np.uint8),
)
MATERIALS = (
    Material(name="grey"),
    Material(name="fog", has_surface=False, medium=0),
    Material(name="pane", transparent=(0.7, 0.5, 0.3), diffuse=(0.1,) * 3),
    Material(
        name="leaf",
        program=(
            SurfaceOp(code=Code.TEXTURE_ALPHA, out=0),
            SurfaceOp(code=Code.CONSTANT, out=1, value=(1.0,) * 3),
            SurfaceOp(code=Code.SUBTRACT, out=2, a=1, b=0),
            SurfaceOp(code=Code.MULTIPLY, out=3, a=0, b=0),
        ),
        diffuse_register=3,
        transparent_register=2,
        textures=(TextureUse(image=LEAF),),
        uv_maps=("UVMap",),
    ),
)


def turned(rng: np.random.Generator, scale: float) -> Matrix:
    """Any orientation, (4, 4)."""
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    place = np.eye(4)
    place[:3, :3] = scale * axes
    return place


def view(kind: CameraKind = CameraKind.PERSPECTIVE) -> Camera:
    """Along +Y at head height: half of what moves is beside or behind it."""
    place = np.eye(4)
    place[:3, :3] = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    place[:3, 3] = (0.0, -3.0, 1.2)
    half = 0.8 if kind is CameraKind.PERSPECTIVE else 3.0
    return Camera(
        kind=kind,
        world_from_camera=place,
        window=(-half, half, -half * SIZE_PX[1] / SIZE_PX[0], half * SIZE_PX[1] / SIZE_PX[0]),
        clip_m=(0.1, 100.0),
        size_px=SIZE_PX,
    )


def lights(*, edited: bool = False, size: float = 1.0) -> tuple[Light, ...]:
    slanted = np.eye(4)
    slanted[:3, :3] = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    holes = OccluderEdit(
        name="holes", kind=EditKind.HOLES, noise=HoleNoise(scale_m=0.5, probability=0.4), affects_surfaces=True
    )
    close = OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=0.3, affects_surfaces=True)
    return (
        Light(
            name="Sun",
            kind=LightKind.SUN,
            strength=(1.0,) * 3,
            world_from_light=slanted,
            half_angle_rad=0.1 * size,
            occluder_edits=(holes, close) if edited else (),
        ),
        Light(
            name="Lamp",
            kind=LightKind.POINT,
            strength=(9.0,) * 3,
            world_from_light=translation(-2.0, 1.0, 3.0),
            radius_m=0.2 * size,
        ),
    )


def lamps(count: int) -> tuple[Light, ...]:
    """More than are asked each, every other one with a size."""
    places = np.random.default_rng(5).uniform((-6, -6, 0.5), (6, 9, 4.0), (count, 3))
    return tuple(
        Light(
            name=f"Lamp {index}",
            kind=LightKind.POINT,
            strength=(1.0,) * 3,
            world_from_light=translation(*place),
            radius_m=0.6 * (index % 2),
        )
        for index, place in enumerate(places)
    )


@dataclass(frozen=True, kw_only=True)
class State:
    """A floor in fog; boxes, a pane and leaves, each of which may move."""

    cubes: tuple[Matrix, ...]
    panes: tuple[Matrix, ...]
    leaves: tuple[Matrix, ...]
    fog: Matrix
    camera: Camera
    config: RenderConfig
    lights: tuple[Light, ...]
    floor: Material = MATERIALS[0]

    def description(self) -> SceneDescription:
        return SceneDescription(
            instances=(
                placed(square("floor"), translation(0.013, 0.0, -0.037) @ np.diag([30.0, 30.0, 1.0, 1.0])),
                placed(unit_cube(), *self.cubes),
                placed(square("pane"), *self.panes, materials=(2,)),
                placed(square("leaf"), *self.leaves, materials=(3,)),
                placed(replace(unit_cube(), key="fog"), self.fog, materials=(1,)),
            ),
            materials=(self.floor, *MATERIALS[1:]),
            media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.05,) * 3),)),),
            lights=self.lights,
            world=World(radiance=(0.3, 0.4, 0.5)),
        )

    def picture(self, session: Session) -> Film:
        session.update(self.description(), Progress())
        return session.render(self.camera, self.config, Progress())


def place_somewhere(rng: np.random.Generator, scale: float) -> Matrix:
    return translation(*rng.uniform((-6, -6, 0.2), (6, 9, 3.0))) @ turned(rng, scale)


def start(rng: np.random.Generator, **changes: object) -> State:
    parts: dict[str, object] = {
        "cubes": tuple(place_somewhere(rng, 0.4) for _ in range(4)),
        "panes": tuple(place_somewhere(rng, 0.8) for _ in range(3)),
        "leaves": tuple(place_somewhere(rng, 0.5) for _ in range(6)),
        "fog": translation(0.0, 0.0, -0.5) @ np.diag([12.0, 12.0, 6.0, 1.0]),
        "camera": view(),
        "lights": lights(),
        "config": RenderConfig(
            pixel_samples=2,
            passes=frozenset({"Shadow", "Normal", "Shafts"}),
            shafts=ShaftConfig(method="SHADOW_MAP", resolution=64, light_samples=2, world_samples=2),
        ),
    }
    return State(**(parts | changes))  # type: ignore[arg-type]


def moved(rng: np.random.Generator, state: State) -> State:
    """One object, or one of each kind, by a nudge, across the scene, or into the camera."""
    changes = {}
    kinds = ["cubes", "panes", "leaves"]
    for kind in kinds if rng.random() < 0.2 else [rng.choice(kinds)]:
        places = list(getattr(state, kind))
        index = rng.integers(len(places))
        way = rng.random()
        if way < 0.5:
            places[index] = translation(*rng.normal(size=3, scale=0.05)) @ places[index]
        elif way < 0.9:
            places[index] = place_somewhere(rng, 0.5)
        else:
            places[index] = translation(*rng.normal((0.0, -2.9, 1.2), 0.1)) @ turned(rng, 0.3)
        changes[kind] = tuple(places)
    return replace(state, **changes)


def assert_same(film: Film, other: Film) -> None:
    assert film.planes.keys() == other.planes.keys()
    for name, plane in film.planes.items():
        assert np.array_equal(plane, other.planes[name]), name


def counts(film: Film) -> dict[str, int]:
    return {
        name.removeprefix("moved objects: "): int(count)
        for name, count in film.statistics["counts"].items()
        if name.startswith("moved objects: ")
    }


OF_STATE = {"camera", "lights", "floor"}  #: The others are of its config.
GLOSSY = Lobes(model=LobeModel.GLOSSY, inputs=((1.0,) * 3, (0.9, 0.7, 0.4), (0.25,) * 3), registers=(-1,) * 3)
VARIANTS: dict[str, dict[str, object]] = {
    "plain": {},
    "orthographic": {"camera": view(CameraKind.ORTHOGRAPHIC)},
    "edits for surfaces": {"lights": lights(edited=True)},
    "wide filter, world shared": {"pixel_samples": 4, "filter_width_px": 6.0},
    "centres": {"pixel_samples": 1},
    "region": {"region_px": (30, 3, 131, 19)},
    "transparent film": {"film_transparent": True},
    "glossy": {"floor": Material(name="glossy", lobes=(GLOSSY,)), "lights": lights(size=5.0)},
    "glowing": {"floor": Material(name="glowing", emission=(0.3, 0.2, 0.1))},
    "many lamps": {"floor": Material(name="glossy", lobes=(GLOSSY,)), "lights": (*lights(), *lamps(40))},
}


@cache
def steps_of(variant: str) -> list[tuple[State, Film]]:
    """Step by step, and now and then back: each with its picture by a session that keeps nothing."""
    rng = np.random.default_rng(list(VARIANTS).index(variant))
    changes = VARIANTS[variant]
    state = start(rng, **{name: change for name, change in changes.items() if name in OF_STATE})
    of_config = {name: change for name, change in changes.items() if name not in OF_STATE}
    state = replace(state, config=replace(state.config, **of_config))
    states = [state]
    for _ in range(7):
        states.append(rng.choice(states[-4:]) if rng.random() < 0.2 else moved(rng, states[-1]))
    return [(each, each.picture(Session())) for each in states]


@pytest.mark.parametrize("keeps_points", [True, False], ids=["points", "samples"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_no_picture_can_tell_what_moved_before(variant: str, *, keeps_points: bool) -> None:
    """Each picture is, bit for bit, that of a session that keeps nothing.

    Seen to fail with boxes of where things stood alone, or of where they stand alone, and without the filter's reach.
    """
    steps = steps_of(variant)
    x0, y0, x1, y1 = steps[0][0].config.region_px or (0, 0, *SIZE_PX)
    room_bytes = ROOM_BYTES if keeps_points else NO_ROOM_FOR_POINTS_BYTES_PER_PX * (x1 - x0) * (y1 - y0)
    session = Session(kept_surfaces_bytes=room_bytes, kept_maps_bytes=ROOM_BYTES)
    kept = 0
    for state, alone in steps:
        film = state.picture(session)
        assert_same(film, alone)
        kept += counts(film).get("light on points kept", 0)
    assert (kept > 0) == keeps_points


def test_what_a_moved_object_cannot_touch_stays() -> None:
    """A cube at the left edge concerns the blocks there, and the points that it takes a part of the sky from."""
    rng = np.random.default_rng(5)
    state = start(rng, cubes=(translation(-2.2, 1.0, 0.3) @ turned(rng, 0.2), translation(2.0, 1.0, 0.2)))
    session = Session(kept_surfaces_bytes=ROOM_BYTES)
    state.picture(session)
    after = replace(state, cubes=(translation(0.05, 0.0, 0.0) @ state.cubes[0], state.cubes[1]))
    found = counts(after.picture(session))
    blocks = found["blocks of pixels kept"] + found["blocks of pixels walked"]
    assert blocks == 2 * 3 * SIZE_PX[1] // 4  # two samples
    assert 0 < found["blocks of pixels walked"] <= blocks // 3
    assert found["light on points kept"] > 3 * found["light on points asked"] > 0


def test_what_moved_and_came_back_is_kept_whole() -> None:
    """Nothing is asked, though other pictures of the same size were never shown."""
    rng = np.random.default_rng(11)
    state = start(rng)
    session = Session(kept_surfaces_bytes=ROOM_BYTES)
    state.picture(session)
    session.update(moved(rng, state).description(), Progress())
    session.render(replace(state.camera, size_px=(32, 16)), state.config, Progress())
    film = state.picture(session)
    assert counts(film) == {}
    assert film.statistics["counts"]["surfaces: passes walked"] == 0


def test_a_moved_medium_is_rendered_anew() -> None:
    """Its walls are no surfaces, and still change every ray that passes them."""
    state = start(np.random.default_rng(7))
    session = Session(kept_surfaces_bytes=ROOM_BYTES)
    state.picture(session)
    after = replace(state, fog=translation(1.0, 0.0, 0.0) @ state.fog)
    film = after.picture(session)
    assert film.statistics["counts"]["surfaces: passes kept"] == 0
    assert_same(film, after.picture(Session()))


def test_where_a_material_asks_for_others_all_is_rendered_anew() -> None:
    """Its rays may meet what moved wherever it is seen: here, above the picture.

    Seen to fail where the materials are not asked.
    """
    reach = SurfaceOp(code=Code.CONSTANT, out=0, value=(6.0,) * 3)
    normal = SurfaceOp(code=Code.INPUT, option=PointInput.NORMAL, out=1)
    rays = SurfaceOp(code=Code.AMBIENT_OCCLUSION, selector=16, out=2, a=0, b=1)
    rng = np.random.default_rng(9)
    state = start(
        rng,
        cubes=(translation(0.0, 9.0, 3.6) @ turned(rng, 0.7),),
        floor=Material(name="floor", program=(reach, normal, rays), diffuse_register=2, transparent_register=3),
    )
    session = Session(kept_surfaces_bytes=ROOM_BYTES)
    state.picture(session)
    after = replace(state, cubes=(translation(1.0, 0.2, 0.0) @ state.cubes[0],))
    film = after.picture(session)
    assert film.statistics["counts"]["surfaces: passes kept"] == 0
    assert_same(film, after.picture(Session()))


def test_a_drag_that_outruns_its_pictures_leaves_nothing_wrong() -> None:
    """Blocks of several places are mixed in what is kept: on_update comes after the first band.

    Seen to fail where only the place of the last complete picture counts.
    """
    rng = np.random.default_rng(8)
    size_px = (160, 96)  # several bands
    state = start(rng, camera=replace(view(), window=(-0.8, 0.8, -0.48, 0.48), size_px=size_px))
    session = Session(kept_surfaces_bytes=ROOM_BYTES)
    turn = turned(rng, 0.2)

    def dragged(x_m: float) -> State:
        return replace(state, cubes=(translation(x_m, 0.5, 0.2) @ turn, *state.cubes[1:]))

    dragged(-2.0).picture(session)
    for complete in (-0.8, 0.4, 1.6):
        for seen_in_part in (complete - 0.8, complete - 0.4):
            progress = Progress()
            session.update(dragged(seen_in_part).description(), Progress())
            with pytest.raises(Cancelled):
                session.render(state.camera, state.config, progress, lambda _film, it=progress: it.cancel())
        assert_same(dragged(complete).picture(session), dragged(complete).picture(Session()))
