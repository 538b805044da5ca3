# SPDX-License-Identifier: GPL-3.0-or-later
"""Panoramic lenses of absurd settings, and what else bends a camera's rays at its front."""

from __future__ import annotations

from math import inf, nan, pi
from typing import Any

import bpy

from support.damages import Random, Scene, damage

HUGE = (0.0, -1.0, 1e9, -1e30, 1e30, 3e38)


def panoramic(scene: Scene, kind: str) -> Any:
    """Its settings; of a kind that this Blender lacks, all directions."""
    camera = scene.camera.data
    camera.type = "PANO"
    owner = camera if hasattr(camera, "panorama_type") else camera.cycles
    known = {it.identifier for it in owner.bl_rna.properties["panorama_type"].enum_items}
    owner.panorama_type = kind if kind in known else "EQUIRECTANGULAR"
    return owner


def _polynomial(scene: Scene, random: Random, values: tuple[float, ...]) -> None:
    lens = panoramic(scene, "FISHEYE_LENS_POLYNOMIAL")
    for power in range(5):
        setattr(lens, f"fisheye_polynomial_k{power}", float(random.choice(values)))


@damage("a lens polynomial that is not a number", "Camera", "camera")
def _(scene: Scene, random: Random) -> None:
    _polynomial(scene, random, (nan, inf, -0.04))
    bad = nan if random.integers(2) else inf
    setattr(panoramic(scene, "FISHEYE_LENS_POLYNOMIAL"), f"fisheye_polynomial_k{random.integers(5)}", bad)


@damage("a lens polynomial beyond measure", None, "camera")
def _(scene: Scene, random: Random) -> None:
    _polynomial(scene, random, (*HUGE, -0.04))


@damage("a lens polynomial that shows one direction, or turns back", None, "camera")
def _(scene: Scene, random: Random) -> None:
    lens = panoramic(scene, "FISHEYE_LENS_POLYNOMIAL")
    ways = ((0.0, 0.0, 0.0, 0.0, 0.0), (-1.0, 0.0, 0.0, 0.0, 0.0), (0.5, -0.1, 0.02, -0.001, 1e-5))
    for power, value in enumerate(ways[int(random.integers(3))]):
        setattr(lens, f"fisheye_polynomial_k{power}", value)
    scene.camera.data.sensor_width = float(random.choice([1.0, 36.0, 1e9]))


@damage("a fisheye of next to no field, or of more than all directions", None, "camera")
def _(scene: Scene, random: Random) -> None:
    kinds = ("FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID", "FISHEYE_LENS_POLYNOMIAL")
    lens = panoramic(scene, kinds[int(random.integers(3))])
    lens.fisheye_fov = float(random.choice([0.0, -1.0, 2 * pi, 7.0, 4 * pi, 1e30]))
    lens.fisheye_lens = float(random.choice([0.0, -1.0, 10.5, 1e30]))


@damage("a fisheye whose field or lens is not a number", "Camera", "camera")
def _(scene: Scene, random: Random) -> None:
    lens = panoramic(scene, "FISHEYE_EQUISOLID")
    setattr(lens, str(random.choice(["fisheye_fov", "fisheye_lens"])), nan)


@damage("a sphere whose longitudes or latitudes are swapped or without end", None, "camera")
def _(scene: Scene, random: Random) -> None:
    lens = panoramic(scene, "EQUIRECTANGULAR")
    lens.longitude_min, lens.longitude_max = [(pi, -pi), (-1e6, 1e6), (10 * pi, 9 * pi)][int(random.integers(3))]
    lens.latitude_min, lens.latitude_max = [(pi / 2, -pi / 2), (-pi / 2, pi / 2)][int(random.integers(2))]


@damage("a sphere of no width, or whose edges are not numbers", "Camera", "camera")
def _(scene: Scene, random: Random) -> None:
    lens = panoramic(scene, "EQUIRECTANGULAR")
    low, high = [(1.0, 1.0), (nan, 1.0), (0.0, nan)][int(random.integers(3))]
    if random.integers(2):
        lens.longitude_min, lens.longitude_max = low, high
    else:
        lens.latitude_min, lens.latitude_max = low, high


