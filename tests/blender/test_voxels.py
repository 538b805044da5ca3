# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxels in Blender: what of a scene becomes them, the object that stands for them, and their files."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Vector

import tyndall
from addon import panels
from addon.amounts import bytes_text
from addon.operators.voxel_files import TYNDALL_OT_import_tdag
from addon.operators.voxelize import _plan
from addon.sync.voxel_meshes import VoxelMesh
from addon.voxel_boxes import file_of
from addon.voxel_preview import preview_of
from addon.voxel_reading import header_of
from support.engine_pictures import tyndall_pixels
from support.recording_layout import drawn
from support.small_scenes import CUBE_CORNERS, CUBE_FACES, add, cube, empty_scene, material, mesh, node, plane
from tyndall.blender.voxel_meshes import gather
from tyndall.volumes import grid_infos
from tyndall.voxel_dag import Config, extent_of, from_coordinates, load, out_of_core, voxelize


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


# What becomes voxels


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


# The operator


@pytest.fixture
def saved(bare: bpy.types.Scene, tmp_path: Path) -> bpy.types.Scene:
    """A file on disk, with a cube of 2 m that is selected, and small voxels."""
    box = cube("Block")
    box.location = (5.0, 0.0, 0.0)
    select(box)
    bare.tyndall.voxelize.resolution = "16"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    return bpy.context.scene


def select(*things: bpy.types.Object) -> None:
    bpy.context.view_layer.update()  # which still lists what was removed
    for other in bpy.context.view_layer.objects:
        other.select_set(other in things)
    bpy.context.view_layer.objects.active = things[0] if things else None


def voxels_in_world(box: bpy.types.Object) -> np.ndarray:
    """Lower and upper corner of all its voxels, (2, 3)."""
    dag = load(file_of(box))
    found = np.concatenate(list(dag.coordinates()))
    size_m = (dag.bounds_m[1] - dag.bounds_m[0]) / dag.resolution
    ends = dag.bounds_m[0] + np.array([found.min(axis=0), found.max(axis=0) + 1]) * size_m
    return np.array([box.matrix_world @ Vector(end) for end in ends])


@pytest.mark.parametrize("rule", ["THIN", "CONSERVATIVE"])
def test_an_object_stands_for_the_voxels_where_the_mesh_was(saved: bpy.types.Scene, rule: str) -> None:
    """Its box is the file's cube; the path is relative; the mesh is hidden, and the new object is active."""
    saved.tyndall.voxelize.rule = rule
    assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
    box = bpy.context.object
    assert box.name == "Block Voxels"
    assert box.tyndall_voxels.path == "//Block_Voxels.tdag"
    assert np.allclose(voxels_in_world(box), [(4.0, -1.0, -1.0), (6.0, 1.0, 1.0)])
    assert np.allclose(sorted(map(tuple, (box.matrix_world @ v.co for v in box.data.vertices))), expected_corners())
    assert len(box.data.edges) == 12
    assert len(box.data.polygons) == 0
    source = bpy.data.objects["Block"]
    assert source.hide_get()
    assert source.hide_render
    dag = load(file_of(box))
    expected = voxelize(*cube_at_origin(), Config(resolution=16, rule=rule.lower()))
    assert np.array_equal(np.concatenate(list(dag.coordinates())), np.concatenate(list(expected.coordinates())))


def expected_corners() -> list[tuple[float, ...]]:
    return sorted((5.0 + x, float(y), float(z)) for x, y, z in CUBE_CORNERS)


def cube_at_origin() -> tuple[np.ndarray, np.ndarray]:
    triangles = [corners for a, b, c, d in CUBE_FACES for corners in ((a, b, c), (a, c, d))]
    return np.array(CUBE_CORNERS, float), np.array(triangles)


