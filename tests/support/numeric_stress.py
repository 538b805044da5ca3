# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures whose every pixel a formula knows in 64 bits, at any scale, place, depth, and size of the light.

All scenes are turned by the same odd rotation, so that nothing lies along an axis of memory. Errors are relative to the
formula, of single pixels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from support.plain_scenes import placed, square, translation, unit_cube
from tyndall import Progress
from tyndall.renderer import RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    Camera,
    CameraKind,
    Light,
    LightKind,
    Material,
    Medium,
    Mesh,
    ScatterLobe,
    SceneDescription,
    World,
)

Array = NDArray[np.float64]
GREY = 0.8
#: Camera axes in the scene's: it looks along +Y, up is Z.
_SIDEWAYS = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Error:
    """Of one picture."""

    worst: float
    rms: float


def _error(seen: Array, known: Array, where: NDArray[np.bool_] | None = None) -> Error:
    relative = np.abs(seen - known) / np.abs(known)
    chosen = relative if where is None else relative[where]
    return Error(float(chosen.max()), float(np.sqrt((chosen**2).mean())))


def _rotation(seed: int = 5) -> Array:
    axes, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    matrix = np.eye(4)
    matrix[:3, :3] = axes * np.linalg.det(axes)
    return matrix


@dataclass(frozen=True)
class Place:
    """Where a scene of size 1 is put."""

    scale_m: float = 1.0
    from_origin: float = 0.0  #: Of its middle, in its own size.
    seen_from: float = 0.0  #: How much farther away the camera stands, in its own size.
    rotation: int = 5  #: Seed of how all of it is turned.

    def turned(self) -> Array:
        """Without the scale, as cameras and lights want it."""
        way = np.array([0.6, -0.64, 0.48]) * self.from_origin * self.scale_m
        return translation(*way) @ _rotation(self.rotation)

    def matrix(self) -> Array:
        return self.turned() @ np.diag([self.scale_m, self.scale_m, self.scale_m, 1.0])

    def at(self, x: float, y: float, z: float) -> Array:
        """Turned, at a place of the scene."""
        return self.turned() @ translation(x * self.scale_m, y * self.scale_m, z * self.scale_m)


def _flat_camera(place: Place, at: Array, half_width: float, half_height: float, size_px: tuple[int, int]) -> Camera:
    s = place.scale_m
    window = (-half_width * s, half_width * s, -half_height * s, half_height * s)
    return Camera(
        kind=CameraKind.ORTHOGRAPHIC,
        world_from_camera=at @ translation(0.0, 0.0, place.seen_from * s),
        window=window,
        clip_m=(1e-3 * s, (100.0 + 2.0 * place.seen_from) * s),
        size_px=size_px,
    )


def _centres(half_width: float, half_height: float, size_px: tuple[int, int]) -> tuple[Array, Array]:
    width, height = size_px
    x = half_width * ((np.arange(width) + 0.5) / width * 2.0 - 1.0)
    y = half_height * ((np.arange(height) + 0.5) / height * 2.0 - 1.0)
    return np.meshgrid(x, y)


def _plane(scene: SceneDescription, camera: Camera, name: str, config: RenderConfig) -> Array:
    session = Session()
    session.update(scene, Progress())
    return session.render(camera, config, Progress()).planes[name][..., 0].astype(np.float64)


def _peaked_cube() -> Mesh:
    """A box that is found to be none, as its top has a corner in the middle."""
    box, middle = unit_cube(), 8
    sides = [triangle for triangle in box.triangles if box.positions[triangle, 2].min() < 1.0]
    top = [4, 5, 7, 6]
    fan = [(a, b, middle) for a, b in zip(top, top[1:] + top[:1], strict=True)]
    positions = np.concatenate([box.positions, [[0.0, 0.0, 1.0]]]).astype(np.float32)
    return Mesh(key="peaked", name="peaked", positions=positions, triangles=np.array([*sides, *fan], dtype=np.uint32))


