# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders that bend, multiply grids, or read colours and places, beside Cycles: what they glow and dim."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.clouds import cloud, cloud_file, look, rms_difference, sparse, volume_object, wall
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, Node, material, node, plane, read
from tyndall.volumes import write_vdb
from tyndall.voxel_dag import Config, from_coordinates

New, Link = Callable[[str], Node], Callable[..., object]
Socket = bpy.types.NodeSocket
IS_4 = bpy.app.version >= (4, 0, 0)
VOXELS = 48


def of_grid(new: New, name: str, output: str = "Fac") -> Socket:
    attribute = new("ShaderNodeAttribute")
    attribute.attribute_name = name
    return attribute.outputs[output]


def math(new: New, link: Link, operation: str, *operands: Socket | float) -> Socket:
    made = new("ShaderNodeMath")
    made.operation = operation
    for given, operand in zip(made.inputs, operands, strict=False):
        if isinstance(operand, float):
            given.default_value = operand
        else:
            link(operand, given)
    return made.outputs[0]


def fire_file(folder: Path) -> Path:
    """Density, and a temperature whose hot core lies beside the cloud's middle."""
    place = (np.arange(VOXELS) + 0.5) * (2.0 / VOXELS) - 1.0
    x, y, z = np.meshgrid(place, place, place, indexing="ij")
    heat = np.clip(1.0 - 2.0 * ((x - 0.2) ** 2 + (y + 0.1) ** 2 + z * z), 0.0, None)
    path = folder / "fire.vdb"
    write_vdb(path, [sparse(cloud(VOXELS)), sparse(np.asarray(2500.0 * heat, np.float32), "temperature")])
    return path


def colour_file(folder: Path) -> Path:
    """Smooth colours in a cube that is full of density 1, of voxels whose colours a DAG has."""
    indices = np.indices((32, 32, 32)).reshape(3, -1).T
    colors = np.rint(40 + 200 * indices / 31).astype(np.uint8)
    bounds_m = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    path = folder / "colour.vdb"
    from_coordinates(indices, Config(resolution=32, bounds_m=bounds_m, colors=colors)).to_vdb(path)
    return path


def glow(new: New, link: Link, strength: Socket, color: Socket | None = None) -> Socket:
    emission = new("ShaderNodeEmission")
    link(strength, emission.inputs["Strength"])
    if color is not None:
        link(color, emission.inputs["Color"])
    return emission.outputs[0]


def glows_by_a_ramp(new: New, link: Link) -> Socket:
    """Of density, in other colours and more than straight."""
    ramp = new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.1, 0.7
    ramp.color_ramp.elements[1].color = (1.0, 0.4, 0.1, 1.0)
    link(of_grid(new, "density"), ramp.inputs["Fac"])
    squared = math(new, link, "POWER", of_grid(new, "density"), 2.0)
    return glow(new, link, squared, ramp.outputs["Color"])


def glows_by_two_grids(new: New, link: Link) -> Socket:
    heat = math(new, link, "MULTIPLY", of_grid(new, "temperature"), 1e-3)
    return glow(new, link, math(new, link, "MULTIPLY", of_grid(new, "density"), heat))


def burns(new: New, _link: Link) -> Socket:
    inputs = {"Density": 0.0, "Blackbody Intensity": 0.4, "Temperature": 2.0, "Blackbody Tint": (1.0, 0.8, 0.6, 1.0)}
    return node(new, "ShaderNodeVolumePrincipled", **inputs).outputs[0]


def glows_by_place(new: New, link: Link) -> Socket:
    """Density times a wave along the object's x."""
    wave = new("ShaderNodeTexWave")
    wave.inputs["Scale"].default_value = 0.5
    link(new("ShaderNodeTexCoord").outputs["Object"], wave.inputs["Vector"])
    return glow(new, link, math(new, link, "MULTIPLY", of_grid(new, "density"), wave.outputs["Fac"]))


def glows_by_a_mix(new: New, link: Link) -> Socket:
    """Between two glows, by the density; and one of a constant share. In 3.4 each is seen in full."""
    mixes = [new("ShaderNodeMixShader") for _ in range(2)]
    mixes[0].inputs[0].default_value = 0.3
    link(of_grid(new, "density"), mixes[1].inputs[0])
    link(glow(new, link, of_grid(new, "density")), mixes[0].inputs[1])
    link(mixes[0].outputs[0], mixes[1].inputs[1])
    link(glow(new, link, math(new, link, "MULTIPLY", of_grid(new, "density"), 3.0)), mixes[1].inputs[2])
    return mixes[1].outputs[0]


def glows_in_colours(new: New, link: Link) -> Socket:
    return glow(new, link, of_grid(new, "density"), new("ShaderNodeVolumeInfo").outputs["Color"])


