# SPDX-License-Identifier: GPL-3.0-or-later
"""What is not a view ray: beside a fisheye's circle nothing is coloured, painted or asked, and nothing else changes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from support.plain_scenes import camera_above, placed, square, sun, translation, unit_cube
from tyndall import InvalidInput, Progress
from tyndall.light_map_fit import LightMapFit, LightMapFitConfig, StrokeView
from tyndall.native_camera import raster_position, ray_through
from tyndall.renderer import Film, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    Camera,
    CameraKind,
    EditKind,
    Light,
    Material,
    Medium,
    OccluderEdit,
    Panorama,
    PanoramaKind,
    ScatterLobe,
    SceneDescription,
    World,
)
from tyndall.transfer_functions import Layer, TransferFunction, WeightedFunction

SIDE_PX = 48
HALF_RAD = 1.0


def fisheye(size_px: int = SIDE_PX) -> Camera:
    """Looks down from 5 m; its circle touches the frame's sides."""
    return replace(
        camera_above(size_px=(size_px, size_px)),
        kind=CameraKind.PANORAMIC,
        window=(-HALF_RAD, HALF_RAD, -HALF_RAD, HALF_RAD),
        panorama=Panorama(kind=PanoramaKind.FISHEYE_EQUIDISTANT, rim=HALF_RAD),
    )


def is_beside(size_px: int = SIDE_PX) -> np.ndarray:
    places = (np.arange(size_px) + 0.5) / size_px * 2 - 1
    return np.hypot(places[:, None], places[None, :]) > 1.0


def foggy(*lights: Light) -> SceneDescription:
    """Two metres of fog without sides on a wide floor, and a plate above."""
    wide = np.diag([60.0, 60.0, 2.0, 1.0])
    return SceneDescription(
        instances=(
            placed(square(), wide),
            placed(square("plate"), translation(1.0, 0.0, 3.0)),
            placed(unit_cube(), wide, materials=(1,)),
        ),
        materials=(Material(name="grey"), Material(name="fog", has_surface=False, medium=0)),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.05,) * 3),)),),
        lights=lights or (sun(),),
        world=World(radiance=(0.3, 0.3, 0.3)),
    )


def rendered(description: SceneDescription, camera: Camera, config: RenderConfig) -> Film:
    session = Session()
    session.update(description, Progress())
    return session.render(camera, config, Progress())


@pytest.mark.parametrize("method", ["EXACT", "EPIPOLAR", "SHADOW_MAP"])
def test_functions_colour_what_is_seen_alone(method: str) -> None:
    red = Layer(name="red", colour=(1.0, 0.0, 0.0, 1.0))
    function = WeightedFunction(function=TransferFunction(name="f", layers=(red,)))
    config = RenderConfig(
        pixel_samples=1,
        passes=frozenset({"Shafts", "Depth"}),
        shafts=ShaftConfig(method=method, resolution=512),
        transfer_functions=(function,),
    )
    planes = rendered(foggy(), fisheye(), config).planes
    assert (planes["Combined"][is_beside()] == (0.0, 0.0, 0.0, 1.0)).all()
    assert (planes["Shafts"][is_beside()] == 0.0).all()
    assert (planes["Depth"][is_beside()] == 1e10).all()
    red_of_shafts = planes["Shafts"][~is_beside()]
    assert (red_of_shafts[:, 0] > 0.0).all()
    assert (red_of_shafts[:, 1] < 0.5 * red_of_shafts[:, 0]).all()


