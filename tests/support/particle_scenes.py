# SPDX-License-Identifier: GPL-3.0-or-later
"""Particles that show copies of a small plate, which glows by what Particle Info tells."""

from __future__ import annotations

import bpy

from .patch_nodes import Link, New, Socket
from .small_scenes import Build, add, empty_scene, material, mesh

FRAME = 8
OFFSET = 8.0  #: What is shown is the node's output plus this, as light is not negative.
OUTPUTS = ("Index", "Random", "Age", "Lifetime", "Location", "Size", "Velocity", "Angular Velocity")
SQUARE = [(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)]


def telling(output: str) -> Build:
    def build(new: New, link: Link) -> Socket:
        moved, emission = new("ShaderNodeVectorMath"), new("ShaderNodeEmission")
        moved.inputs[1].default_value = (OFFSET, OFFSET, OFFSET)
        link(new("ShaderNodeParticleInfo").outputs[output], moved.inputs[0])
        link(moved.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    return build


def emitter(name: str, kind: str, count: int, x: float) -> bpy.types.ParticleSettings:
    """A hidden strip of 2.4 by 5 m in the plane of the picture."""
    corners = [(-1.2, -2.5, 0), (1.2, -2.5, 0), (1.2, 2.5, 0), (-1.2, 2.5, 0)]
    strip = add(name, mesh(name, corners, [(0, 1, 2, 3)]), (x, 0, 0))
    strip.modifiers.new("Particles", "PARTICLE_SYSTEM")
    strip.show_instancer_for_render = False
    settings = strip.particle_systems[0].settings
    settings.type, settings.count = kind, count
    settings.particle_size, settings.size_random = 0.5, 0.3
    return settings


def particle_scene(build: Build) -> bpy.types.Scene:
    """Particles that fly and spin, that show an object; hair that shows a collection; and the object as itself.

    All have the material "Told".
    """
    scene = empty_scene(32)
    scene.camera.data.ortho_scale, scene.camera.location.z = 6.4, 6.0
    plate = add("Plate", mesh("Plate", SQUARE, [(0, 1, 2, 3)], material("Told", build)), (2.7, 2.7, 0.5))
    flying = emitter("Flying", "EMITTER", 24, -1.3)
    flying.render_type, flying.instance_object = "OBJECT", plate
    flying.frame_start, flying.frame_end, flying.lifetime, flying.lifetime_random = 1, 5, 30, 0.5
    flying.angular_velocity_mode, flying.angular_velocity_factor = "RAND", 1.0
    plates = bpy.data.collections.new("Plates")
    twin = bpy.data.objects.new("Twin", plate.data)
    plates.objects.link(twin)
    standing = emitter("Standing", "HAIR", 16, 1.3)
    standing.use_advanced_hair = True
    standing.render_type, standing.instance_collection = "COLLECTION", plates
    for frame in range(1, FRAME + 1):  # it is not cached
        scene.frame_set(frame)
    return scene
