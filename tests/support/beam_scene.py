# SPDX-License-Identifier: GPL-3.0-or-later
"""A small scene with everything that a shaft needs: a wall with slots, a lamp behind it, a floor, haze, a camera."""

from __future__ import annotations

import math

import bpy

SLOT_COUNT = 4


def build_beam_scene() -> bpy.types.Scene:
    """Replace the factory scene's cube and lamp. Needs the add-on: its operator makes the haze."""
    scene = bpy.context.scene
    for name in ("Cube", "Light"):
        bpy.data.objects.remove(bpy.data.objects[name])
    bpy.ops.mesh.primitive_plane_add(size=12)
    for index in range(SLOT_COUNT + 1):
        bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 1.2 * (index - SLOT_COUNT / 2), 1.5))
        bpy.context.object.scale = (0.1, 0.8, 3.0)
    lamp = bpy.data.lights.new("Lamp", "SPOT")
    lamp.energy, lamp.spot_size, lamp.shadow_soft_size, lamp.spot_blend = 8000.0, math.radians(60), 0.0, 0.0
    spot = bpy.data.objects.new("Lamp", lamp)
    spot.location, spot.rotation_euler = (-4.0, 0.0, 2.0), (0.0, math.radians(-80), 0.0)
    scene.collection.objects.link(spot)
    scene.camera.location, scene.camera.rotation_euler = (6.5, -5.5, 2.2), (math.radians(82), 0.0, math.radians(50))
    scene.camera.data.lens = 28
    bpy.ops.tyndall.add_fog_box(optical_depth=1.0)
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y = 320, 180
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Raw"
    scene.tyndall.pixel_samples = 4
    scene.tyndall.viewport_samples = 1
    scene.tyndall.shafts.world_samples = 0
    return scene