def test_voxels_keep_the_colours_and_normals_of_the_surface(saved: bpy.types.Scene) -> None:
    """Of each face its own; without them, the file has none."""
    block = bpy.data.objects["Block"]
    for colour in ((1, 0, 0, 1), (0, 0, 1, 1)):
        made = material("Paint", lambda new, _, c=colour: node(new, "ShaderNodeBsdfDiffuse", Color=c).outputs[0])
        block.data.materials.append(made)
    block.data.polygons[5].material_index = 1  # the top
    saved.tyndall.voxelize.has_normals = True
    bpy.ops.tyndall.voxelize()
    dag = load(file_of(bpy.context.object))
    middles = [[8, 8, 15], [8, 8, 0], [0, 8, 8], [15, 8, 8]]
    assert dag.colors_at(middles).tolist() == [[0, 0, 255], [255, 0, 0], [255, 0, 0], [255, 0, 0]]
    assert np.allclose(dag.normals_at(middles), [[0, 0, 1], [0, 0, -1], [-1, 0, 0], [1, 0, 0]], atol=0.02)
    saved.tyndall.voxelize.has_colors = saved.tyndall.voxelize.has_normals = False
    block.hide_set(False)
    select(block)
    bpy.ops.tyndall.voxelize()
    dag = load(file_of(bpy.context.object))
    assert not dag.has_colors
    assert not dag.has_normals
    assert [made.name for made in bpy.context.object.data.materials] == ["Paint"]


def test_coloured_voxels_look_as_what_they_stand_for(tmp_path: Path) -> None:
    """Their colours are those of the surface, and not multiplied by its material once more."""
    scene = empty_scene()
    paint = material("Paint", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.2, 0.4, 0.6, 1)).outputs[0])
    flat = plane(material=paint)
    sun = bpy.data.lights.new("Sun", "SUN")
    add("Sun", sun, location=(0, 0, 5))
    before = tyndall_pixels(scene)[..., :3]
    select(flat)
    scene.tyndall.voxelize.resolution, scene.tyndall.voxelize.path = "64", str(tmp_path / "flat.tdag")
    bpy.ops.tyndall.voxelize()
    assert before.min() > 0.05
    assert np.allclose(tyndall_pixels(scene)[..., :3], before, rtol=0.02)


def test_a_solid_is_filled(saved: bpy.types.Scene) -> None:
    """All of the cube; an open mesh is refused."""
    saved.tyndall.voxelize.is_solid = True
    bpy.ops.tyndall.voxelize()
    assert load(file_of(bpy.context.object)).voxel_count == 16**3
    flat = plane()
    select(flat)
    with pytest.raises(RuntimeError, match="edge"):
        bpy.ops.tyndall.voxelize()


def test_a_collection_becomes_voxels_together(saved: bpy.types.Scene) -> None:
    """Whatever is selected; around the middle of all of it."""
    both = bpy.data.collections.new("Both")
    saved.collection.children.link(both)
    other = cube("Other")
    other.location = (-5.0, 0.0, 0.0)
    for thing in (bpy.data.objects["Block"], other):
        both.objects.link(thing)
    select()
    saved.tyndall.voxelize.collection = both
    saved.tyndall.voxelize.hides_sources = False
    assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
    box = bpy.context.object
    assert box.name == "Both Voxels"
    assert tuple(box.location) == (0.0, 0.0, 0.0)
    assert np.allclose(voxels_in_world(box), [(-6.0, -1.0, -1.0), (6.75, 1.25, 1.25)], atol=0.76)
    assert not other.hide_get()


