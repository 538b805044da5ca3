# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of a light's occluders: kept, undone, keyed and sent as the artist meant them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from support.occluder_edit_scenes import add_edits, curves, image, names, reports, sent, sun_over_cube
from support.small_scenes import CUBE_CORNERS, CUBE_FACES, cube, empty_scene, mesh
from tyndall.scene_description import EditKind, KernelShape, OccluderEdit

EDITS = "tyndall.occluder_edits"


@pytest.fixture
def sun() -> bpy.types.Light:
    return sun_over_cube()


def test_lengths_are_sent_in_metres_and_angles_in_radians(sun: bpy.types.Light) -> None:
    """One Blender unit is one metre, whatever the scene's unit scale says."""
    bpy.context.scene.unit_settings.scale_length = 0.01
    add_edits("HOLES")
    edit = sun.tyndall.occluder_edits[0]
    edit.size_m, edit.distance_m, edit.shape = 0.25, 7.0, "SQUARE"
    noise = edit.noise
    noise.scale_m, noise.octaves, noise.persistence, noise.probability = 2.5, 4, 0.25, 0.75
    noise.sway, noise.turn_rad, noise.seed = 1.5, math.pi / 2, 9
    (made,) = sent()
    assert made.name == "Make Holes"
    assert (made.kind, made.shape) == (EditKind.HOLES, KernelShape.SQUARE)
    assert (made.size_m, made.distance_m, made.objects, made.mask) == (0.25, 7.0, None, None)
    assert (made.noise.scale_m, made.noise.octaves, made.noise.persistence) == (2.5, 4, 0.25)
    assert (made.noise.probability, made.noise.sway, made.noise.seed) == (0.75, 1.5, 9)
    assert made.noise.turn_rad == pytest.approx(math.pi / 2)


def test_defaults_are_those_of_the_scene_description(sun: bpy.types.Light) -> None:
    """A new edit of holes has the noise that the core would take by itself."""
    add_edits("HOLES")
    expected = asdict(OccluderEdit(name="", kind=EditKind.HOLES).noise)
    assert asdict(sent()[0].noise) == pytest.approx(expected)


def test_edits_are_sent_in_their_order_without_those_that_are_off(sun: bpy.types.Light) -> None:
    """Closing eyes, moving and soloing change what is made, and in which order."""
    add_edits("CLOSE", "SILHOUETTE", "HOLES")
    assert [edit.kind for edit in sent()] == [EditKind.CLOSE, EditKind.SILHOUETTE, EditKind.HOLES]
    bpy.ops.tyndall.occluder_edit_move(direction="UP")
    assert [edit.kind for edit in sent()] == [EditKind.CLOSE, EditKind.HOLES, EditKind.SILHOUETTE]
    sun.tyndall.occluder_edits[0].is_enabled = False
    assert [edit.kind for edit in sent()] == [EditKind.HOLES, EditKind.SILHOUETTE]
    bpy.ops.tyndall.occluder_edit_solo(index=0)
    assert [edit.kind for edit in sent()] == [EditKind.CLOSE]
    bpy.ops.tyndall.occluder_edit_solo(index=0)
    assert [edit.kind for edit in sent()] == [EditKind.HOLES, EditKind.SILHOUETTE]


def test_a_light_that_no_air_scatters_keeps_what_surfaces_see(sun: bpy.types.Light) -> None:
    """The other edits shape shafts, and it draws none."""
    add_edits("CLOSE", "HOLES", "HOLES")
    sun.tyndall.scatters_in_media = False
    assert sent() == ()
    for edit in sun.tyndall.occluder_edits[:2]:
        edit.affects_surfaces = True
    assert [(edit.name, edit.affects_surfaces) for edit in sent()] == [("Fill Holes", True), ("Make Holes", True)]


@pytest.mark.parametrize("is_driven", [False, True])
def test_animated_values_are_those_of_the_frame(sun: bpy.types.Light, is_driven: bool) -> None:  # noqa: FBT001
    """The evaluated light knows them; the original one need not."""
    add_edits("CLOSE", "HOLES")
    noise = sun.tyndall.occluder_edits[1].noise
    if is_driven:
        noise.driver_add("turn_rad").driver.expression = "frame / 10"
    else:
        for frame, turn_rad in ((1, 0.1), (11, 1.1)):
            noise.turn_rad = turn_rad
            noise.keyframe_insert("turn_rad", frame=frame)
        for point in curves(sun)[f"{EDITS}[1].noise.turn_rad"].keyframe_points:
            point.interpolation = "LINEAR"
    for frame in (1, 4, 11):
        bpy.context.scene.frame_set(frame)
        assert sent()[1].noise.turn_rad == pytest.approx(frame / 10)
        assert sent()[0].noise.turn_rad == 0.0


