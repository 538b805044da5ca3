# SPDX-License-Identifier: GPL-3.0-or-later
"""The fire of the guide to light shafts: an OpenVDB file of density and temperature, and what a shader makes of it."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np
from guide_voxels import shader
from mathutils import Vector

from tyndall.volumes import from_dense, write_vdb

if TYPE_CHECKING:
    from numpy.typing import NDArray

_VOXELS = (96, 96, 144)
_VOXEL_M = 2.0 / 96


def _lumps(seed: int) -> NDArray[np.float32]:
    """Noise about 0, of deviation 1, whose lumps are a few tenths of a metre large, and smaller ones."""
    spectrum = np.fft.rfftn(np.random.default_rng(seed).normal(size=_VOXELS))
    along = [np.fft.fftfreq(_VOXELS[0]), np.fft.fftfreq(_VOXELS[1]), np.fft.rfftfreq(_VOXELS[2])]
    frequency = np.sqrt(sum(axis**2 for axis in np.meshgrid(*along, indexing="ij")))
    lumps = np.fft.irfftn(spectrum * (frequency + 0.015) ** -2.2 * (frequency > 0), s=_VOXELS)
    return np.asarray(lumps / lumps.std(), np.float32)


def _write_fire(path: Path) -> None:
    """A column that leans as it rises, of smoke, with a hot core at its foot. 0 to 1, and degrees Kelvin."""
    x, y, z = (
        (np.arange(count) + 0.5) * _VOXEL_M - offset_m for count, offset_m in zip(_VOXELS, (1.0, 1.0, 0.0), strict=True)
    )
    x, y, z = np.meshgrid(x, y, z, indexing="ij")
    x = x - 0.12 * z * z + 0.06 * _lumps(1)
    y = y + 0.06 * _lumps(2)
    radius = np.sqrt(x * x + y * y) / (0.22 + 0.2 * z)
    fades = np.clip(z / 0.15, 0.0, 1.0) * np.clip((2.9 - z) / 1.2, 0.0, 1.0)
    density = np.clip(1.15 - radius + 0.22 * _lumps(3), 0.0, 1.0) * fades
    core = np.sqrt(x * x + y * y) / (0.3 + 0.05 * z)
    heat = np.clip(1.25 - core - 0.7 * z + 0.3 * _lumps(4), 0.0, 1.0) * np.clip(z / 0.1, 0.0, 1.0)
    density *= 1.0 - np.clip(1.6 * heat, 0.0, 1.0)
    local_from_index = np.diag([_VOXEL_M, _VOXEL_M, _VOXEL_M, 1.0])
    local_from_index[:3, 3] = (-1.0, -1.0, 0.0)
    local_from_index[:3, 3] += 0.5 * _VOXEL_M
    write_vdb(
        path,
        [
            from_dense("density", np.asarray(density, np.float32), local_from_index),
            from_dense("temperature", np.asarray(2600.0 * heat, np.float32), local_from_index),
        ],
    )


def _material() -> bpy.types.Material:
    """Smoke by a ramp of the density, and flames of the temperature where there is hardly any."""
    material = shader("Fire", "ShaderNodeVolumePrincipled")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    principled = next(node for node in nodes if node.type == "PRINCIPLED_VOLUME")
    output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    links.remove(output.inputs["Surface"].links[0])
    links.new(principled.outputs[0], output.inputs["Volume"])
    for name, value in {
        "Color": (0.35, 0.33, 0.32, 1.0),
        "Density Attribute": "",
        "Blackbody Intensity": 1.0,
        "Temperature": 1.0,
        "Blackbody Tint": (1.0, 0.75, 0.55, 1.0),
        "Anisotropy": 0.2,
    }.items():
        principled.inputs[name].default_value = value
    density, ramp, times = (nodes.new(kind) for kind in ("ShaderNodeAttribute", "ShaderNodeValToRGB", "ShaderNodeMath"))
    density.attribute_name = "density"
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.15, 0.75
    times.operation, times.inputs[1].default_value = "MULTIPLY", 14.0
    links.new(density.outputs["Fac"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], times.inputs[0])
    links.new(times.outputs[0], principled.inputs["Density"])
    return material


def _add(name: str, data: bpy.types.ID) -> bpy.types.Object:
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def show_fire(engine: str = "TYNDALL") -> None:
    """Build the scene anew: a fire before a wall, in the sun."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    path = Path(tempfile.mkdtemp(prefix="tyndall_")) / "fire.vdb"
    _write_fire(path)
    volume = bpy.data.volumes.new("Fire")
    volume.filepath = str(path)
    volume.materials.append(_material())
    _add("Fire", volume)
    for name, corners, colour in (
        ("Ground", [(-9, -6, 0), (9, -6, 0), (9, 2.2, 0), (-9, 2.2, 0)], (0.16, 0.15, 0.13, 1)),
        ("Wall", [(-9, 2.2, 0), (9, 2.2, 0), (9, 2.2, 6), (-9, 2.2, 6)], (0.2, 0.24, 0.26, 1)),
    ):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
        mesh.materials.append(shader(name, "ShaderNodeBsdfDiffuse", Color=colour))
        _add(name, mesh)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.color, sun.angle = 2.5, (1.0, 0.9, 0.75), 0.0
    _add("Sun", sun).rotation_euler = (math.radians(35), math.radians(-42), 0)
    lens = bpy.data.cameras.new("Camera")
    lens.lens = 50
    scene.camera = _add("Camera", lens)
    scene.camera.location = (-0.4, -6.4, 1.5)
    towards = Vector((0.35, 0.0, 1.35)) - scene.camera.location
    scene.camera.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()
    scene.render.engine = engine
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 8, 0.0
    scene.cycles.device, scene.cycles.samples = "CPU", 64
    scene.cycles.max_bounces = scene.cycles.volume_bounces = 0
    scene.cycles.use_denoising = False
    scene.cycles.transparent_max_bounces = 256  # its volumes are many hulls: with 8, some pixels are black
    scene.view_settings.view_transform = "Filmic" if bpy.app.version < (4, 0, 0) else "AgX"
