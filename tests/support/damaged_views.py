# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras, frames and settings that are broken."""

from __future__ import annotations

from math import inf, nan

import bpy

from support.damages import Random, Scene, damage


# --- camera and frame ------------------------------------------------------------------------------------------------
@damage("a camera that is not a number", "Camera", "camera")
def _(scene: Scene, random: Random) -> None:
    scene.camera.location[int(random.integers(3))] = float(random.choice([nan, inf]))


@damage("a camera without a scale", "Camera", "camera")
def _(scene: Scene, _random: Random) -> None:
    scene.camera.scale = (0, 0, 0)


@damage("clipping the wrong way round", None, "camera")
def _(scene: Scene, random: Random) -> None:
    camera = scene.camera.data
    camera.clip_start, camera.clip_end = [(100.0, 1.0), (5.0, 5.0), (1e-6, 1e30)][int(random.integers(3))]


@damage("a lens of absurd length", None, "camera")
def _(scene: Scene, random: Random) -> None:
    scene.camera.data.lens = float(random.choice([1.0, 1e5, 1e9]))


@damage("an orthographic camera of no or endless width", None, "camera")
def _(scene: Scene, random: Random) -> None:
    scene.camera.data.type = "ORTHO"
    scene.camera.data.ortho_scale = float(random.choice([0.0, 1e-7, 1e30]))


@damage("a camera that is no camera", None, "camera")
def _(scene: Scene, _random: Random) -> None:
    scene.camera = bpy.data.objects["Floor"]


@damage("a border around nothing", None, "frame")
def _(scene: Scene, random: Random) -> None:
    settings = scene.render
    settings.use_border, settings.use_crop_to_border = True, bool(random.integers(2))
    settings.border_min_x = settings.border_max_x = 0.5
    settings.border_min_y, settings.border_max_y = [(0.9, 0.1), (0.5, 0.5), (0.0, 1.0)][int(random.integers(3))]


@damage("the smallest frame", None, "frame")
def _(scene: Scene, random: Random) -> None:
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.resolution_percentage = int(random.choice([1, 100]))


@damage("pixels of another shape", None, "frame")
def _(scene: Scene, random: Random) -> None:
    scene.render.pixel_aspect_x = float(random.choice([1.0, 200.0]))
    scene.render.pixel_aspect_y = float(random.choice([2.0, 200.0]))


# --- settings --------------------------------------------------------------------------------------------------------
@damage("settings at their limits", None, "settings")
def _(scene: Scene, random: Random) -> None:
    ours = scene.tyndall
    ours.seed = 2**31 - 1
    ours.filter_width_px = float(random.choice([0.0, 1e9]))
    ours.thread_count = int(random.choice([1, 100000]))
    ours.shafts.error_target = float(random.choice([0.0, 1.0]))
    ours.shafts.resolution = int(random.choice([1, 16, 10**6]))
    ours.shafts.light_samples, ours.shafts.world_samples = 1, 0


@damage("a scale of units that means nothing here", None, "settings")
def _(scene: Scene, random: Random) -> None:
    scene.unit_settings.scale_length = float(random.choice([1e-9, 1e4]))


@damage("a frame far beyond the last", None, "settings")
def _(scene: Scene, _random: Random) -> None:
    scene.frame_set(1_000_000)