def test_a_target_is_named_as_its_instances_are(sun: bpy.types.Light) -> None:
    """An object, a collection with one inside, an empty that instances: names of what is drawn, each once."""
    add_edits("CLOSE")
    edit = sun.tyndall.occluder_edits[0]
    edit.target, edit.target_object = "OBJECT", bpy.data.objects["Cube"]
    assert sent()[0].objects == ("Cube",)

    outer, inner, twig = (bpy.data.collections.new(name) for name in ("Outer", "Inner", "Twig"))
    bpy.context.scene.collection.children.link(outer)
    outer.children.link(inner)
    for name, collection in (("A", outer), ("B", inner), ("Leaf", twig)):
        collection.objects.link(bpy.data.objects.new(name, mesh(name, CUBE_CORNERS, CUBE_FACES)))
    empty = bpy.data.objects.new("Empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", twig
    inner.objects.link(empty)
    edit.target, edit.target_collection = "COLLECTION", outer
    assert sent()[0].objects == ("A", "B", "Leaf")
    edit.target_collection = twig  # is in the scene by its instances only
    assert sent()[0].objects == ("Leaf",)
    edit.target, edit.target_object = "OBJECT", empty
    assert sent()[0].objects == ("Leaf",)
    assert reports() == []


def test_instances_on_faces_and_of_particles_count_as_their_instancer(sun: bpy.types.Light) -> None:
    """Only the depsgraph knows them."""
    leaf = cube("Leaf")
    floor = bpy.data.objects["Plane"]
    add_edits("CLOSE")
    edit = sun.tyndall.occluder_edits[0]
    edit.target, edit.target_object = "OBJECT", floor
    leaf.parent, floor.instance_type = floor, "FACES"
    floor.show_instancer_for_render = floor.show_instancer_for_viewport = True
    assert sent()[0].objects == ("Leaf", "Plane")
    leaf.parent, floor.instance_type = None, "NONE"
    floor.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = floor.particle_systems[0].settings
    settings.type, settings.count, settings.render_type, settings.instance_object = "HAIR", 3, "OBJECT", leaf
    assert sent()[0].objects == ("Leaf", "Plane")


def test_a_mask_is_weighed_as_it_is_seen(sun: bpy.types.Light) -> None:
    """Rows bottom to top; display values, so that mid grey is the threshold; its width is in metres."""
    add_edits("CLOSE")
    edit = sun.tyndall.occluder_edits[0]
    values = np.array([[0.0, 0.2, 0.4], [0.6, 0.8, 1.0]])
    edit.mask_image, edit.mask_size_m = image("Mask", values), 12.0
    mask = sent()[0].mask
    assert (mask.name, mask.size_m, mask.values.dtype) == ("Mask", 12.0, np.float32)
    assert mask.values == pytest.approx(values, abs=0.5 / 255)
    edit.mask_channel = "ALPHA"
    assert (sent()[0].mask.values == 1.0).all()
    pixels = np.array(edit.mask_image.pixels).reshape(-1, 4)
    pixels[:, 3] = values.ravel()
    edit.mask_image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    assert sent()[0].mask.values == pytest.approx(values, abs=0.5 / 255)


def test_the_mask_of_a_float_image_stays_within_bounds(sun: bpy.types.Light) -> None:
    """What is not a number masks nothing in."""
    add_edits("CLOSE")
    made = bpy.data.images.new("Float", 2, 1, float_buffer=True)
    made.pixels.foreach_set(np.array([math.nan, math.nan, math.nan, 1, 9, 9, 9, 1], np.float32))
    sun.tyndall.occluder_edits[0].mask_image = made
    assert sent()[0].mask.values.tolist() == [[0.0, 1.0]]


# What cannot be made


def _no_object(edit: Any) -> None:
    edit.target = "OBJECT"


def _deleted_object(edit: Any) -> None:
    edit.target, edit.target_object = "OBJECT", bpy.data.objects["Cube"]
    bpy.data.objects.remove(bpy.data.objects["Cube"])


def _object_out_of_scene(edit: Any) -> None:
    edit.target, edit.target_object = "OBJECT", bpy.data.objects["Cube"]
    bpy.context.scene.collection.objects.unlink(bpy.data.objects["Cube"])


def _empty_collection(edit: Any) -> None:
    edit.target, edit.target_collection = "COLLECTION", bpy.data.collections.new("Nothing")
    bpy.context.scene.collection.children.link(edit.target_collection)


def _missing_image(edit: Any) -> None:
    edit.mask_image = bpy.data.images.new("Lost", 4, 4)
    edit.mask_image.source, edit.mask_image.filepath = "FILE", "//nowhere.png"


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (_no_object, "its object is not set, or deleted"),
        (_deleted_object, "its object is not set, or deleted"),
        (_object_out_of_scene, 'nothing of its object "Cube" is drawn'),
        (_empty_collection, 'its collection "Nothing" is empty'),
        (_missing_image, 'its mask, image "Lost", is missing or has no pixels (//nowhere.png)'),
    ],
)
def test_an_edit_that_cannot_be_made_is_left_out_by_name(
    sun: bpy.types.Light, damage: Callable[[Any], None], reason: str
) -> None:
    """One line names light, edit and culprit; the other edits are made."""
    add_edits("CLOSE", "HOLES")
    damage(sun.tyndall.occluder_edits[0])
    assert [edit.kind for edit in sent()] == [EditKind.HOLES]
    assert reports() == [f'Light "Sun", edit "Fill Holes": left out: {reason}']