def shaft_error(method: str, place: Place, optical_depth: float, *, is_box: bool = True) -> Error:
    """A box of fog, 2 x 2 x 1, of this depth across, under a sun straight above, with the shadow of a plate inside."""
    sigma_per_m = optical_depth / (2.0 * place.scale_m)
    plate = place.matrix() @ translation(0.0, -0.05, 0.7) @ np.diag([0.5, 0.35, 1.0, 1.0])
    scene = SceneDescription(
        instances=(
            placed(unit_cube() if is_box else _peaked_cube(), place.matrix(), materials=(1,)),
            placed(square(), plate),
        ),
        materials=(Material(name="grey"), Material(name="fog", has_surface=False, medium=0)),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(sigma_per_m,) * 3),)),),
        lights=(
            Light(name="Sun", kind=LightKind.SUN, strength=(1.0,) * 3, world_from_light=_rotation(place.rotation)),
        ),
    )
    size_px, half_width, half_height = (48, 24), 0.95, 0.475
    camera = _flat_camera(place, place.at(0.0, -3.0, 0.5) @ _SIDEWAYS, half_width, half_height, size_px)
    config = RenderConfig(pixel_samples=1, shafts=ShaftConfig(method=method), passes=frozenset({"Shafts"}))
    seen = _plane(scene, camera, "Shafts", config)
    x, z = _centres(half_width, half_height, size_px)
    z = z + 0.5
    per_size = optical_depth / 2.0

    def passed(y: float) -> float:
        return math.exp(-per_size * (y + 1.0))

    lit = np.where(
        (np.abs(x) < 0.5) & (z < 0.7), passed(-1) - passed(-0.4) + passed(0.3) - passed(1), passed(-1) - passed(1)
    )
    known = lit * np.exp(-per_size * (1.0 - z)) / (4.0 * math.pi)
    is_clear = (np.abs(np.abs(x) - 0.5) > 0.06) & (np.abs(z - 0.7) > 0.06)
    return _error(seen, known, is_clear & (known > 1e-30))


def light_along_view_error(
    method: str, place: Place, optical_depth: float, *, is_behind: bool, is_box: bool = True
) -> Error:
    """The same fog without a plate; the sun stands behind the camera, or before it: view rays run along its light."""
    turn = math.copysign(0.5 * math.pi, 1.0 if is_behind else -1.0)
    along = np.eye(4)
    along[1:3, 1:3] = [[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]
    world_from_light = _rotation(place.rotation) @ along
    scene = SceneDescription(
        instances=(placed(unit_cube() if is_box else _peaked_cube(), place.matrix()),),
        materials=(Material(name="fog", has_surface=False, medium=0),),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.5 * optical_depth / place.scale_m,) * 3),)),),
        lights=(Light(name="Sun", kind=LightKind.SUN, strength=(1.0,) * 3, world_from_light=world_from_light),),
    )
    camera = _flat_camera(place, place.at(0.0, -3.0, 0.5) @ _SIDEWAYS, 0.9, 0.45, (24, 12))
    config = RenderConfig(pixel_samples=1, shafts=ShaftConfig(method=method), passes=frozenset({"Shafts"}))
    seen = _plane(scene, camera, "Shafts", config)
    there_and_back = -0.5 * math.expm1(-2.0 * optical_depth)
    known = there_and_back if is_behind else optical_depth * math.exp(-optical_depth)
    return _error(seen, np.full_like(seen, known / (4.0 * math.pi)))


