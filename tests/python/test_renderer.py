# SPDX-License-Identifier: GPL-3.0-or-later
"""A session renders what it was given, keeps what did not change, and leaves out what cannot be used, by name."""

from __future__ import annotations

import json
import math
import threading
from dataclasses import replace

import numpy as np
import pytest

from support.plain_scenes import camera_above, lit_square, placed, square, sun, translation, unit_cube
from tyndall import Cancelled, InvalidInput, Progress
from tyndall.renderer import PASSES, Film, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    Code,
    Image,
    Instances,
    Light,
    Material,
    Medium,
    Mesh,
    SceneDescription,
    SurfaceOp,
    TextureUse,
    World,
)

ONE_SAMPLE = RenderConfig(pixel_samples=1)


def counts(session: Session) -> dict[str, float]:
    result: dict[str, float] = session.statistics["counts"]
    return result


def rendered(description: SceneDescription, config: RenderConfig = ONE_SAMPLE) -> Film:
    session = Session()
    session.update(description, Progress())
    return session.render(camera_above(), config, Progress())


def centre(film: Film, plane: str = "Combined") -> list[float]:
    return film.planes[plane][4, 4, :3].tolist()


def test_a_sun_lights_a_diffuse_square_by_albedo_over_pi() -> None:
    assert centre(rendered(lit_square())) == pytest.approx([0.8 / math.pi] * 3, rel=1e-6)


def test_a_scene_60_km_out_gives_the_picture_of_the_same_scene_at_the_origin() -> None:
    far = translation(60_000.25, -40_000.5, 3_000)
    light = replace(sun(), world_from_light=far)
    session = Session()
    session.update(lit_square(instances=(placed(square(), far),), lights=(light,)), Progress())
    film = session.render(camera_above(far), replace(ONE_SAMPLE, passes=frozenset({"Position"})), Progress())
    assert np.array_equal(film.planes["Combined"], rendered(lit_square()).planes["Combined"])
    # Half a pixel from the middle of the frame; float32 holds 4 mm there.
    assert film.planes["Position"][4, 4].tolist() == pytest.approx(far[:3, 3] + [0.28125, 0.28125, 0], abs=5e-3)


def test_the_same_description_sends_nothing_and_builds_nothing() -> None:
    session = Session()
    session.update(lit_square(), Progress())
    assert counts(session) == {
        "meshes sent": 1,
        "meshes reused": 0,
        "images sent": 0,
        "images reused": 0,
        "grids sent": 0,
        "grids reused": 0,
        "voxels sent": 0,
        "voxels reused": 0,
        "strands sent": 0,
        "strands reused": 0,
        "scene rebuilt": 1,
        "scene relit": 0,
        "scene moved": 0,
    }
    session.update(lit_square(), Progress())
    assert counts(session)["meshes sent"] == 0
    assert counts(session)["scene rebuilt"] == 0
    film = session.render(camera_above(), ONE_SAMPLE, Progress())
    assert film.statistics["counts"]["meshes reused"] == 1


def test_a_new_light_keeps_the_meshes() -> None:
    session = Session()
    session.update(lit_square(), Progress())
    session.update(lit_square(lights=(sun(2.0),)), Progress())
    assert (counts(session)["scene rebuilt"], counts(session)["scene relit"]) == (0, 1)
    assert counts(session)["meshes sent"] == 0
    assert counts(session)["meshes reused"] == 1
    assert centre(session.render(camera_above(), ONE_SAMPLE, Progress())) == pytest.approx([1.6 / math.pi] * 3)


def test_a_new_key_sends_the_mesh_and_forgets_the_old_one() -> None:
    session = Session()
    session.update(lit_square(), Progress())
    session.update(lit_square(instances=(placed(square("edited"), np.eye(4)),)), Progress())
    assert counts(session)["meshes sent"] == 1
    session.update(lit_square(), Progress())
    assert counts(session)["meshes sent"] == 1  # it was not kept for ever


def test_an_image_is_sent_once_for_all_materials_that_use_it_alike() -> None:
    pixels = np.full((2, 2, 4), 0.5, dtype=np.float32)
    image = Image(key="grey", name="grey", pixels=pixels)
    textured = Material(
        name="textured",
        program=(SurfaceOp(code=Code.TEXTURE, out=1),),
        diffuse_register=1,
        textures=(TextureUse(image=image),),
        uv_maps=("",),
    )
    session = Session()
    session.update(lit_square(materials=(textured, replace(textured, name="other"))), Progress())
    assert counts(session)["images sent"] == 1
    assert centre(session.render(camera_above(), ONE_SAMPLE, Progress())) == pytest.approx([0.5 / math.pi] * 3)
    session.update(lit_square(materials=(textured,)), Progress())
    assert counts(session)["images sent"] == 0
    assert counts(session)["images reused"] == 1


def test_every_plane_has_its_shape_and_the_statistics_are_json() -> None:
    film = rendered(lit_square(), replace(ONE_SAMPLE, passes=frozenset(PASSES)))
    channels = dict.fromkeys(PASSES, 3) | {"Combined": 4, "Depth": 1, "Shafts Visibility": 1}
    assert {name: plane.shape for name, plane in film.planes.items()} == {
        name: (8, 8, count) for name, count in channels.items()
    }
    assert all(plane.dtype == np.float32 for plane in film.planes.values())
    assert json.loads(json.dumps(film.statistics))["skipped"][0]["reason"] == "no medium in the scene"


