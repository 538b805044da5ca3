# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a scene becomes voxels."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest

import tyndall
from addon.sync.voxel_meshes import VoxelMesh
from support.small_scenes import CUBE_CORNERS, add, cube, material, mesh, node, plane
from tyndall.blender.voxel_meshes import gather


@pytest.fixture
def bare(scene: bpy.types.Scene) -> bpy.types.Scene:
    """The factory scene without its cube."""
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    return scene


def gathered(*objects: bpy.types.Object) -> VoxelMesh:
    return gather(bpy.context.evaluated_depsgraph_get(), objects)


def corners_of(found: VoxelMesh) -> set[tuple[float, ...]]:
    """Of its triangles, to a micrometre."""
    return set(map(tuple, np.round(found.positions_m[found.triangles].reshape(-1, 3), 6).tolist()))


def test_a_mesh_is_taken_where_it_stands(bare: bpy.types.Scene) -> None:
    """Rotated, scaled, moved; what is not chosen stays out."""
    box = cube()
    box.location, box.scale, box.rotation_euler = (1.0, 2.0, 3.0), (2.0, 1.0, 0.5), (0.0, 0.0, np.pi / 2)
    cube("Other").location = (100.0, 0.0, 0.0)
    found = gathered(box)
    assert found.positions_m.dtype == np.float64
    assert found.triangles.dtype == np.uint32
    assert len(found.triangles) == 12
    assert corners_of(found) == {(1.0 - y, 2.0 + 2.0 * x, 3.0 + 0.5 * z) for x, y, z in CUBE_CORNERS}


def test_what_has_no_surface_stays_out(bare: bpy.types.Scene) -> None:
    """A box of fog, and the faces of one slot; what gave nothing is none of the sources."""
    fog = material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter").outputs[0])
    paint = material("Paint", lambda new, _: node(new, "ShaderNodeBsdfDiffuse").outputs[0])
    solid, both, hazy = cube("Solid", paint), cube("Both", paint), cube("Hazy", fog)
    both.data.materials.append(fog)
    both.data.polygons[5].material_index = 1
    found = gathered(solid, both, hazy)
    assert len(found.triangles) == 12 + 10
    assert found.sources == ["Both", "Solid"]
    assert len(found.reports.lines()) == 2
    with pytest.raises(tyndall.InvalidInput, match='"Hazy" has no face'):
        gathered(hazy)


def test_modifiers_are_applied(bare: bpy.types.Scene) -> None:
    """What is seen, and not what is edited."""
    box = cube()
    array = box.modifiers.new("Array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (2.0, 0.0, 0.0)
    found = gathered(box)
    assert len(found.triangles) == 36
    assert found.positions_m.max(axis=0).tolist() == pytest.approx([9.0, 1.0, 1.0])


def test_instances_are_applied(bare: bpy.types.Scene) -> None:
    """Of a collection, by an empty that is chosen; the hidden original is not."""
    box = cube("Part")
    part = bpy.data.collections.new("Part")
    part.objects.link(box)
    bpy.context.scene.collection.objects.unlink(box)
    places = [(10.0, 0.0, 0.0), (0.0, 10.0, 0.0)]
    for place in places:
        empty = add("Instance", None, place)
        empty.instance_type, empty.instance_collection = "COLLECTION", part
    empties = [thing for thing in bpy.context.scene.objects if thing.type == "EMPTY"]
    expected = {tuple(np.add(corner, place).tolist()) for corner in CUBE_CORNERS for place in places}
    assert corners_of(gathered(*empties)) == expected
    assert len(gathered(empties[0]).triangles) == 12


def test_a_curve_is_taken_once(bare: bpy.types.Scene) -> None:
    """As the mesh that it evaluates to; the depsgraph lists it twice."""
    bpy.ops.curve.primitive_bezier_circle_add()
    circle = bpy.context.object
    circle.data.bevel_depth = 0.1
    evaluated = circle.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    evaluated.calc_loop_triangles()
    assert len(gathered(circle).triangles) == len(evaluated.loop_triangles) > 100


def test_what_has_no_face_is_named(bare: bpy.types.Scene) -> None:
    """Nothing is chosen, or nothing of it has a surface."""
    with pytest.raises(tyndall.InvalidInput, match='nothing to voxelize: "Camera" has no face'):
        gathered(bpy.data.objects["Camera"])
    with pytest.raises(tyndall.InvalidInput, match="nothing to voxelize: no object"):
        gathered()


def test_a_vertex_that_is_not_finite_is_named(bare: bpy.types.Scene) -> None:
    """With its object: numbers of one long list of triangles would help nobody."""
    cube("Good")
    bad = add("Bad", mesh("Bad", [*CUBE_CORNERS[:3], (float("nan"), 0.0, 0.0)], [(0, 1, 2), (1, 2, 3)]))
    with pytest.raises(tyndall.InvalidInput, match='object "Bad": vertex 3 is at \\[nan'):
        gathered(bpy.data.objects["Good"], bad)


# What colours them


def painted(name: str, picture: bpy.types.Image, *, tint: float = 1.0) -> bpy.types.Material:
    """A diffuse surface of an image times a grey."""

    def build(new: Callable[[str], bpy.types.Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
        texture, mix = new("ShaderNodeTexImage"), new("ShaderNodeMixRGB")
        texture.image = picture
        mix.blend_type = "MULTIPLY"
        mix.inputs["Fac"].default_value = 1.0
        mix.inputs["Color2"].default_value = (tint, tint, tint, 1.0)
        shader = new("ShaderNodeBsdfDiffuse")
        link(texture.outputs["Color"], mix.inputs["Color1"])
        link(mix.outputs["Color"], shader.inputs["Color"])
        return shader.outputs["BSDF"]

    return material(name, surface=build)


def test_a_surface_has_the_colour_of_its_material(bare: bpy.types.Scene) -> None:
    """Of each slot, and of each object that shares a mesh; none is grey."""
    green = material("Green", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0, 1, 0, 1)).outputs[0])
    red = material("Red", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(1, 0, 0, 1)).outputs[0])
    blue = material("Blue", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0, 0, 0.5, 1)).outputs[0])
    first = cube("First", red)
    first.data.materials.append(blue)
    first.data.polygons[5].material_index = 1
    second = add("Second", first.data)
    second.material_slots[0].link = "OBJECT"
    second.material_slots[0].material = green
    found = gathered(first, second, cube("Bare"))
    colours = np.array([colouring.texels[0, 0] for colouring in found.colourings])[found.colouring_of_triangle]
    assert (colours == [0, 0, 0.5]).all(axis=1).sum() == 4
    assert (colours == [1, 0, 0]).all(axis=1).sum() == (colours == [0, 1, 0]).all(axis=1).sum() == 10
    assert np.isclose(colours, 0.8).all(axis=1).sum() == 12
    assert not any(colouring.is_picture for colouring in found.colourings)