def lamp_in_fog_error(place: Place, nearest: float) -> Error:
    """A view ray of length 10 through fog without end, past a lamp in its middle, so near to it; sizes of the scene."""
    sigma, s = 0.2, place.scale_m
    scene = SceneDescription(
        instances=(placed(square(), place.matrix() @ translation(0, 0, -5) @ np.diag([9.0, 9.0, 1.0, 1.0])),),
        materials=(Material(name="grey"),),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(sigma / s,) * 3),)),),
        lights=(
            Light(name="Lamp", kind=LightKind.POINT, strength=(s * s,) * 3, world_from_light=place.at(nearest, 0, 0)),
        ),
        world=World(medium=0),
    )
    camera = _flat_camera(place, place.at(0.0, 0.0, 5.0), 0.01 * nearest, 0.01 * nearest, (1, 1))
    config = RenderConfig(
        pixel_samples=1, shafts=ShaftConfig(method="EXACT"), passes=frozenset({"Shafts"}), adapts_shadow_rays=False
    )
    seen = _plane(scene, camera, "Shafts", config)
    # By the angle at the lamp the distance's square goes away.
    count, end = 200_000, math.atan(5.0 / nearest)
    angle = end * ((np.arange(count) + 0.5) / count * 2.0 - 1.0)
    depth = sigma * (5.0 + nearest * np.tan(angle) + nearest / np.cos(angle))
    known = sigma / (4.0 * math.pi) * float(np.exp(-depth).mean()) * 2.0 * end / nearest
    return _error(seen, np.full_like(seen, known))


def _lit_plane(place: Place, light: Light, half_width: float, samples: int, size_px: int) -> Array:
    """Irradiance on a plane at the scene's middle, seen from 1 above, without the light itself."""
    scene = SceneDescription(
        instances=(placed(square(), place.matrix()),), materials=(Material(name="grey"),), lights=(light,)
    )
    camera = _flat_camera(place, place.at(0.0, 0.0, 0.5), half_width, half_width, (size_px, size_px))
    config = RenderConfig(pixel_samples=samples, pixel_filter="BOX", filter_width_px=0.01)
    return _plane(scene, camera, "Combined", config) * (math.pi / GREY)


def grazing_sun_error(place: Place, elevation_deg: float) -> Error:
    """A plane under a low sun: what is wrongly in its own shadow has an error of 1."""
    tilt = math.radians(90.0 - elevation_deg)
    turn = np.eye(4)
    turn[1:3, 1:3] = [[math.cos(tilt), -math.sin(tilt)], [math.sin(tilt), math.cos(tilt)]]
    light = Light(name="Sun", kind=LightKind.SUN, strength=(1.0,) * 3, world_from_light=_rotation() @ turn)
    seen = _lit_plane(place, light, 0.9, 1, 64)
    return _error(seen, np.full_like(seen, math.sin(math.radians(elevation_deg))))


def _lamp_error(place: Place, light: Light, known: float) -> Error:
    """Of the mean of 16 x 16 pixels of 1,024 samples, far smaller than anything else."""
    mean = _lit_plane(place, light, 1e-4, 1024, 16).mean(keepdims=True)
    return _error(mean, np.full_like(mean, known))


def sphere_lamp_error(place: Place, radius: float) -> Error:
    """A sphere 1 above a plane gives what a point of the same intensity gives, however large it is, below 1."""
    light = Light(
        name="Lamp",
        kind=LightKind.POINT,
        strength=(place.scale_m**2,) * 3,
        radius_m=radius * place.scale_m,
        world_from_light=place.at(0.0, 0.0, 1.0),
    )
    return _lamp_error(place, light, 1.0)


def area_lamp_error(place: Place, width: float) -> Error:
    """A square 1 above a plane, parallel to it: the form factor of four rectangles that meet over the point."""
    light = Light(
        name="Lamp",
        kind=LightKind.AREA,
        strength=(place.scale_m**2,) * 3,
        size_m=(width * place.scale_m, width * place.scale_m),
        world_from_light=place.at(0.0, 0.0, 1.0),
    )
    half = width / 2.0
    root = math.sqrt(1.0 + half * half)
    return _lamp_error(place, light, 4.0 * (half / root) * math.atan(half / root) / width**2)


def wide_sun_error(place: Place, half_angle_rad: float) -> Error:
    """Of a sun straight above: a plane that faces it gets its strength, however wide it is."""
    light = Light(
        name="Sun",
        kind=LightKind.SUN,
        strength=(1.0,) * 3,
        half_angle_rad=half_angle_rad,
        world_from_light=_rotation(),
    )
    return _lamp_error(place, light, 1.0)
