# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes without a file: what modifiers make of meshes, and the smoke of fluid domains, beside Cycles."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon.sync.scene import SceneReader
from support.clouds import cloud_file, look, rms_difference, volume_object, wall
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import CUBE_CORNERS, CUBE_FACES, Node, add, cube, material, node, plane, read
from tyndall.fingerprints import fingerprint
from tyndall.volumes import read_vdb, to_dense


def soot(new: Callable[[str], Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
    """Absorbs alone: Cycles draws it without noise before 5.0."""
    absorption = node(new, "ShaderNodeVolumeAbsorption", Color=(0.2, 0.5, 0.9, 1.0))
    link(new("ShaderNodeVolumeInfo").outputs["Density"], absorption.inputs["Density"])
    return absorption.outputs[0]


def before_a_wall() -> tuple[bpy.types.Scene, bpy.types.Material]:
    scene = look()
    plane(-3.0, material("Wall", surface=wall))
    return scene, material("Soot", volume=soot)


def meshed_volume(shader: bpy.types.Material) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A volume that a modifier makes of a mesh, which is not drawn."""
    shape = cube("Shape")
    shape.scale, shape.rotation_euler, shape.hide_render = (0.5, 0.7, 0.6), (0.3, 0.2, 0.5), True
    made = add("Made", bpy.data.volumes.new("Made"))
    made.data.materials.append(shader)
    modifier = made.modifiers.new("Mesh to Volume", "MESH_TO_VOLUME")
    modifier.object, modifier.voxel_amount, modifier.density = shape, 24, 1.5
    return made, shape


def test_a_volume_that_a_modifier_makes_is_what_cycles_draws() -> None:
    scene, shader = before_a_wall()
    meshed_volume(shader)
    ours = tyndall_pixels(scene)
    cycles = cycles_pixels(scene, samples=256 if bpy.app.version >= (5, 0, 0) else 16, seed=1)
    assert ours.min() < 0.7  # it is there
    assert rms_difference(ours, cycles) < 0.01


def test_a_volume_that_a_modifier_makes_is_what_blender_writes_of_it(tmp_path: Path) -> None:
    _, shader = before_a_wall()
    made, _ = meshed_volume(shader)
    (volume,) = read().volumes
    path = tmp_path / "made.vdb"
    made.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.grids.save(str(path))
    written = read_vdb(path, ["density"])["density"]
    assert np.array_equal(volume.grid.grid.leaf_values, written.leaf_values)
    assert np.array_equal(volume.grid.grid.local_from_index, written.local_from_index)


def test_a_modifier_changes_the_volume_of_a_file(tmp_path: Path) -> None:
    """Displaced along x by noise of a large size: no voxel of the file is drawn where it was."""
    _, shader = before_a_wall()
    thing = volume_object(cloud_file(tmp_path), shader)
    (before,) = read().volumes
    modifier = thing.modifiers.new("Displace", "VOLUME_DISPLACE")
    modifier.texture = bpy.data.textures.new("Clouds", "CLOUDS")
    modifier.texture_map_mode, modifier.strength = "GLOBAL", 0.5
    (after,) = read().volumes
    modifier.show_render = modifier.show_viewport = False
    (without,) = read().volumes
    assert after.grid.key != before.grid.key
    assert not np.array_equal(to_dense(after.grid.grid)[0], to_dense(before.grid.grid)[0])
    assert without.grid.key == before.grid.key


def test_what_was_made_is_read_again_only_when_it_changes(request: pytest.FixtureRequest) -> None:
    _, shader = before_a_wall()
    _, shape = meshed_volume(shader)
    other = cube("Other")
    reader = SceneReader()

    def hear(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        reader.note_updates(depsgraph)

    def read_live() -> list[object]:
        bpy.context.view_layer.update()
        return [volume.grid for volume in read(reader, is_live=True).volumes]

    bpy.app.handlers.depsgraph_update_post.append(hear)
    request.addfinalizer(lambda: bpy.app.handlers.depsgraph_update_post.remove(hear))
    first = read_live()
    other.location.x += 0.1
    assert read_live()[0] is first[0]
    shape.scale *= 0.5
    assert read_live()[0] is not first[0]


def test_two_reads_of_what_is_made_give_one_fingerprint() -> None:
    """Blender writes another file each time; its content counts."""
    _, shader = before_a_wall()
    meshed_volume(shader)
    assert fingerprint(read()) == fingerprint(read())


def test_an_empty_volume_is_named() -> None:
    _, shader = before_a_wall()
    add("Nothing", bpy.data.volumes.new("Nothing")).data.materials.append(shader)
    described = read()
    assert not described.volumes
    assert any('"Nothing"' in line and "no file" in line for line in described.reports)


def simulated(folder: Path, shader: bpy.types.Material, frames: int = 5, **settings: object) -> bpy.types.Object:
    """Smoke that rises in a box of 2 x 1.5 x 2 m, turned and moved; at its last frame."""
    domain = cube("Domain", shader)
    domain.data.transform(((1, 0, 0, 0.2), (0, 0.75, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)))
    domain.location, domain.rotation_euler = (-0.1, 0.1, 0.2), (0.2, 0.1, 0.4)
    fluid = domain.modifiers.new("Fluid", "FLUID")
    fluid.fluid_type = "DOMAIN"
    of_domain = fluid.domain_settings
    of_domain.domain_type, of_domain.resolution_max, of_domain.cache_directory = "GAS", 16, str(folder)
    smoke_color = settings.pop("smoke_color", (0.7, 0.7, 0.7))
    for name, value in settings.items():
        setattr(of_domain, name, value)
    source = add("Source", bpy.data.meshes.new("Source"), location=(0.1, 0.0, -0.4))
    source.data.from_pydata([(0.4 * x, 0.3 * y, 0.3 * z) for x, y, z in CUBE_CORNERS], [], CUBE_FACES)
    flow = source.modifiers.new("Fluid", "FLUID")
    flow.fluid_type = "FLOW"
    flow.flow_settings.flow_type, flow.flow_settings.flow_behavior = "SMOKE", "INFLOW"
    flow.flow_settings.smoke_color = smoke_color
    source.hide_render = True
    for frame in range(1, frames + 1):
        bpy.context.scene.frame_set(frame)
    if not any(settings_of(domain).density_grid):
        pytest.skip("this Blender's fluid solver simulates no smoke")
    return domain


def settings_of(domain: bpy.types.Object) -> bpy.types.FluidDomainSettings:
    return domain.evaluated_get(bpy.context.evaluated_depsgraph_get()).modifiers["Fluid"].domain_settings


@pytest.fixture
def fluid_solver(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """That of a bpy module simulates nothing, and ends the process when it is freed."""
    if not bpy.app.binary_path:
        pytest.skip("the bpy module's fluid solver simulates nothing")
    monkeypatch.chdir(tmp_path)  # it leaves a tile of noise of 25 MB where it runs


@pytest.mark.usefixtures("fluid_solver")
@pytest.mark.parametrize("settings", [{}, {"use_noise": True}, {"use_adaptive_domain": True}])
def test_smoke_is_what_cycles_draws(tmp_path: Path, settings: dict[str, object]) -> None:
    scene, shader = before_a_wall()
    simulated(tmp_path, shader, **settings)
    scene.cycles.volume_step_rate = 0.1
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=16, seed=1)
    assert ours.min() < 0.7
    assert rms_difference(ours, cycles) < 2e-3


@pytest.mark.usefixtures("fluid_solver")
def test_coloured_smoke_is_what_cycles_draws(tmp_path: Path) -> None:
    """Which is what it glows in."""
    scene, _ = before_a_wall()

    def glowing(new: Callable[[str], Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
        info = new("ShaderNodeVolumeInfo")
        emission = new("ShaderNodeEmission")
        link(info.outputs["Density"], emission.inputs["Strength"])
        link(info.outputs["Color"], emission.inputs["Color"])
        return emission.outputs[0]

    domain = simulated(tmp_path, material("Glow", volume=glowing), smoke_color=(0.9, 0.3, 0.1))
    assert len(settings_of(domain).color_grid) > 0
    scene.cycles.volume_step_rate = 0.1
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=64, seed=1)
    red, green, blue = cycles.mean(axis=(0, 1)) - cycles.min(axis=(0, 1))
    assert red > 2.0 * green > 0.0 < blue
    assert ours.mean(axis=(0, 1)) == pytest.approx(cycles.mean(axis=(0, 1)), rel=0.01)


@pytest.mark.usefixtures("fluid_solver")
def test_voxels_of_smoke_are_those_of_the_simulation(tmp_path: Path) -> None:
    _, shader = before_a_wall()
    domain = simulated(tmp_path, shader)
    described = read()
    (volume,) = described.volumes
    assert not [group for group in described.instances if "Domain" in group.object_names]
    of_domain = settings_of(domain)
    nx, ny, nz = of_domain.domain_resolution
    dense, first = to_dense(volume.grid.grid, ((0, 0, 0), (nx, ny, nz)))
    assert first == (0, 0, 0)
    assert np.array_equal(dense.transpose(2, 1, 0).ravel(), np.array(of_domain.density_grid, np.float32))


@pytest.mark.usefixtures("fluid_solver")
def test_a_domain_without_smoke_is_named(tmp_path: Path) -> None:
    _, shader = before_a_wall()
    domain = cube("Domain", shader)
    fluid = domain.modifiers.new("Fluid", "FLUID")
    fluid.fluid_type = "DOMAIN"
    fluid.domain_settings.domain_type, fluid.domain_settings.cache_directory = "GAS", str(tmp_path)
    described = read()
    assert not described.volumes
    assert any('"Domain"' in line and "bake the simulation" in line for line in described.reports)