def test_strokes_beside_the_circle_are_none() -> None:
    """The fitted map is that of the same strokes without them, bit for bit."""
    maps = []
    for is_clean in (False, True):
        texels = np.zeros((SIDE_PX, SIDE_PX, 4), dtype=np.float32)
        texels[:, : SIDE_PX // 2] = (1.0, 0.1, 0.1, 1.0)
        if is_clean:
            texels[is_beside()] = 0.0
        session = Session()
        session.update(foggy(), Progress())
        config = LightMapFitConfig(resolution=32, shafts=ShaftConfig(method="EXACT"))
        view = StrokeView(name="Strokes", camera=fisheye(), texels=texels)
        fit = LightMapFit(session, sun().name, [view], Progress(), config=config)
        fit.iterate(5, Progress())
        maps.append(fit.light_map.texels)
    np.testing.assert_array_equal(maps[0], maps[1])


def test_edits_shadow_surfaces_up_to_the_rim() -> None:
    """A hole that an edit closes is closed on the floor, too, wherever a fisheye sees that."""
    edit = OccluderEdit(name="fill", kind=EditKind.CLOSE, size_m=0.5, affects_surfaces=True)
    lights = [replace(sun(), occluder_edits=edits) for edits in ((), (edit,))]
    # Slats with gaps of 20 cm over half of the floor: closed there, and open beside them.
    slats = [translation(-31.1 + 1.0 * k, 0.0, 3.0) @ np.diag([0.4, 60.0, 1.0, 1.0]) for k in range(31)]
    config = RenderConfig(pixel_samples=4, shafts=ShaftConfig(method="SHADOW_MAP", resolution=2048))
    gaps = []
    for light in lights:
        description = SceneDescription(
            instances=(
                placed(square(), np.diag([60.0, 60.0, 1.0, 1.0])),
                replace(placed(square("slat"), *slats), is_camera_visible=False),
            ),
            materials=(Material(name="grey"),),
            lights=(light,),
        )
        gaps.append(rendered(description, fisheye(), config).planes["Combined"][..., 0])
    seen = ~is_beside(SIDE_PX)
    left, right = seen.copy(), seen.copy()
    left[:, SIDE_PX // 2 - 8 :] = False
    right[:, : SIDE_PX // 2 + 3] = False
    assert gaps[0][left].mean() > 0.01
    assert gaps[1][left].mean() < 0.02 * gaps[0][left].mean()  # what leaks is as rare as in perspective
    np.testing.assert_allclose(gaps[1][right], gaps[0][right])


# Seen to fail, with 3 rays in place of 5, where the pilot takes what lies beside for black.
def test_shadow_rays_are_counted_by_what_is_seen() -> None:
    """A frame that is mostly beside the circle asks its lamps as often as one that the circle fills."""
    whole = replace(fisheye(), window=(-0.7, 0.7, -0.7, 0.7))
    small = replace(fisheye(192), window=(-4.0, 4.0, -4.0, 4.0))
    config = RenderConfig(pixel_samples=4, shafts=ShaftConfig(method="EXACT", light_samples=16))
    description = replace(foggy(replace(sun(), half_angle_rad=0.1)), media=(), materials=(Material(name="grey"),) * 2)
    counts = [
        rendered(description, camera, config).statistics["counts"]["direct light: shadow rays per surface point"]
        for camera in (whole, small)
    ]
    assert counts[1] == pytest.approx(counts[0], rel=0.2)


def test_rays_of_a_place_and_places_of_a_point() -> None:
    camera = fisheye()
    far = replace(camera, world_from_camera=translation(1e6, -2e6, 5.0))
    for seen in (camera, far):
        ray = ray_through(seen, (30.0, 11.0))
        assert ray is not None
        origin, direction = (np.array(part) for part in ray)
        assert np.linalg.norm(origin - seen.world_from_camera[:3, 3]) == pytest.approx(0.1, abs=1e-6)
        assert math.acos(-direction[2]) == pytest.approx(np.hypot(30.0 - 24, 11.0 - 24) / 24 * HALF_RAD, abs=1e-5)
        assert raster_position(seen, origin + 3.0 * direction) == pytest.approx((30.0, 11.0), abs=1e-3)
        assert ray_through(seen, (1.0, 2.0)) is None
        assert raster_position(seen, origin + np.array((0.0, 0.0, 9.0))) is not None


def test_a_lens_that_is_no_number_is_named() -> None:
    for broken in (
        Panorama(kind=PanoramaKind.FISHEYE_EQUISOLID, rim=math.nan),
        Panorama(kind=PanoramaKind.FISHEYE_POLYNOMIAL, angle_by_radius=(0.0, math.inf, 0.0, 0.0, 0.0)),
    ):
        with pytest.raises(InvalidInput, match="fisheye's field of view or polynomial"):
            rendered(foggy(), replace(fisheye(), panorama=broken), RenderConfig(pixel_samples=1))