# What is kept


def test_edits_survive_save_and_reload(sun: bpy.types.Light, tmp_path: Path) -> None:
    """Everything: numbers, pointers, order, the noise in its own group."""
    add_edits("CLOSE", "HOLES")
    first, second = sun.tyndall.occluder_edits
    first.target, first.target_object, first.order, second.order = "OBJECT", bpy.data.objects["Cube"], 1, 0
    second.noise.probability, second.mask_image = 0.125, image("Mask", np.ones((2, 2)))
    second.mask_image.pack()
    before = sent()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "edits.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "edits.blend"))
    after = sent()
    assert [edit.name for edit in after] == ["Make Holes", "Fill Holes"]
    assert after[1].objects == ("Cube",)
    assert after[0].noise == before[0].noise
    assert after[0].mask.values.tolist() == before[0].mask.values.tolist()


@pytest.fixture
def library(sun: bpy.types.Light, tmp_path: Path) -> Path:
    """A file whose sun has two edits, the second with a key; an empty scene is open."""
    add_edits("CLOSE", "HOLES")
    first, second = sun.tyndall.occluder_edits
    first.target, first.target_object = "OBJECT", bpy.data.objects["Cube"]
    second.noise.keyframe_insert("turn_rad", frame=1)
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    empty_scene()
    return path


def load(path: Path, *, link: bool) -> bpy.types.Object:
    with bpy.data.libraries.load(str(path), link=link) as (_there, here):
        here.objects = ["Sun"]
    bpy.context.scene.collection.objects.link(here.objects[0])
    return here.objects[0]


def test_an_appended_light_brings_its_edits_and_their_objects(library: Path) -> None:
    thing = load(library, link=False)
    bpy.context.scene.collection.objects.link(bpy.data.objects["Cube"])
    assert [(edit.name, edit.objects) for edit in sent()] == [("Fill Holes", ("Cube",)), ("Make Holes", None)]
    assert list(curves(thing.data)) == [f"{EDITS}[1].noise.turn_rad"]


def test_a_library_override_keeps_its_changes_and_its_own_edits(library: Path, tmp_path: Path) -> None:
    """A value, the order, an added edit; the list of a linked light cannot be changed, inherited edits not removed."""
    thing = load(library, link=True)
    bpy.context.view_layer.objects.active = thing
    assert not bpy.ops.tyndall.occluder_edit_add.poll()
    override = thing.override_create(remap_local_usages=True)
    override.data = thing.data.override_create(remap_local_usages=True)
    bpy.context.view_layer.objects.active = override
    settings = override.data.tyndall
    settings.occluder_edits[0].size_m = 3.0
    settings.active_occluder_edit = 1
    add_edits("SILHOUETTE")
    bpy.ops.tyndall.occluder_edit_move(direction="UP")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "override.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "override.blend"))
    data = bpy.context.view_layer.objects.active.data
    assert data.override_library is not None
    assert names(data) == ["Fill Holes", "Silhouettes", "Make Holes"]
    assert data.tyndall.occluder_edits["Fill Holes"].size_m == 3.0
    data.tyndall.active_occluder_edit = 0
    with pytest.raises(RuntimeError, match='"Fill Holes" comes from the library'):
        bpy.ops.tyndall.occluder_edit_remove()
    data.tyndall.active_occluder_edit = data.tyndall.occluder_edits.find("Silhouettes")
    assert bpy.ops.tyndall.occluder_edit_remove() == {"FINISHED"}
    assert names(data) == ["Fill Holes", "Make Holes"]
