# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sync makes of Blender's scene: everything that Cycles would draw, once, and where Blender puts it."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest

from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.small_scenes import (
    CUBE_CORNERS,
    CUBE_FACES,
    add,
    cube,
    empty_scene,
    light,
    material,
    mesh,
    node,
    placements,
    plane,
    read,
    red_green,
    world_positions,
)


def test_triangles_lie_where_blender_puts_them() -> None:
    """A rotated, mirrored and sheared child keeps its corners; the matrix is [row, column]."""
    empty_scene()
    parent, child = cube("Parent"), cube("Child")
    parent.scale, parent.rotation_euler = (1, 3, -0.5), (0.3, 0.2, 0.1)
    child.parent, child.location, child.rotation_euler = parent, (1, 2, 3), (0.5, 0.6, 0.7)
    (group,) = placements(read(), "Child")
    expected = [child.matrix_world @ vertex.co for vertex in child.data.vertices]
    assert world_positions(group)[0] == pytest.approx(np.array(expected), abs=1e-5)
    assert np.linalg.det(group.world_from_object[0][:3, :3]) < 0
    assert sorted(np.unique(group.mesh.triangles)) == list(range(len(CUBE_CORNERS)))


def test_quads_and_concave_polygons_become_triangles_of_the_same_area() -> None:
    """The polygon's material comes along, whatever the number of its triangles."""
    empty_scene()
    arrow = [(0, 0, 0), (2, 1, 0), (0, 2, 0), (1, 1, 0)]  # concave
    data = mesh("Shapes", [*arrow, (5, 0, 0), (6, 0, 0), (5, 1, 0)], [(0, 1, 2, 3), (4, 5, 6)])
    for one in red_green():
        data.materials.append(one)
    data.polygons[1].material_index = 1
    add("Shapes", data)
    (group,) = read().instances
    corners = group.mesh.positions[group.mesh.triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    assert areas[:2].sum() == pytest.approx(1.0)
    assert areas[2] == pytest.approx(0.5)
    assert group.mesh.material_slots.tolist() == [0, 0, 1]


def test_a_smooth_sphere_has_the_normals_of_a_sphere_and_a_flat_cube_has_none() -> None:
    empty_scene()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16)
    bpy.ops.object.shade_smooth()
    cube()
    sphere, box = (placements(read(), name)[0].mesh for name in ("Sphere", "Cube"))
    assert box.corner_normals is None
    assert sphere.corner_normals == pytest.approx(sphere.positions[sphere.triangles], abs=0.02)


def test_smooth_and_flat_polygons_of_one_mesh_keep_apart() -> None:
    """Flat corners carry the triangle's own normal, or zero, which means the same."""
    empty_scene()
    thing = cube()
    for neighbour in (0, 2):
        thing.data.polygons[neighbour].use_smooth = True
    (group,) = read().instances
    normals = group.mesh.corner_normals
    corners = group.mesh.positions[group.mesh.triangles]
    geometric = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    geometric /= np.linalg.norm(geometric, axis=1, keepdims=True)
    along = np.einsum("tci,ti->tc", normals, geometric)
    flat = np.all((along > 0.999) | ~normals.any(axis=2), axis=1)
    assert flat.sum() == 8, "four of six faces are flat"


def test_uv_maps_come_by_corner_the_active_one_first() -> None:
    empty_scene()
    thing = plane()
    second = thing.data.uv_layers.new(name="Second")
    for index, uv in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]):
        second.data[index].uv = uv
    second.active_render = True
    (group,) = read().instances
    assert [name for name, _ in group.mesh.uv_maps] == ["Second", "UV"]
    uvs = group.mesh.uv_maps[0][1]
    expected = group.mesh.positions[group.mesh.triangles][..., :2] / 20 + 0.5
    assert uvs == pytest.approx(expected)


def test_nested_collection_instances_are_each_drawn_once() -> None:
    """Two levels: 3 x 4 leaves, at the products of the matrices, beside the originals that are not in the scene."""
    empty_scene()
    leaf = bpy.data.objects.new("Leaf", mesh("Leaf", CUBE_CORNERS, CUBE_FACES))
    twig, tree = bpy.data.collections.new("Twig"), bpy.data.collections.new("Tree")
    twig.objects.link(leaf)
    for index in range(4):
        instancer = bpy.data.objects.new(f"Twig {index}", None)
        instancer.instance_type, instancer.instance_collection = "COLLECTION", twig
        instancer.location.x = index
        tree.objects.link(instancer)
    for index in range(3):
        instancer = add(f"Tree {index}", None, location=(0, 10 * index, 0))
        instancer.instance_type, instancer.instance_collection = "COLLECTION", tree
    (group,) = read().instances
    places = {tuple(matrix[:2, 3]) for matrix in group.world_from_object}
    assert places == {(x, y) for x in range(4) for y in (0, 10, 20)}
    assert len(group.object_names) == 12


