# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of voxels where nodes vary from place to place: those that the nodes have in the middle of each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix

from addon.sync import varying_voxels
from addon.sync.varying_voxels import _corner_uvs, _laid_out, _texels
from addon.sync.voxel_meshes import gather
from addon.sync.voxel_surfaces import surface_of
from addon.voxel_boxes import file_of
from support.small_scenes import Build, Node, add, empty_scene, material, mesh, node
from tyndall.voxel_dag import VoxelDag, load

New, Link = Callable[[str], Node], Callable[..., object]
RESOLUTION = 128
RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@pytest.fixture
def scene() -> bpy.types.Scene:
    return empty_scene()


def voxelized(folder: Path, *things: bpy.types.Object, channels: tuple[str, ...] = ()) -> tuple[VoxelDag, np.ndarray]:
    """And the middles of the voxels in the world, (k, 3)."""
    bpy.context.view_layer.update()
    for one in bpy.context.view_layer.objects:
        one.select_set(one in things)
    bpy.context.view_layer.objects.active = things[0]
    asked = bpy.context.scene.tyndall.voxelize
    asked.resolution, asked.path = str(RESOLUTION), str(folder / "made.tdag")
    for name in channels:
        setattr(asked, f"has_{name}", True)
    assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
    box = bpy.context.object
    dag = load(file_of(box))
    lower, upper = (np.array(corner) for corner in dag.bounds_m)
    voxels = np.concatenate(list(dag.coordinates()))
    return dag, lower + (voxels + 0.5) / RESOLUTION * (upper - lower) + np.array(box.location)


def colours(dag: VoxelDag) -> np.ndarray:
    return np.asarray(dag.colors_at(np.concatenate(list(dag.coordinates()))), float) / 255.0


def checks(output: str, scale: float = 1.0) -> Build:
    """Red where the sum of whole coordinates is odd, blue elsewhere."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        where = new("ShaderNodeNewGeometry" if output == "Position" else "ShaderNodeTexCoord")
        pattern = node(new, "ShaderNodeTexChecker", Color1=(*RED, 1), Color2=(*BLUE, 1), Scale=scale)
        shader = new("ShaderNodeBsdfDiffuse")
        link(where.outputs[output], pattern.inputs["Vector"])
        link(pattern.outputs["Color"], shader.inputs["Color"])
        return shader.outputs[0]

    return build


def sheet(surface: bpy.types.Material, cuts: int) -> bpy.types.Object:
    """From -1 to 1, of strips that get thinner, so that triangles are from larger than all voxels to far smaller."""
    across = 2.0 * np.linspace(0.0, 1.0, cuts + 1) ** 3 - 1.0
    corners = [(x, y, 0.1) for y in (-1.0, -0.93, 1.0) for x in across]
    row = cuts + 1
    faces = [
        (at, at + 1, at + 1 + row, at + row) for first in range(2) for at in range(first * row, first * row + cuts)
    ]
    return add("Sheet", mesh("Sheet", corners, faces, surface))


PLACES = {
    "as it is": Matrix(),
    "turned": Euler((0.3, 0.2, 0.5)).to_matrix().to_4x4(),
    "stretched": Matrix.Diagonal((4.0, 1.0, 1.0, 1.0)),
    "mirrored": Euler((0.0, 0.4, 0.0)).to_matrix().to_4x4() @ Matrix.Diagonal((-1.0, 1.0, 1.0, 1.0)),
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("cuts", [1, 40])
def test_colours_are_those_where_the_voxel_is(scene: bpy.types.Scene, tmp_path: Path, place: str, cuts: int) -> None:
    """Whatever the triangles. Seen to fail: corners that stay in the order of the longest edge, and mirrored ones."""
    thing = sheet(material("Checks", checks("Object", 3.1)), cuts)
    thing.matrix_world = PLACES[place]
    dag, middles = voxelized(tmp_path, thing)
    in_object = (np.c_[middles, np.ones(len(middles))] @ np.array(PLACES[place].inverted()).T)[:, :2] * 3.1
    voxel = 3.1 * np.ptp(middles, axis=0).max() / RESOLUTION / np.array(PLACES[place].to_scale())[:2]
    is_inside = (np.abs(in_object - np.round(in_object)) > 1.5 * np.abs(voxel)).all(axis=1)
    assert is_inside.mean() > 0.3
    is_red = np.floor(in_object).sum(axis=1) % 2 == 1
    wrong = np.abs(colours(dag) - np.where(is_red[:, None], RED, BLUE)).max(axis=1) > 0.1
    assert not wrong[is_inside].any()


def test_normals_are_known(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """As moss that grows on what looks upwards."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        geometry, apart = new("ShaderNodeNewGeometry"), new("ShaderNodeSeparateXYZ")
        ramp, shader = new("ShaderNodeMath"), new("ShaderNodeBsdfDiffuse")
        ramp.operation, ramp.inputs[1].default_value = "GREATER_THAN", 0.5
        link(geometry.outputs["Normal"], apart.inputs[0])
        link(apart.outputs["Z"], ramp.inputs[0])
        link(ramp.outputs[0], shader.inputs["Color"])
        return shader.outputs[0]

    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    cube.rotation_euler = (0.3, 0.0, 0.0)  # 17 degrees: normals are the world's
    cube.data.materials.append(material("Moss", build))
    dag, middles = voxelized(tmp_path, cube)
    in_object = middles @ np.array(Euler((0.3, 0.0, 0.0)).to_matrix())
    is_on_top = (np.abs(in_object[:, :2]) < 0.95).all(axis=1) & (in_object[:, 2] > 0.9)
    is_below = in_object[:, 2] < 0.95
    assert is_on_top.any()
    assert (colours(dag)[is_on_top] > 0.9).all()
    assert (colours(dag)[is_below] < 0.1).all()