@pytest.mark.dealt
@pytest.mark.parametrize(
    ("file", "shader"),
    [
        (cloud_file, glows_by_a_ramp),
        (fire_file, glows_by_two_grids),
        (fire_file, burns),
        (cloud_file, glows_by_place),
        (cloud_file, glows_by_a_mix),
        (colour_file, glows_in_colours),
    ],
)
def test_what_varies_glows_as_in_cycles(tmp_path: Path, file: Callable[[Path], Path], shader: Build) -> None:
    scene = look()
    volume_object(file(tmp_path), material("Glow", volume=shader))
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=200, seed=1)
    assert cycles.mean() > 0.05
    assert ours.mean(axis=(0, 1)) == pytest.approx(cycles.mean(axis=(0, 1)), rel=0.015)
    assert rms_difference(ours, cycles) < 0.03
    assert not read().reports


def dims_by_a_square(new: New, link: Link) -> Socket:
    absorption = node(new, "ShaderNodeVolumeAbsorption", Color=(0.2, 0.5, 0.9, 1.0))
    link(math(new, link, "POWER", of_grid(new, "density"), 2.0), absorption.inputs["Density"])
    return absorption.outputs[0]


def scatters_in_colours(new: New, _link: Link) -> Socket:
    inputs = {"Density": 0.5, "Color": (0.9, 0.8, 0.7, 1.0), "Color Attribute": "color"}
    return node(new, "ShaderNodeVolumePrincipled", **inputs).outputs[0]


@pytest.mark.dealt
@pytest.mark.parametrize(("file", "shader"), [(cloud_file, dims_by_a_square), (colour_file, scatters_in_colours)])
def test_what_varies_dims_as_in_cycles(tmp_path: Path, file: Callable[[Path], Path], shader: Build) -> None:
    if shader is scatters_in_colours and not IS_4:
        pytest.skip("3.4 lets more light through than Beer's law says where colours differ")
    scene = look(width_m=1.8)
    plane(-3.0, material("Wall", surface=wall))
    volume_object(file(tmp_path), material("Smoke", volume=shader))
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=400, seed=1)
    assert ours.mean(axis=(0, 1)) == pytest.approx(cycles.mean(axis=(0, 1)), rel=5e-3)
    assert rms_difference(ours, cycles) < 0.04


def test_a_linear_shader_takes_the_grids_as_they_are(tmp_path: Path) -> None:
    """Of others, one is made for each number, and that of all instances; a second read makes none anew."""
    look()
    first = volume_object(
        fire_file(tmp_path), material("Fire", volume=lambda new, _: node(new, "ShaderNodeVolumePrincipled").outputs[0])
    )
    (plain,) = read().volumes
    assert plain.grid.grid.name == "density"
    first.data.materials[0] = material("Bent", volume=glows_by_two_grids)
    twin = bpy.data.objects.new("Twin", first.data)
    twin.location.x = 3.0
    bpy.context.scene.collection.objects.link(twin)
    graph, reports = bpy.context.evaluated_depsgraph_get(), Reports()
    reader = SceneReader()
    here, there = reader.read(graph, reports, lambda: None).volumes
    assert here.grid is there.grid
    assert here.grid.grid.name == "density and temperature"
    assert [volume.grid for volume in reader.read(graph, reports, lambda: None).volumes] == [here.grid] * 2
    first.data.materials[0] = material("By Object", volume=glows_by_random)
    here, there = read().volumes
    assert here.grid.key != there.grid.key


def glows_by_random(new: New, link: Link) -> Socket:
    random = new("ShaderNodeObjectInfo").outputs["Random"]
    return glow(new, link, math(new, link, "MULTIPLY", of_grid(new, "density"), random))


def test_empty_grids_are_named(tmp_path: Path) -> None:
    look()
    path = tmp_path / "empty.vdb"
    write_vdb(path, [sparse(np.zeros((8, 8, 8), np.float32), name) for name in ("density", "temperature")])
    volume_object(path, material("Glow", volume=glows_by_two_grids))
    described = read()
    assert not described.volumes
    assert described.reports == ('Object "Cloud": its grid "density" is empty; its grid "temperature" is empty',)


def test_grids_of_other_voxels_are_named(tmp_path: Path) -> None:
    look()
    path = tmp_path / "two.vdb"
    write_vdb(path, [sparse(cloud(48)), sparse(cloud(32), "temperature")])
    volume_object(path, material("Glow", volume=glows_by_two_grids))
    described = read()
    assert not described.volumes
    assert described.reports == (
        'Object "Cloud": not drawn: its grids "density" and "temperature" have other voxels: resample one of them',
    )