def test_a_picture_comes_with_what_nodes_do_to_it_and_where_it_lies(bare: bpy.types.Scene) -> None:
    """Texel by texel; UVs are those of each corner."""
    picture = bpy.data.images.new("Picture", 4, 2, float_buffer=True)
    texels = np.linspace(0.0, 1.0, 4 * 2 * 4, dtype=np.float32)
    texels[3::4] = 1.0
    picture.pixels.foreach_set(texels)
    flat = plane(material=painted("Painted", picture, tint=0.5))
    found = gathered(flat)
    (colouring,) = found.colourings
    assert np.allclose(colouring.texels, 0.5 * texels.reshape(2, 4, 4)[..., :3], atol=1e-6)
    corners = found.positions_m[found.triangles]
    layer = flat.data.uv_layers[0].data
    uv_of = {tuple(flat.data.vertices[loop.vertex_index].co): tuple(layer[loop.index].uv) for loop in flat.data.loops}
    for corner, uv in zip(corners.reshape(-1, 3).tolist(), found.corner_uvs.reshape(-1, 2).tolist(), strict=True):
        assert uv == pytest.approx(uv_of[tuple(corner)])


@pytest.mark.parametrize("scale", [(1.0, 2.0, 0.5), (-1.0, 2.0, 0.5)])
def test_normals_look_outwards_whatever_turns_scales_and_mirrors(
    bare: bpy.types.Scene, scale: tuple[float, ...]
) -> None:
    """Those of smooth corners, and the order of corners of flat ones."""
    bpy.ops.mesh.primitive_uv_sphere_add()
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    ball.scale, ball.rotation_euler, ball.location = scale, (0.3, 0.5, 0.7), (3.0, 4.0, 5.0)
    bpy.context.view_layer.update()
    found = gathered(ball)
    corners = found.positions_m[found.triangles]
    centre = np.array(ball.location)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", across, corners.mean(axis=1) - centre) > 0.0).all()
    # Of an ellipsoid, by the gradient of its equation.
    local = (
        np.array(ball.matrix_world.inverted()) @ np.append(corners.reshape(-1, 3), np.ones((corners.size // 3, 1)), 1).T
    )
    expected = (np.array(ball.matrix_world.inverted())[:3, :3].T @ local[:3]).T
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    assert np.allclose(np.linalg.norm(found.corner_normals, axis=2), 1.0, atol=1e-5)
    assert (np.einsum("ij,ij->i", found.corner_normals.reshape(-1, 3), expected) > 0.99).all()
