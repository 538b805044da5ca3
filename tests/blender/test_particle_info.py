# SPDX-License-Identifier: GPL-3.0-or-later
"""What Particle Info tells of instances that are particles is what Cycles tells."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from addon import last_render
from support.cycles_reference import rendered_pixels
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.followed_scene import Followed
from support.particle_scenes import FRAME, OFFSET, OUTPUTS, SQUARE, particle_scene, telling
from support.patch_nodes import Link, New, Socket
from support.small_scenes import CUBE_CORNERS, CUBE_FACES, add, light, material, mesh, node, plane, read
from tyndall.fingerprints import fingerprint

pytestmark = pytest.mark.dealt

#: A picture of Cycles is up to a hundredth of a pixel off its pixels' centres: a plate's edge may lie there.
EDGES = 0.02


def off(scene: bpy.types.Scene) -> tuple[float, int]:
    """The largest deviation of what is shown, but for edges, and how many different values there are."""
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=1, seed=1)
    errors = np.abs(ours - cycles).max(axis=2) / np.maximum(np.abs(cycles - OFFSET).max(axis=2), 1.0)
    kinds = np.unique(np.round(ours.reshape(-1, 3), 4), axis=0)
    return float(np.quantile(errors, 1.0 - EDGES)), len(kinds)


# Seen to fail with the age in seconds, with the index in the place of its hash, and with all instances the first one.
@pytest.mark.parametrize("output", OUTPUTS)
def test_particles_tell_what_they_do_in_cycles(output: str) -> None:
    error, kinds = off(particle_scene(telling(output)))
    assert error < 1e-4
    assert kinds > 15


def test_the_next_frame_is_read_anew() -> None:
    scene = particle_scene(telling("Age"))
    first = tyndall_pixels(scene)
    scene.frame_set(FRAME + 1)
    assert np.abs(tyndall_pixels(scene) - first).max() > 0.9
    assert off(scene)[0] < 1e-4


def test_children_are_no_particles() -> None:
    """As in Cycles, which tells their parents alone."""
    scene = particle_scene(telling("Size"))
    bpy.data.objects.remove(bpy.data.objects["Flying"])
    standing = bpy.data.objects["Standing"].particle_systems[0].settings
    standing.child_type, standing.rendered_child_count = "SIMPLE", 3
    error, kinds = off(scene)
    assert error < 1e-4
    assert kinds == 2  # the background, and plates of size 0


def test_a_window_hears_of_an_age_though_nothing_else_changed() -> None:
    """Particles of hair stand still; a lamp that moves is what is updated."""
    scene = particle_scene(telling("Age"))
    bpy.data.objects.remove(bpy.data.objects["Flying"])
    lamp = light("POINT", (0, 0, 3))
    for frame in (FRAME, FRAME + 1):
        lamp.location.x = float(frame)
        lamp.keyframe_insert("location", frame=frame)
    scene.frame_set(FRAME)
    followed = Followed()

    def ages() -> list[float]:
        of_plates = [group.particles for group in followed.read().instances if group.particles is not None]
        return [float(age) for states in of_plates for age in states[:, 2] if np.isfinite(age)]

    with followed.hears():
        before = ages()
        scene.frame_set(FRAME + 1)
        assert ages() == [age + 1.0 for age in before]
    assert len(before) == 16


def test_who_does_not_ask_does_not_pay() -> None:
    particle_scene(lambda new, _: new("ShaderNodeEmission").outputs[0])
    assert all(group.particles is None for group in read().instances)
    particle_scene(telling("Size"))
    told = [group.particles for group in read().instances if group.particles is not None]
    assert sum(len(states) for states in told) == 24 + 16 + 1
    assert sum(int(np.isnan(states[:, 0]).sum()) for states in told) == 1  # the plate itself


def test_what_no_material_reads_changes_nothing() -> None:
    """Hair that stands still is the same in the next frame, in which it is older: under a shutter it is one render."""
    scene = particle_scene(telling("Random"))
    bpy.data.objects.remove(bpy.data.objects["Flying"])
    before = fingerprint(read().instances)
    scene.frame_set(FRAME + 1)
    assert fingerprint(read().instances) == before


def test_a_node_in_a_group_is_found() -> None:
    scene = particle_scene(telling("Index"))
    group = bpy.data.node_groups.new("Told", "ShaderNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("Index", in_out="OUTPUT", socket_type="NodeSocketFloat")
    else:
        group.outputs.new("NodeSocketFloat", "Index")
    group.links.new(
        group.nodes.new("ShaderNodeParticleInfo").outputs["Index"], group.nodes.new("NodeGroupOutput").inputs[0]
    )
    tree = bpy.data.materials["Told"].node_tree
    info = next(one for one in tree.nodes if one.type == "PARTICLE_INFO")
    of_group = tree.nodes.new("ShaderNodeGroup")
    of_group.node_tree = group
    tree.links.new(of_group.outputs[0], info.outputs["Index"].links[0].to_socket)
    tree.nodes.remove(info)
    assert off(scene)[1] > 15


def pane(number: float) -> bpy.types.Mesh:
    def build(new: New, _: Link) -> Socket:
        return node(new, "ShaderNodeBsdfTransparent", Color=(number, number, number, 1.0)).outputs[0]

    return mesh("Pane", SQUARE, [(0, 1, 2, 3)], material("Pane", build))


def as_objects(scene: bpy.types.Scene) -> None:
    """In place of particles, objects with panes of the random number that each particle has."""
    told = [group for group in read().instances if group.particles is not None]
    for thing in [thing for thing in scene.objects if thing.modifiers]:
        bpy.data.objects.remove(thing)
    for group in told:
        for matrix, state in zip(group.world_from_object, group.particles, strict=True):
            if np.isfinite(state[0]):
                add("Pane", pane(float(state[1]))).matrix_world = Matrix(matrix)


# Seen to fail with programs of shadow maps that know no particle.
@pytest.mark.parametrize("method", ["SHADOW_MAP", "EPIPOLAR", "EXACT"])
def test_each_particle_dims_light_by_its_own_number(method: str) -> None:
    """On a floor and in a box of fog above it, as panes do that are objects."""

    def build(new: New, link: Link) -> Socket:
        clear = new("ShaderNodeBsdfTransparent")
        link(new("ShaderNodeParticleInfo").outputs["Random"], clear.inputs["Color"])
        return clear.outputs[0]

    scene = particle_scene(build)
    for name in ("Flying", "Standing"):
        bpy.data.objects[name].location.z = 2.0
    plane(-1.0)
    sun = light("SUN", (0, 0, 8))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 3.0, 0.0, (0.4, 0.3, 0.0)
    fog = material("Fog", None, lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.4).outputs[0])
    add("Fog", mesh("Fog", [(4 * x, 4 * y, z) for x, y, z in CUBE_CORNERS], CUBE_FACES, fog))
    scene.camera.data.type, scene.camera.data.lens = "PERSP", 34.0
    settings = scene.tyndall
    settings.pixel_samples, settings.pixel_filter, settings.filter_width_px = 1, "BOX", 0.01
    settings.shafts.method, settings.shafts.resolution = method, 1024
    of_particles = rendered_pixels(scene)
    as_objects(scene)
    off_by = float(np.abs(of_particles - rendered_pixels(scene)).mean())  # maps draw by the number of an instance
    print(f"{method}: spread {of_particles.std():.4f}, off {off_by:.5f}")
    assert off_by < 0.05 * of_particles.std()
    assert of_particles.std() > 0.1 * of_particles.mean()


def test_what_cannot_tell_is_named_once() -> None:
    """A displacement moves the mesh that all particles share."""
    scene = particle_scene(telling("Size"))
    tree = bpy.data.materials["Told"].node_tree
    info = next(one for one in tree.nodes if one.type == "PARTICLE_INFO")
    fog = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(info.outputs["Size"], fog.inputs["Density"])
    tree.links.new(fog.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    tyndall_pixels(scene)
    reports = [line for line in last_render.statistics_of("Scene")["reports"] if "Particle" in line]
    assert reports == ['Material "Told": Particle Info is read as 0 here: particles are not told apart']