def test_files_are_not_written_over_unless_one_is_chosen(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """A second run gets a number; a chosen path is taken, with the suffix that it lacks."""
    saved.tyndall.voxelize.hides_sources = False
    for _ in range(2):
        select(bpy.data.objects["Block"])
        bpy.ops.tyndall.voxelize()
    saved.tyndall.voxelize.path = "//chosen"
    for _ in range(2):
        select(bpy.data.objects["Block"])
        bpy.ops.tyndall.voxelize()
    names = {"Block_Voxels.tdag", "Block_Voxels_002.tdag", "chosen.tdag"}
    assert {path.name for path in tmp_path.glob("*.tdag")} == names


def test_what_cannot_be_done_is_said_and_nothing_is_left(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """Nothing selected, nothing with faces, vertices without end, no room, no folder."""
    settings = saved.tyndall.voxelize
    things = len(bpy.data.objects)
    select()
    with pytest.raises(RuntimeError, match="Select what becomes voxels"):
        bpy.ops.tyndall.voxelize()
    select(bpy.data.objects["Camera"])
    with pytest.raises(RuntimeError, match='"Camera" has no face'):
        bpy.ops.tyndall.voxelize()
    block = bpy.data.objects["Block"]
    select(block)
    settings.resolution, settings.memory_budget_mib, settings.is_solid = "131072", 16, True
    with pytest.raises(RuntimeError, match=r"of which \d+ fit the budget: allow more memory or choose a smaller"):
        bpy.ops.tyndall.voxelize()
    settings.resolution, settings.memory_budget_mib, settings.is_solid = "16", 4096, False
    (tmp_path / "taken").write_text("a file, and no folder")
    settings.path = "//taken/voxels.tdag"
    with pytest.raises(RuntimeError, match=r"taken: no folder to write to \(File exists\)"):
        bpy.ops.tyndall.voxelize()
    settings.path = ""
    corners = np.array(CUBE_CORNERS, np.float32)
    corners[2, 0] = np.nan
    block.data.vertices.foreach_set("co", corners.ravel())
    block.data.update()
    with pytest.raises(RuntimeError, match='object "Block": vertex 2'):
        bpy.ops.tyndall.voxelize()
    assert not list(tmp_path.glob("*.tdag"))
    assert len(bpy.data.objects) == things


@pytest.mark.dealt
def test_what_is_beyond_the_memory_is_made_in_parts(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """The same file, byte for byte; the parts are gone. A solid is refused, with what would fit."""
    settings = saved.tyndall.voxelize
    settings.resolution, settings.hides_sources = "1024", False
    files = []
    for budget_mib in (4096, 64):
        settings.memory_budget_mib = budget_mib
        select(bpy.data.objects["Block"])
        assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
        files.append(file_of(bpy.context.object))
    assert files[0].read_bytes() == files[1].read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "Block_Voxels.tdag",
        "Block_Voxels_002.tdag",
        "scene.blend",
    ]


@pytest.mark.parametrize("is_solid", [False, True])
@pytest.mark.parametrize(("budget_mib", "is_in_parts"), [(4096, False), (4, True)])
def test_the_dialog_says_how_it_is_made(
    saved: bpy.types.Scene, budget_mib: int, *, is_in_parts: bool, is_solid: bool
) -> None:
    """Before it begins."""
    settings = saved.tyndall.voxelize
    settings.is_solid = is_solid
    settings.resolution, settings.has_colors, settings.memory_budget_mib = "1024", False, budget_mib
    plan = _plan(extent_of(*cube_at_origin()), settings)
    assert plan.is_in_parts == is_in_parts
    assert ("in parts" in plan.says) == is_in_parts


def test_a_run_that_was_stopped_goes_on_from_its_parts(
    saved: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They lie beside where the file goes, under the same name as long as there is none."""
    settings = saved.tyndall.voxelize
    settings.resolution, settings.has_colors, settings.memory_budget_mib = "1024", False, 4
    select(bpy.data.objects["Block"])

    def stopped(native: object, _path: Path, progress: tyndall.Progress) -> None:
        native.make_part(0, progress)
        raise tyndall.Cancelled

    class Stopping:
        def __init__(self, native: object) -> None:
            self.finish = lambda path, progress: stopped(native, path, progress)

    whole = out_of_core.parts_of
    monkeypatch.setattr(out_of_core, "parts_of", lambda *given, **named: Stopping(whole(*given, **named)))
    assert bpy.ops.tyndall.voxelize() == {"CANCELLED"}
    (part,) = [path for path in tmp_path.rglob("*") if path.is_file() and path.name != "scene.blend"]
    time_ns = part.stat().st_mtime_ns
    monkeypatch.setattr(
        out_of_core,
        "parts_of",
        lambda *given, **named: (times.append(part.stat().st_mtime_ns), whole(*given, **named))[1],
    )
    times: list[int] = []
    assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
    assert times == [time_ns]
    assert not part.exists()


def test_an_unsaved_file_asks_where_the_voxels_go(bare: bpy.types.Scene, tmp_path: Path) -> None:
    """Nobody would look for them in the folder that Blender was started in."""
    select(cube())
    bare.tyndall.voxelize.resolution = "16"
    with pytest.raises(RuntimeError, match=r"Save the \.blend first, or choose a file"):
        bpy.ops.tyndall.voxelize()
    bare.tyndall.voxelize.path = str(tmp_path / "voxels.tdag")
    bpy.ops.tyndall.voxelize()
    assert bpy.context.object.tyndall_voxels.path == str(tmp_path / "voxels.tdag")


# Files


def proposed_import() -> Path:
    """What the file browser begins with."""
    return TYNDALL_OT_import_tdag.default_path(None, bpy.context)


def test_a_file_is_imported_and_read_anew(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """An object with the file's cube; after the file has changed, with its new one. A damaged file is named."""
    path = tmp_path / "made.tdag"
    assert proposed_import() == tmp_path / "voxels.tdag"
    voxels = [[0, 0, 0], [15, 15, 15]]
    from_coordinates(voxels, Config(resolution=16, bounds_m=[[1, 2, 3], [2, 3, 4]])).save(path)
    assert proposed_import() == path
    assert bpy.ops.tyndall.import_tdag(filepath=str(path)) == {"FINISHED"}
    box = bpy.context.object
    assert (box.name, box.tyndall_voxels.path) == ("made", "//made.tdag")
    assert np.allclose(voxels_in_world(box), [(1, 2, 3), (2, 3, 4)])
    from_coordinates(voxels, Config(resolution=64, bounds_m=[[0, 0, 0], [8, 8, 8]])).save(path)
    assert bpy.ops.tyndall.reload_voxels() == {"FINISHED"}
    assert np.allclose(sorted(tuple(v.co) for v in box.data.vertices), sorted(itertools.product((0, 8), repeat=3)))
    assert header_of(path).resolution == 64
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(RuntimeError, match=r"made\.tdag"):
        bpy.ops.tyndall.import_tdag(filepath=str(path))
    with pytest.raises(RuntimeError, match=r"made\.tdag"):
        bpy.ops.tyndall.reload_voxels()


@pytest.fixture
def two_voxels(saved: bpy.types.Scene, tmp_path: Path) -> bpy.types.Object:
    """Of 0.25 m, in opposite corners of a cube of 2 m; red and blue; turned and moved, with a material."""
    colors = np.array([[255, 0, 0], [0, 0, 255]], np.uint8)
    config = Config(resolution=8, bounds_m=[[0, 0, 0], [2, 2, 2]], colors=colors)
    from_coordinates([[0, 0, 0], [7, 7, 7]], config).save(tmp_path / "two.tdag")
    bpy.ops.tyndall.import_tdag(filepath=str(tmp_path / "two.tdag"))
    box = bpy.context.object
    box.location, box.rotation_euler = (1.0, 2.0, 3.0), (0.1, 0.2, 0.3)
    box.data.materials[0] = bpy.data.materials.new("Clay")
    bpy.context.view_layer.update()
    return box


@pytest.mark.parametrize(("level", "side_m"), [(3, 0.25), (2, 0.5), (17, 0.25)])
def test_voxels_become_a_mesh_where_they_are(two_voxels: bpy.types.Object, level: int, side_m: float) -> None:
    """Closed boxes with the box's material and their own colours; coarser ones fill their cubes."""
    assert bpy.ops.tyndall.voxels_to_mesh(level=level) == {"FINISHED"}
    thing = bpy.context.object
    corners = sorted(tuple(vertex.co) for vertex in thing.data.vertices)
    first, second = np.array(list(itertools.product((0.0, side_m), repeat=3))), 2.0 - side_m
    assert np.allclose(corners, sorted(map(tuple, [*first, *(first + second)])))
    assert np.allclose(thing.matrix_world, two_voxels.matrix_world)
    assert [material.name for material in thing.data.materials] == ["Clay"]
    assert len(thing.data.polygons) == 24
    assert not any(polygon.use_smooth for polygon in thing.data.polygons)
    assert not thing.data.validate()
    for polygon in thing.data.polygons:
        middle = np.mean(first, axis=0) + (second if polygon.center.x > 1.0 else 0.0)
        assert polygon.normal.dot(polygon.center - Vector(middle)) > 0.0
        colour = thing.data.color_attributes[0].data[polygon.loop_start].color
        assert tuple(colour) == ((0, 0, 1, 1) if polygon.center.x > 1.0 else (1, 0, 0, 1))


def test_a_smooth_mesh_is_one_of_openvdb(two_voxels: bpy.types.Object) -> None:
    """Rounded, around the same voxels."""
    assert bpy.ops.tyndall.voxels_to_mesh(kind="SMOOTH") == {"FINISHED"}
    data = bpy.context.object.data
    corners = np.array([vertex.co for vertex in data.vertices])
    assert len(corners) > 8
    assert all(polygon.use_smooth for polygon in data.polygons)
    assert (corners.min(axis=0) > -0.1).all()
    assert (corners.max(axis=0) < 2.1).all()
    assert not np.isin(corners, (0.0, 0.25, 1.75, 2.0)).all()


@pytest.mark.parametrize(("kind", "name"), [("FOG", "density"), ("LEVEL SET", "surface")])
def test_voxels_become_a_grid_of_openvdb(two_voxels: bpy.types.Object, tmp_path: Path, kind: str, name: str) -> None:
    """With their colours, beside their own file, unless another is named."""
    assert bpy.ops.tyndall.export_voxels_vdb(kind=kind) == {"FINISHED"}
    assert [info.name for info in grid_infos(tmp_path / "two.vdb")] == [name, "color"]
    bpy.ops.tyndall.export_voxels_vdb(kind=kind, filepath=str(tmp_path / "other"))
    assert (tmp_path / "other.vdb").is_file()


def test_a_magicavoxel_file_goes_out_and_comes_in(two_voxels: bpy.types.Object, tmp_path: Path) -> None:
    """With its colours; a damaged one is named, and no file is made of it."""
    assert bpy.ops.tyndall.export_voxels_vox() == {"FINISHED"}
    assert bpy.ops.tyndall.import_vox(filepath=str(tmp_path / "two.vox"), voxel_size_m=0.25) == {"FINISHED"}
    box = bpy.context.object
    assert box.tyndall_voxels.path == "//two_002.tdag"
    dag = load(file_of(box))
    voxels = np.concatenate(list(dag.coordinates()))
    assert dag.colors_at(voxels).tolist() == [[255, 0, 0], [0, 0, 255]]
    assert np.ptp(voxels_in_world(box), axis=0) == pytest.approx([2.0, 2.0, 2.0])
    (tmp_path / "two.vox").write_bytes((tmp_path / "two.vox").read_bytes()[:50])
    with pytest.raises(RuntimeError, match=r"two\.vox"):
        bpy.ops.tyndall.import_vox(filepath=str(tmp_path / "two.vox"))
    assert len(list(tmp_path.glob("*.tdag"))) == 2


# Panels and previews


def test_the_panel_says_what_a_file_holds(saved: bpy.types.Scene) -> None:
    """Voxels, nodes, bytes of the parts and all of them, against an octree and raw; a row for each level."""
    bpy.ops.tyndall.voxelize()
    dag = load(file_of(bpy.context.object))
    shown = " ".join(drawn(panels.voxels.TYNDALL_PT_voxel_box))
    for text in ("Resolution 16", f"Voxels {dag.voxel_count:,}", f"Distinct nodes {dag.node_count}"):
        assert text in shown
    of_bytes = " ".join(drawn(panels.voxels.TYNDALL_PT_voxel_bytes))
    assert f"All {bytes_text(dag.geometry_bytes + dag.attribute_bytes)}" in of_bytes
    of_levels = drawn(panels.voxels.TYNDALL_PT_voxel_levels)
    assert [of_levels[row] for row in (1, 4, 7)] == ["16", "8", "4"]
    octree = 4 * sum(level.tree_node_count for level in dag.levels())
    for name, ratio, shown in (
        ("An octree, 4 bytes per node", octree, " ".join(of_levels)),
        ("Raw, a bit per voxel of the cube", 16**3 / 8, of_bytes),
    ):
        assert f"{name} {ratio / dag.geometry_bytes:.3g} x" in shown.replace("  ", " ")


def test_the_panel_says_what_is_wrong_with_a_file(saved: bpy.types.Scene) -> None:
    """One that is gone is named."""
    bpy.ops.tyndall.voxelize()
    file_of(bpy.context.object).unlink()
    for panel in (panels.voxels.TYNDALL_PT_voxel_box, panels.voxels.TYNDALL_PT_voxel_bytes):
        assert "Block_Voxels.tdag" in " ".join(drawn(panel)).replace(" ", "")


def test_a_preview_reads_no_more_of_a_large_file_than_it_shows(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """Where all behind the topmost levels is damaged, these are shown with their colours; finer ones are refused."""
    path = tmp_path / "noise.tdag"
    voxels = np.random.default_rng(3).integers(0, 256, (50_000, 3))
    dag = from_coordinates(voxels, Config(resolution=256, colors=voxels.astype(np.uint8)))
    dag.save(path)
    bpy.ops.tyndall.import_tdag(filepath=str(path))
    box = bpy.context.object
    content = bytearray(path.read_bytes())
    content[-200_000:] = bytes(200_000)
    path.write_bytes(content)
    box.tyndall_voxels.preview, box.tyndall_voxels.preview_level = "POINTS", 3
    found = preview_of(box)
    cubes, _level = dag.coarse_cubes(3, 10**6)
    assert len(found.parts_m[0]) == len(cubes) == 8**3
    assert np.array_equal(found.colours[0], dag.colors_at(cubes * 32, level=3))
    assert f"Voxels {dag.voxel_count:,}" in " ".join(drawn(panels.voxels.TYNDALL_PT_voxel_box))
    box.tyndall_voxels.preview_level = 7
    assert "noise.tdag" in str(preview_of(box))
    with pytest.raises(RuntimeError, match=r"noise\.tdag"):
        bpy.ops.tyndall.reload_voxels()


@pytest.mark.parametrize("style", ["POINTS", "BLOCKS"])
def test_a_preview_lies_where_the_voxels_lie(saved: bpy.types.Scene, style: str) -> None:
    """Points in the middle of voxels, blocks to their ends; as coarse as asked."""
    bpy.ops.tyndall.voxelize()
    box = bpy.context.object
    box.tyndall_voxels.preview, box.tyndall_voxels.preview_level = style, 3
    found = preview_of(box)
    corners = np.concatenate([part.reshape(-1, 3) for part in found.parts_m])
    inset = 0.125 if style == "POINTS" else 0.0
    assert np.allclose([corners.min(axis=0), corners.max(axis=0)], [[-1 + inset] * 3, [1 - inset] * 3])
    if style == "POINTS":
        assert len(corners) == 8**3 - 6**3
    else:
        assert [len(part) for part in found.parts_m] == [8 * 8 + 6 * 6] * 6


@pytest.mark.parametrize("style", ["POINTS", "BLOCKS"])
def test_a_preview_has_the_mean_colours_of_its_level(saved: bpy.types.Scene, tmp_path: Path, style: str) -> None:
    """Of red and blue in one cube, as light; green is alone in another one. Without colours it has the object's."""
    voxels = [[0, 0, 0], [1, 1, 0], [7, 7, 7]]
    colors = np.array([[255, 0, 0], [0, 0, 255], [0, 255, 0]], np.uint8)
    made = from_coordinates(voxels, Config(resolution=8, colors=colors))
    bare = from_coordinates(voxels, Config(resolution=8))
    for dag, name in ((made, "made.tdag"), (bare, "bare.tdag")):
        dag.save(tmp_path / name)
        bpy.ops.tyndall.import_tdag(filepath=str(tmp_path / name))
        box = bpy.context.object
        box.tyndall_voxels.preview, box.tyndall_voxels.preview_level = style, 2
        found = preview_of(box)
        assert (found.colours is None) == (dag is bare)
        for part_m, colours in zip(found.parts_m, found.colours or [], strict=dag is made):
            is_far = part_m.reshape(len(colours), -1).mean(axis=1) > 4.0
            assert is_far.tolist() == [False, True]
            assert np.abs(colours.astype(int) - [[188, 0, 188], [0, 255, 0]]).max() <= 1