@damage("a cylinder of no height, or whose edges are not numbers", "Camera", "camera")
def _(scene: Scene, random: Random) -> None:
    lens = panoramic(scene, "CENTRAL_CYLINDRICAL")
    low, high = [(0.5, 0.5), (nan, 1.0), (0.0, nan)][int(random.integers(3))]
    if hasattr(lens, "central_cylindrical_radius"):
        names = "central_cylindrical_range_u", "central_cylindrical_range_v"
    else:
        names = "longitude", "latitude"
    name = names[int(random.integers(2))]
    setattr(lens, f"{name}_min", low)
    setattr(lens, f"{name}_max", high)


@damage("a cylinder of no radius, of a vast one, and upside down", None, "camera")
def _(scene: Scene, random: Random) -> None:
    lens = panoramic(scene, "CENTRAL_CYLINDRICAL")
    if hasattr(lens, "central_cylindrical_radius"):
        lens.central_cylindrical_radius = float(random.choice([0.0, -1.0, 1e-5, 1e30]))
        lens.central_cylindrical_range_v_min = float(random.choice([1.0, -1.0, 1e9]))
        lens.central_cylindrical_range_u_min = float(random.choice([5.0, -pi, 1e6]))


@damage("a cylinder whose radius is not a number", "Camera", "camera")
def _(scene: Scene, _random: Random) -> None:
    lens = panoramic(scene, "CENTRAL_CYLINDRICAL")
    if hasattr(lens, "central_cylindrical_radius"):
        lens.central_cylindrical_radius = nan
    else:
        lens.longitude_min = nan


@damage("a panorama of absurd aperture and focus", None, "camera")
def _(scene: Scene, random: Random) -> None:
    camera = scene.camera.data
    owner = panoramic(scene, "EQUIRECTANGULAR")
    kinds = [it.identifier for it in owner.bl_rna.properties["panorama_type"].enum_items]
    owner.panorama_type = str(random.choice(kinds))
    field = camera.dof
    field.use_dof = True
    field.aperture_fstop = float(random.choice([0.0, 1e-30, 0.001, 1e30, inf]))
    field.focus_distance = float(random.choice([0.0, 1e-30, 1e30]))
    field.aperture_blades, field.aperture_ratio = int(random.choice([0, 3, 16])), float(random.choice([0.01, 100.0]))
    camera.shift_x = float(random.choice([0.0, 0.3, -2.0]))


@damage("an aperture that is not a number", "Camera", "camera")
def _(scene: Scene, random: Random) -> None:
    if random.integers(2):
        panoramic(scene, "FISHEYE_EQUIDISTANT")
    field = scene.camera.data.dof
    field.use_dof, field.focus_distance = True, 5.0
    setattr(field, str(random.choice(["aperture_fstop", "aperture_rotation", "aperture_ratio"])), nan)


@damage("a focus on something far beyond measure, or that is not a number", "Camera", "camera")
def _(scene: Scene, random: Random) -> None:
    if random.integers(2):
        panoramic(scene, "MIRRORBALL")
    target = bpy.data.objects.new("Target", None)
    bpy.context.scene.collection.objects.link(target)
    target.location = (0.0, float(random.choice([nan, inf, 1e30])), 0.0)
    field = scene.camera.data.dof
    field.use_dof, field.focus_object = True, target


@damage("shafts through places on an absurd lens", None, "camera")
def _(scene: Scene, random: Random) -> None:
    scene.tyndall.pixel_samples = scene.tyndall.shafts.lens_steps = 4
    camera = scene.camera.data
    field = camera.dof
    field.use_dof = True
    field.aperture_fstop = float(random.choice([0.0, 1e-3, 1e30]))
    field.focus_distance = float(random.choice([1e-30, 1e-3, 1e17]))
    field.aperture_ratio = float(random.choice([0.01, 100.0]))
    camera.shift_x, camera.lens = float(random.choice([0.0, 5.0])), float(random.choice([1.0, 1e5]))
