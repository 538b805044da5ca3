# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies that scatter light below their surfaces, each before a camera of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from mathutils import Vector

from .closure_scenes import IS_OLD, ball, shader
from .small_scenes import cube, empty_scene, material, plane

if TYPE_CHECKING:
    from collections.abc import Callable

    from .small_scenes import Build

    LightIt = Callable[[bpy.types.Scene], object]

SKIN, RADIUS = (0.8, 0.55, 0.4, 1.0), (1.0, 0.5, 0.3)
#: Of the node's methods, one for each way of light, by the running version's names.
METHODS = ("BURLEY", "RANDOM_WALK_FIXED_RADIUS" if IS_OLD else "RANDOM_WALK_SKIN", "RANDOM_WALK")


def scattering(method: str = "RANDOM_WALK", **inputs: object) -> Build:
    values = {"Color": SKIN, "Scale": 1.0, "Radius": RADIUS, **inputs}
    if IS_OLD:
        values.pop("Roughness", None)
    return shader("ShaderNodeSubsurfaceScattering", node_falloff=method, **values)


def principled(method: str = "RANDOM_WALK", share: float = 1.0, **inputs: object) -> Build:
    names = {"Specular_IOR_Level": "Specular", "Coat_Weight": "Clearcoat", "Sheen_Weight": "Sheen"} if IS_OLD else {}
    values = {"Base_Color": SKIN, "Subsurface_Radius": RADIUS, **inputs}
    values = {names.get(name, name): value for name, value in values.items()}
    if IS_OLD:
        values |= {"Subsurface": share, "Subsurface_Color": (0.3, 0.8, 0.4, 1.0)}
    else:
        values |= {"Subsurface_Weight": share, "Subsurface_Scale": 1.0}
    return shader("ShaderNodeBsdfPrincipled", node_distribution="GGX", node_subsurface_method=method, **values)


def _look_from(place: tuple[float, float, float]) -> None:
    camera = bpy.context.scene.camera
    camera.location = place
    camera.rotation_euler = (-Vector(place)).to_track_quat("-Z", "Y").to_euler()


def _scene(width_m: float, size_px: int) -> bpy.types.Scene:
    scene = empty_scene(size_px)
    scene.camera.data.ortho_scale = width_m
    return scene


def sphere(build: Build, light_it: LightIt, size_px: int = 32, *, is_smooth: bool = True) -> bpy.types.Scene:
    scene = _scene(2.1, size_px)
    ball(material("Shown", build), is_smooth=is_smooth)
    light_it(scene)
    return scene


def block(
    build: Build, light_it: LightIt, scale: tuple[float, float, float] = (1.0, 1.0, 1.0), size_px: int = 32
) -> bpy.types.Scene:
    scene = _scene(3.2, size_px)
    cube("Shown", material("Shown", build)).scale = scale
    _look_from((2.0, -2.6, 2.2))
    light_it(scene)
    return scene


def sheet(build: Build, light_it: LightIt, size_px: int = 32) -> bpy.types.Scene:
    """Open: light that gets below never finds another side."""
    scene = _scene(2.1, size_px)
    plane(0.0, material("Shown", build), half_side=1.3)
    light_it(scene)
    return scene