def test_instances_have_what_is_their_own(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Two objects of one mesh, whose colours of their own, bent by nodes, and places differ."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        info, shader = new("ShaderNodeObjectInfo"), new("ShaderNodeBsdfDiffuse")
        link(info.outputs["Color"], shader.inputs["Color"])
        return shader.outputs[0]

    first = sheet(material("Own", build), 3)
    second = add("Other", first.data, location=(0.0, 0.0, 1.0))
    first.color, second.color = (*RED, 1), (*BLUE, 1)
    dag, middles = voxelized(tmp_path, first, second)
    assert np.allclose(colours(dag), np.where(middles[:, 2:] < 0.5, RED, BLUE), atol=0.01)


def test_channels_vary_too(scene: bpy.types.Scene, tmp_path: Path) -> None:
    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        shader, pattern = new("ShaderNodeBsdfPrincipled"), node(new, "ShaderNodeTexChecker", Scale=1.0)
        where = new("ShaderNodeNewGeometry")
        pattern.inputs["Color1"].default_value = (0.6, 0.6, 0.6, 1)
        pattern.inputs["Color2"].default_value = (0, 0, 0, 1)
        link(where.outputs["Position"], pattern.inputs["Vector"])
        link(pattern.outputs["Color"], shader.inputs["Roughness"])
        return shader.outputs[0]

    dag, middles = voxelized(tmp_path, sheet(material("Rough", build), 2), channels=("roughness",))
    rough = np.asarray(dag.channel_at("roughness", np.concatenate(list(dag.coordinates()))))
    is_odd = np.floor(middles[:, :2]).sum(axis=1) % 2 == 1
    is_inside = (np.abs(middles - np.round(middles))[:, :2] > 0.03).all(axis=1)
    assert (np.abs(rough - np.where(is_odd, 153, 0))[is_inside] <= 1).all()


def test_glow_that_varies_is_said_and_leaves_colours_as_they_are(scene: bpy.types.Scene) -> None:
    """Which are a number here. Seen to fail: drawn, and said of pictures alone."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        shader, pattern = new("ShaderNodeBsdfPrincipled"), new("ShaderNodeTexNoise")
        (shader.inputs.get("Emission Color") or shader.inputs["Emission"]).default_value = (1, 1, 1, 1)
        link(pattern.outputs["Fac"], shader.inputs["Emission Strength"])
        return shader.outputs[0]

    thing = sheet(material("Lava", build), 2)
    bpy.context.view_layer.update()
    gathered = gather(bpy.context.evaluated_depsgraph_get(), [thing], channels=["emission"])
    told = "its glow is, on voxels, pictures times colour attributes; what else its nodes read is half grey"
    assert gathered.reports.lines() == (f'Material "Lava": {told}',)
    assert gathered.varying == []


def test_too_many_texels_are_larger_and_it_is_said(scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(varying_voxels, "MOST_TEXELS", 1000)
    thing = sheet(material("Checks", checks("Position")), 2)
    bpy.context.view_layer.update()
    gathered = gather(bpy.context.evaluated_depsgraph_get(), [thing])
    carried = {"has_colors": True, "has_normals": False, "channels": ()}
    *_, fields = surface_of(gathered, resolution=RESOLUTION, **carried)
    assert fields["textures"].materials[-1].picture.size <= 3 * 1300
    assert gathered.reports.lines() == ("Voxels: nodes that vary are read every 0.0894 m; a voxel is 0.0156 m",)


def test_what_is_one_point_has_a_texel_for_each_triangle(scene: bpy.types.Scene) -> None:
    """Seen to fail: without a size of texels."""
    thing = sheet(material("Checks", checks("Object")), 2)
    thing.scale = (0.0, 0.0, 0.0)
    bpy.context.view_layer.update()
    gathered = gather(bpy.context.evaluated_depsgraph_get(), [thing])
    carried = {"has_colors": True, "has_normals": False, "channels": ()}
    *_, fields = surface_of(gathered, resolution=RESOLUTION, **carried)
    assert fields["textures"].materials[-1].picture.shape == (4, 2, 3)  # of eight triangles


def test_it_can_be_stopped(scene: bpy.types.Scene) -> None:
    thing = sheet(material("Checks", checks("Position")), 2)
    bpy.context.view_layer.update()
    gathered = gather(bpy.context.evaluated_depsgraph_get(), [thing])

    def poll() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        surface_of(gathered, resolution=8, has_colors=True, has_normals=False, channels=(), poll=poll)


def test_pieces_are_to_scale_and_apart() -> None:
    """Of triangles of all sizes and shapes, points and lines among them.

    A look-up at any point of a triangle, half a texel around it, finds texels of its own.
    """
    random = np.random.default_rng(3)
    corners = random.normal(size=(400, 3, 3)) * np.exp(random.uniform(-6.0, 3.0, (400, 1, 1)))
    corners[:20, 2] = corners[:20, 0] + 0.3 * (corners[:20, 1] - corners[:20, 0])  # lines
    corners[20:30] = corners[20:30, :1]  # points
    pieces = _laid_out(corners, 0.1)
    width, height = pieces.size
    owner = np.full((height, width), -1)
    for texels, owners, shares in _texels(pieces):
        assert (owner.ravel()[texels] == -1).all()
        owner.ravel()[texels] = owners
        assert np.allclose(shares.sum(axis=1), 1.0)
    uvs = _corner_uvs(pieces) * (width, height)
    inside = random.dirichlet((1.0, 1.0, 1.0), (400, 50))
    at = np.einsum("tnc,tcx->tnx", inside, uvs.astype(float))
    for offset in ((-0.499, -0.499), (-0.499, 0.499), (0.499, -0.499), (0.499, 0.499)):
        column, row = np.floor(at + offset).astype(int).transpose(2, 0, 1)
        assert (owner[row, column] == np.arange(400)[:, None]).all()
    lengths, in_texels = (np.linalg.norm(of - of[:, (1, 2, 0)], axis=2) for of in (corners, uvs.astype(float)))
    assert (in_texels <= lengths / 0.1 + 1e-3).all()
    is_large = pieces.steps.min(axis=1) >= 10
    assert is_large.any()
    assert (in_texels[is_large] >= 0.85 * lengths[is_large] / 0.1).all()
