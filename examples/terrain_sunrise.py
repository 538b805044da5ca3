# SPDX-License-Identifier: GPL-3.0-or-later
"""Sunrise over a mountain valley: the sun climbs behind the peaks, and five keyed transfer functions colour its shafts.

After figure 5.11 of Kol, dissertation, TU Delft 2018. Needs the add-on: run as
``scripts/blender -b --python examples/terrain_sunrise.py``; writes terrain_sunrise.blend beside itself.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from scene_kit import Rgb, camera, clear_file, diffuse, finish, fog_box, link, sun, towards, world

SIZE_M, VERTICES = 2400.0, 420
LAST_FRAME = 100
EYE = (-40.0, -620.0, 60.0)
#: Of the sun, over time: how far to the right of straight ahead, and how high, in degrees.
SUN_FROM, SUN_TO = (-8.0, 9.0), (3.0, 17.0)


def octaves(random: np.random.Generator, slope: float) -> np.ndarray:
    """Noise of all wavelengths, (VERTICES, VERTICES), standard deviation 1: amplitude falls as frequency ** -slope."""
    frequency = np.fft.fftfreq(VERTICES) * VERTICES
    radius = np.hypot(*np.meshgrid(frequency, frequency))
    radius[0, 0] = np.inf
    spectrum = np.fft.fft2(random.normal(size=(VERTICES, VERTICES))) * radius**-slope
    heights = np.fft.ifft2(spectrum).real
    return np.asarray(heights / heights.std())


def terrain(material: bpy.types.Material) -> bpy.types.Object:
    """A valley that leads away from the camera, between ridges, and a row of peaks across its end."""
    random = np.random.default_rng(11)
    ridges, detail = octaves(random, 1.9), octaves(random, 1.5)
    axis = np.linspace(-SIZE_M / 2, SIZE_M / 2, VERTICES)
    x, y = np.meshgrid(axis, axis)
    aside = np.clip((np.abs(x + 50.0 * np.sin(y / 260.0)) - 90.0) / 420.0, 0.0, 1.0)
    teeth = 0.45 + 0.35 * np.cos(x / 33.0 + 2.0 * np.sin(x / 120.0)) + 0.2 * np.cos(x / 13.0 + y / 90.0)
    peaks = np.exp(-(((y - 420.0) / 150.0) ** 2)) * teeth
    heights = 300.0 * aside**1.3 * (1.15 - np.abs(ridges)) + 400.0 * peaks * (1.1 - 0.5 * np.abs(ridges)) + 6.0 * detail
    points = np.stack((x, y, heights), axis=-1).reshape(-1, 3)
    corner = (np.arange(VERTICES - 1)[:, None] * VERTICES + np.arange(VERTICES - 1)).reshape(-1)
    faces = np.stack((corner, corner + 1, corner + VERTICES + 1, corner + VERTICES), axis=1)
    mesh = bpy.data.meshes.new("Terrain")
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.append(material)
    mesh.update()
    return link("Terrain", mesh)


def let_rise(star: bpy.types.Object) -> None:
    """Key the sun's way."""
    star.rotation_mode = "QUATERNION"
    for frame, place in ((1, SUN_FROM), (LAST_FRAME, SUN_TO)):
        rotation = towards(*place).to_track_quat("Z", "Y")
        rotation.make_compatible(star.rotation_quaternion)
        star.rotation_quaternion = rotation
        star.keyframe_insert("rotation_quaternion", frame=frame)


def colour_over_time() -> None:
    """Key five functions, each a ramp over visibility, multiplied by one over depth."""
    scene = bpy.context.scene
    shafts = scene.tyndall.shafts
    for frame, name, lit, far in SUNRISE:
        scene.frame_set(frame)
        if not shafts.transfer_states:
            bpy.ops.tyndall.transfer_function_new()
            for kind, mode in (("GRADIENT", "MIX"), ("GRADIENT", "MULTIPLY")):
                bpy.ops.tyndall.transfer_layer_add(kind=kind)
                function(shafts).layers[-1].blend_mode = mode
        bpy.ops.tyndall.transfer_state_key()
        tree = shafts.transfer_states[shafts.active_transfer_state].function
        tree.name = name
        settings = tree.tyndall
        settings.use = "TINT"
        light, distance = settings.layers
        distance.start, distance.end = (0.5, 0.0), (0.5, 1.0)
        for layer, colours in ((light, lit), (distance, far)):
            ramp = tree.nodes[layer.ramp_node].color_ramp
            while len(ramp.elements) < len(colours):
                ramp.elements.new(1.0)
            for index, colour in enumerate(colours):
                ramp.elements[index].position = index / (len(colours) - 1)
                ramp.elements[index].color = (*colour, 1.0)
    scene.frame_set(1)


def function(shafts: bpy.types.PropertyGroup) -> bpy.types.PropertyGroup:
    """The settings of the function that is shown."""
    return shafts.transfer_states[shafts.active_transfer_state].function.tyndall


#: Frame, name, colours from shade to light, and what multiplies them from near to far.
SUNRISE: tuple[tuple[int, str, tuple[Rgb, ...], tuple[Rgb, ...]], ...] = (
    (1, "Night", ((0.10, 0.16, 0.50), (0.22, 0.34, 0.85), (0.5, 0.65, 1.2)), ((0.7, 0.7, 1.0), (0.5, 0.5, 0.9))),
    (25, "First Light", ((0.25, 0.20, 0.60), (0.75, 0.40, 0.80), (1.4, 0.75, 0.8)), ((0.9, 0.9, 1.0), (0.9, 0.6, 0.8))),
    (50, "Red Dawn", ((0.45, 0.20, 0.45), (1.4, 0.42, 0.22), (1.9, 0.85, 0.30)), ((1.0, 0.9, 0.9), (1.2, 0.8, 0.7))),
    (75, "Gold", ((0.55, 0.42, 0.50), (1.5, 0.85, 0.35), (1.7, 1.25, 0.55)), ((1.0, 1.0, 1.0), (1.2, 1.0, 0.8))),
    (100, "Morning", ((0.45, 0.60, 0.90), (1.0, 0.95, 0.85), (1.3, 1.1, 0.8)), ((1.0, 1.0, 1.0), (0.8, 0.95, 1.2))),
)


def build() -> None:
    """Put the scene together."""
    if not hasattr(bpy.types.Scene, "tyndall"):
        raise SystemExit("terrain_sunrise: the add-on is not enabled: run it through scripts/blender")
    clear_file()
    terrain(diffuse("Rock", (0.16, 0.15, 0.14)))
    let_rise(sun("Sun", tuple(towards(*SUN_FROM)), 11.0, (1.0, 0.93, 0.84), 0.5))
    world((0.35, 0.45, 0.75), 0.12)
    half = SIZE_M / 2 - 1.0
    fog_box((-half, -half, -150.0), (half, half, 520.0), 0.00055, (1.0, 1.0, 1.0), 0.4)
    made = camera(EYE, (10.0, 500.0, 210.0), 34.0)
    made.data.clip_end = 20000.0
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, LAST_FRAME
    colour_over_time()
    finish(__file__, view="Filmic", look="High Contrast", exposure=0.0)


build()