def test_fog_dims_the_square_and_the_light_that_reaches_it() -> None:
    # A fog box of 1.8 m thickness, so wide that its sides are far outside the view.
    placement = translation(0, 0, 1) @ np.diag([500.0, 500.0, 1.8, 1.0])
    description = lit_square(
        instances=(placed(square(), np.eye(4)), placed(unit_cube(), placement, materials=(1,))),
        materials=(Material(name="grey"), Material(name="fog", has_surface=False, medium=0)),
        media=(Medium(name="fog", sigma_a_per_m=(0.1, 0.2, 0.3)),),
    )
    film = rendered(description, replace(ONE_SAMPLE, passes=frozenset({"Transmittance"})))
    # Both on the way down and, at a slant of half a pixel, on the way up.
    slant = math.hypot(1.0, 0.05625 * math.sqrt(2))
    down, up = (np.exp(-np.array([0.1, 0.2, 0.3]) * 1.8 * length) for length in (1.0, slant))
    assert centre(film, "Transmittance") == pytest.approx(up.tolist(), rel=1e-5)
    assert centre(film) == pytest.approx((0.8 / math.pi * down * up).tolist(), rel=1e-5)


@pytest.mark.parametrize("damage", ["mesh", "transform", "light", "material", "world"])
def test_a_damaged_part_is_named_and_the_rest_still_renders(damage: str) -> None:
    good = placed(square(), np.eye(4))
    nan = float("nan")
    wrong: dict[str, tuple[SceneDescription, str]] = {
        "mesh": (lit_square(instances=(good, placed(_beyond_its_vertices(), translation(0, 0, 1)))), "broken mesh"),
        "transform": (
            lit_square(
                instances=(
                    replace(
                        good,
                        world_from_object=np.stack([np.eye(4), np.full((4, 4), nan)]),
                        object_names=("good", "lost object"),
                    ),
                )
            ),
            "lost object",
        ),
        "light": (lit_square(lights=(sun(), replace(_lamp(), strength=(nan, 1.0, 1.0)))), "lamp"),
        "material": (
            lit_square(materials=(Material(name="grey"), Material(name="no image", program=(_reads_no_image(),)))),
            "no image",
        ),
        "world": (lit_square(world=World(name="lost world", radiance=(nan, 0.0, 0.0))), "lost world"),
    }
    description, culprit = wrong[damage]
    film = rendered(description)
    assert centre(film) == pytest.approx([0.8 / math.pi] * 3, rel=1e-6)
    assert any(culprit in line for line in film.statistics["reports"])


def _beyond_its_vertices() -> Mesh:
    return replace(square("broken mesh"), triangles=np.array([[0, 1, 99]], dtype=np.uint32), uv_maps=())


def _lamp() -> Light:
    return replace(sun(), name="lamp")


def _reads_no_image() -> SurfaceOp:
    return SurfaceOp(code=Code.TEXTURE, out=0, texture=3)


def test_a_mesh_without_materials_is_drawn_grey() -> None:
    bare = Instances(mesh=square(), world_from_object=np.eye(4)[None], object_names=("bare",), materials=())
    assert centre(rendered(lit_square(instances=(bare,), materials=()))) == pytest.approx([0.8 / math.pi] * 3)


def test_an_empty_scene_is_its_world() -> None:
    film = rendered(SceneDescription(world=World(radiance=(1.0, 2.0, 3.0))))
    assert centre(film) == [1.0, 2.0, 3.0]


def test_cancel_from_another_thread_ends_a_render_and_an_update_and_the_session_goes_on() -> None:
    session = Session()
    session.update(lit_square(), Progress())
    progress = Progress()
    threading.Timer(0.2, progress.cancel).start()
    with pytest.raises(Cancelled):
        session.render(camera_above(size_px=(256, 256)), RenderConfig(pixel_samples=65536), progress)
    with pytest.raises(Cancelled):
        session.update(lit_square(instances=(placed(square("new"), np.eye(4)),)), progress)
    assert centre(session.render(camera_above(), ONE_SAMPLE, Progress())) == pytest.approx([0.8 / math.pi] * 3)


def test_updates_show_the_picture_while_it_grows() -> None:
    session = Session()
    session.update(lit_square(), Progress())
    seen: list[Film] = []
    session.render(camera_above(), RenderConfig(pixel_samples=4), Progress(), seen.append)
    assert seen
    assert seen[0].planes["Combined"].shape == (8, 8, 4)


def test_an_exception_in_an_update_reaches_the_caller() -> None:
    session = Session()
    session.update(lit_square(), Progress())

    def refuse(_film: Film) -> None:
        raise RuntimeError("the window was closed")

    with pytest.raises(RuntimeError, match="the window was closed"):
        session.render(camera_above(), RenderConfig(pixel_samples=4), Progress(), refuse)


def test_settings_out_of_range_are_named() -> None:
    session = Session()
    with pytest.raises(InvalidInput, match="no scene"):
        session.render(camera_above(), ONE_SAMPLE, Progress())
    session.update(lit_square(), Progress())
    for config, culprit in (
        (replace(ONE_SAMPLE, pixel_samples=0), "pixel_samples"),
        (replace(ONE_SAMPLE, pixel_filter="TRIANGLE"), "pixel_filter"),
        (replace(ONE_SAMPLE, filter_width_px=0.0), "filter_width_px"),
        (replace(ONE_SAMPLE, region_px=(0, 0, 9, 8)), "region"),
        (replace(ONE_SAMPLE, passes=frozenset({"Beauty"})), "Beauty"),
        (replace(ONE_SAMPLE, shafts=ShaftConfig(method="GUESS")), "shafts.method"),
    ):
        with pytest.raises(InvalidInput, match=culprit):
            session.render(camera_above(), config, Progress())