def test_particles_are_drawn_once_and_their_hidden_original_is_not() -> None:
    empty_scene()
    leaf = cube("Leaf")
    leaf.hide_render = leaf.hide_viewport = True
    ground = plane()
    ground.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = ground.particle_systems[0].settings
    settings.type, settings.count, settings.render_type = "HAIR", 50, "OBJECT"
    settings.instance_object = leaf
    settings.use_advanced_hair = True
    description = read()
    assert sum(len(group.object_names) for group in placements(description, "Leaf")) == 50
    assert len(placements(description, "Plane")) == 1


def test_geometry_nodes_instance_objects_and_meshes_of_their_own() -> None:
    """On the four corners of a plane, each, beside the plane; and again, once Python has seen all of them."""
    empty_scene()
    leaf = cube("Leaf")
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    if hasattr(tree, "interface"):  # Blender 4.0 and later
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    new, link = tree.nodes.new, tree.links.new
    ground, result, join = new("NodeGroupInput"), new("NodeGroupOutput"), new("GeometryNodeJoinGeometry")
    leaves = node(new, "GeometryNodeObjectInfo", Object=leaf, As_Instance=True)
    for source in (leaves.outputs["Geometry"], new("GeometryNodeMeshCone").outputs["Mesh"]):
        instances = new("GeometryNodeInstanceOnPoints")
        link(ground.outputs[0], instances.inputs["Points"])
        link(source, instances.inputs["Instance"])
        link(instances.outputs[0], join.inputs[0])
    link(ground.outputs[0], join.inputs[0])
    link(join.outputs[0], result.inputs[0])
    plane().modifiers.new("Scatter", "NODES").node_group = tree
    for _ in range(2):
        drawn = sorted((len(group.mesh.positions), len(group.object_names)) for group in read().instances)
        assert drawn == [(4, 1), (8, 5), (33, 4)]


def test_a_curve_a_text_and_a_metaball_are_drawn_once() -> None:
    """They come as themselves and as the mesh that they evaluate to."""
    empty_scene()
    curve = bpy.data.curves.new("Curve", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.1
    curve.splines.new("POLY").points.add(1)
    curve.splines[0].points[1].co = (1, 0, 0, 1)
    add("Curve", curve)
    text = bpy.data.curves.new("Text", "FONT")
    text.body, text.extrude = "fog", 0.1
    add("Text", text)
    add("Bare curve", bpy.data.curves.new("Bare", "CURVE"))
    ball = bpy.data.metaballs.new("Ball")
    ball.elements.new()
    add("Ball", ball)
    names = sorted(name for group in read().instances for name in group.object_names)
    assert names == ["Ball", "Curve", "Text"]


def test_hidden_and_unseen_objects() -> None:
    """Not rendered: gone. Unseen by the camera, by light, by bounces or by mirrors: flags. By none: gone."""
    empty_scene()
    flags = {
        "Seen": (True, True, True, True),
        "Shadow": (False, True, True, True),
        "Bright": (True, False, True, True),
        "Card": (False, False, False, True),
        "Glow": (False, False, True, False),
        "None": (False, False, False, False),
    }
    for name, of_thing in flags.items():
        thing = cube(name)
        thing.visible_camera, thing.visible_shadow, thing.visible_diffuse, thing.visible_glossy = of_thing
    cube("Hidden").hide_viewport = True
    found = {
        group.object_names[0]: (
            *(group.is_camera_visible, group.casts_shadow),
            *(group.is_bounce_visible, group.is_mirror_visible),
        )
        for group in read().instances
    }
    assert found == {name: flag for name, flag in flags.items() if any(flag)}
    indirect = bpy.context.scene.tyndall.indirect
    indirect.has_mirrors = indirect.has_refraction = True
    bpy.data.objects["Glow"].visible_transmission = False
    seen_through_glass = {group.object_names[0]: group.is_glass_visible for group in read().instances}
    assert seen_through_glass == {name: name != "Glow" for name in flags}


def test_an_instancer_passes_its_visibility_on() -> None:
    empty_scene()
    leaf = bpy.data.objects.new("Leaf", mesh("Leaf", CUBE_CORNERS, CUBE_FACES))
    collection = bpy.data.collections.new("Twig")
    collection.objects.link(leaf)
    for name in ("Seen", "Unseen"):
        instancer = add(name, None)
        instancer.instance_type, instancer.instance_collection = "COLLECTION", collection
        instancer.visible_camera = name == "Seen"
    assert sorted(group.is_camera_visible for group in read().instances) == [False, True]


def test_materials_may_be_linked_to_the_object() -> None:
    """Two objects share a mesh, and so its arrays, but not their material."""
    empty_scene()
    red, green = red_green()
    first = cube("First", red)
    second = add("Second", first.data)
    second.material_slots[0].link = "OBJECT"
    second.material_slots[0].material = green
    add("Third", mesh("Bare", CUBE_CORNERS, CUBE_FACES))
    description = read()
    names = {group.object_names[0]: description.materials[group.materials[0]].name for group in description.instances}
    assert names == {"First": "Red", "Second": "Green", "Third": "no material"}
    assert placements(description, "First")[0].mesh is placements(description, "Second")[0].mesh


def test_modifiers_count() -> None:
    empty_scene()
    thing = cube()
    thing.modifiers.new("Array", "ARRAY").count = 3
    assert len(read().instances[0].mesh.triangles) == 3 * 12


def test_the_last_subdivision_counts_though_a_window_may_leave_it_to_its_graphics_card() -> None:
    empty_scene()
    thing = cube()
    thing.modifiers.new("Subdivision", "SUBSURF").levels = 2
    assert len(read().instances[0].mesh.triangles) == 6 * 4**2 * 2


def test_a_mesh_that_is_being_edited_is_read_whole() -> None:
    """A file may be saved in Edit Mode, and a window shows what is edited: counts are there, attributes are not."""
    empty_scene()
    thing = cube("Edited")
    thing.data.uv_layers.new(name="Map")
    thing.data.color_attributes.new("Tint", "BYTE_COLOR", "CORNER")
    thing.data.polygons.foreach_set("use_smooth", [True] * 6)
    bpy.context.view_layer.objects.active = thing
    (expected,) = placements(read(), "Edited")
    bpy.ops.object.mode_set(mode="EDIT")
    for is_live in (False, True):
        (found,) = placements(read(is_live=is_live), "Edited")
        assert [name for name, _ in found.mesh.uv_maps] == [name for name, _ in expected.mesh.uv_maps]
        for (_, values), (_, whole) in zip(found.mesh.uv_maps, expected.mesh.uv_maps, strict=True):
            assert np.array_equal(values, whole)
        assert np.array_equal(found.mesh.positions, expected.mesh.positions)
        assert np.allclose(found.mesh.corner_normals, expected.mesh.corner_normals, atol=1e-6)
    bpy.ops.object.mode_set(mode="OBJECT")


def test_damaged_meshes_do_no_harm() -> None:
    """NaN goes through, for the native side to drop and count; a mesh without a face is not drawn."""
    empty_scene()
    broken = cube("Broken")
    broken.data.vertices[0].co.x = math.nan
    add("Points", mesh("Points", [(0, 0, 0)], []))
    add("Empty", mesh("Empty", [], []))
    (group,) = read().instances
    assert np.isnan(group.mesh.positions).sum() == 1


def test_scale_length_means_nothing() -> None:
    """One Blender unit is one metre always, as in Cycles."""
    scene = empty_scene()
    cube()
    light("POINT", (0, 0, 2))
    before = read()
    scene.unit_settings.scale_length = 0.01
    after = read()
    assert after.lights[0].strength == before.lights[0].strength
    assert np.array_equal(after.instances[0].world_from_object, before.instances[0].world_from_object)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_a_stop_is_heard_between_objects(kind: str) -> None:
    """``poll`` may raise; the reader is as good as before."""
    scene, reader = empty_scene(), SceneReader()
    scene.camera.data.type = kind
    for index in range(5):
        cube(f"Cube {index}")

    class Stop(Exception):  # noqa: N818  what a caller raises is its own affair
        pass

    def stop() -> None:
        raise Stop

    with pytest.raises(Stop):
        reader.read(bpy.context.evaluated_depsgraph_get(), Reports(), stop)
    assert len(read(reader).instances) == 5


def test_a_view_layer_replaces_materials_and_the_world() -> None:
    """Its material is in every slot, fog boxes included; without "Environment" there is no world."""
    scene = empty_scene()
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    red, green = red_green()
    cube(material=red)
    layer = scene.view_layers[0]
    layer.material_override = green
    layer.use_sky = False
    description = read()
    assert [one.name for one in description.materials] == ["Green"]
    assert description.world.radiance == (0, 0, 0)


def test_a_view_layer_without_surfaces_keeps_its_lights() -> None:
    scene = empty_scene()
    cube()
    light("POINT", (0, 0, 2))
    scene.view_layers[0].use_solid = False
    description = read()
    assert not description.instances
    assert len(description.lights) == 1


def test_a_fog_box_hidden_from_the_camera_is_named() -> None:
    """In Cycles it would only dim light; here it is there for all rays or for none."""
    empty_scene()
    fog = cube("Fog", material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter").outputs[0]))
    assert not read().reports
    fog.visible_camera = False
    (line,) = read().reports
    assert "Fog" in line
    assert "visibility" in line
