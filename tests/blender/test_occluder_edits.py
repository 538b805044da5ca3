# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of a light's occluders: kept, undone, keyed and sent as the artist meant them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from addon.animation_paths import path_without_item
from addon.edited_light import is_light_of_scene
from addon.item_lists import in_order
from addon.panels import occluder_edits
from addon.sync.scene import SceneReader
from support.recording_layout import drawn
from support.small_scenes import CUBE_CORNERS, CUBE_FACES, add, cube, empty_scene, light, mesh, plane, read
from tyndall import Progress
from tyndall.renderer import Session
from tyndall.scene_description import EditKind, KernelShape, OccluderEdit

EDITS = "tyndall.occluder_edits"


@pytest.fixture
def sun() -> bpy.types.Light:
    """The active light of a scene with a cube on a floor."""
    empty_scene()
    cube()
    plane()
    thing = light("SUN", (0, 0, 5))
    bpy.context.view_layer.objects.active = thing
    return thing.data


def add_edits(*kinds: str) -> None:
    for kind in kinds:
        assert bpy.ops.tyndall.occluder_edit_add(kind=kind) == {"FINISHED"}


def names(owner: bpy.types.Light) -> list[str]:
    return [edit.name for edit in in_order(owner.tyndall.occluder_edits)]


def sent(light_name: str = "Sun") -> tuple[OccluderEdit, ...]:
    (description,) = [one for one in read().lights if one.name == light_name]
    return description.occluder_edits


def reports() -> list[str]:
    return [line for line in read().reports if "edit" in line]


def image(name: str, values: np.ndarray) -> bpy.types.Image:
    """Grey and opaque, from (height, width) display values."""
    made = bpy.data.images.new(name, values.shape[1], values.shape[0], alpha=True)
    pixels = np.ones((*values.shape, 4), np.float32)
    pixels[..., :3] = values[..., None]
    made.pixels.foreach_set(pixels.ravel())
    return made


def curves(owner: bpy.types.ID) -> dict[str, bpy.types.FCurve]:
    """By path; of the layers of an action since 4.4."""
    animation = owner.animation_data
    if not getattr(animation.action, "is_action_layered", False):
        found = list(animation.action.fcurves)
    else:
        strips = (strip for layer in animation.action.layers for strip in layer.strips)
        bags = (strip.channelbag(animation.action_slot) for strip in strips)
        found = [curve for bag in bags if bag for curve in bag.fcurves]
    return {curve.data_path: curve for curve in found}


# What is sent


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


# Keys and drivers


def keyed(sun: bpy.types.Light) -> None:
    """Three edits; the second has a key at 2 m, the third one at 3 m and a driver."""
    add_edits("CLOSE", "EPIPOLAR_CLOSE", "SILHOUETTE")
    for index in (1, 2):
        edit = sun.tyndall.occluder_edits[index]
        edit.size_m = index + 1
        edit.keyframe_insert("size_m", frame=1)
    sun.tyndall.occluder_edits[2].driver_add("distance_m").driver.expression = "30 + frame"


def values_by_name(frame: int = 1) -> dict[str, tuple[float, float]]:
    bpy.context.scene.frame_set(frame)
    return {edit.name: (edit.size_m, edit.distance_m) for edit in sent()}


def test_keys_and_drivers_stay_with_their_edits(sun: bpy.types.Light) -> None:
    """After moves, and after the removal of an edit before, between or after them."""
    keyed(sun)
    at_first = values_by_name()
    assert at_first["Fill Along View"][0] == 2.0
    assert at_first["Silhouettes"] == (3.0, 31.0)
    for _ in range(2):
        bpy.ops.tyndall.occluder_edit_move(direction="UP")
    assert names(sun) == ["Silhouettes", "Fill Holes", "Fill Along View"]
    assert values_by_name() == at_first

    sun.tyndall.active_occluder_edit = 0
    bpy.ops.tyndall.occluder_edit_remove()
    del at_first["Fill Holes"]
    assert values_by_name() == at_first
    assert sorted(curves(sun)) == [f"{EDITS}[0].size_m", f"{EDITS}[1].size_m"]
    assert [curve.data_path for curve in sun.animation_data.drivers] == [f"{EDITS}[1].distance_m"]

    sun.tyndall.active_occluder_edit = 0
    bpy.ops.tyndall.occluder_edit_remove()
    assert values_by_name() == {"Silhouettes": (3.0, 31.0)}
    bpy.ops.tyndall.occluder_edit_remove()
    assert not curves(sun)
    assert not sun.animation_data.drivers
    assert sent() == ()


def test_removing_leaves_the_keys_of_a_copied_light_alone(sun: bpy.types.Light) -> None:
    """Copies share their action until one of them loses an edit."""
    keyed(sun)
    other = add("Copy", sun.copy())
    sun.tyndall.active_occluder_edit = 0
    bpy.ops.tyndall.occluder_edit_remove()
    assert sorted(curves(other.data)) == [f"{EDITS}[1].size_m", f"{EDITS}[2].size_m"]
    bpy.context.scene.frame_set(1)
    assert [edit.size_m for edit in sent("Copy")] == [0.5, 2.0, 3.0]
    assert [edit.size_m for edit in sent()] == [2.0, 3.0]


def test_keys_in_nla_strips_are_renumbered_too(sun: bpy.types.Light) -> None:
    keyed(sun)
    animation = sun.animation_data
    action = animation.action
    strip = animation.nla_tracks.new().strips.new("Strip", 1, action)
    if hasattr(strip, "action_slot"):
        strip.action_slot = animation.action_slot
    animation.action = None
    sun.tyndall.active_occluder_edit = 0
    bpy.ops.tyndall.occluder_edit_remove()
    assert values_by_name()["Silhouettes"][0] == 3.0
    assert values_by_name()["Fill Along View"][0] == 2.0


def test_drivers_that_read_an_edit_follow_it(sun: bpy.types.Light) -> None:
    """A cube as high as the third edit's size, which becomes the second."""
    keyed(sun)
    box = bpy.data.objects["Cube"]
    driver = box.driver_add("location", 2).driver
    variable = driver.variables.new()
    variable.targets[0].id_type = "LIGHT"
    variable.targets[0].id = sun
    variable.targets[0].data_path = f"{EDITS}[2].size_m"
    driver.type = "SUM"
    sun.tyndall.active_occluder_edit = 0
    bpy.ops.tyndall.occluder_edit_remove()
    assert variable.targets[0].data_path == f"{EDITS}[1].size_m"
    bpy.context.scene.frame_set(1)
    assert box.evaluated_get(bpy.context.evaluated_depsgraph_get()).location.z == pytest.approx(3.0)


def test_paths_count_down_behind_a_removed_item() -> None:
    """A path into the item has no place any more; another collection's index is not ours."""
    assert path_without_item("a.b[3].c[5].d", "a.b", 1) == "a.b[2].c[5].d"
    assert path_without_item("a.b[0].c", "a.b", 1) == "a.b[0].c"
    assert path_without_item("a.b[1].c", "a.b", 1) is None
    assert path_without_item("a.bc[3].c", "a.b", 1) == "a.bc[3].c"
    assert path_without_item("a.b", "a.b", 1) == "a.b"


# The list


def test_names_are_unique(sun: bpy.types.Light) -> None:
    """Library overrides find an edit by its name; so does the artist."""
    add_edits("CLOSE", "CLOSE", "CLOSE")
    assert names(sun) == ["Fill Holes", "Fill Holes.001", "Fill Holes.002"]
    sun.tyndall.occluder_edits[2].name = "Fill Holes"
    assert names(sun)[2] == "Fill Holes.002"
    sun.tyndall.occluder_edits[2].name = ""
    assert names(sun)[2] == "Edit"


def test_a_new_edit_comes_after_the_active_one(sun: bpy.types.Light) -> None:
    """So does a duplicate, which has all settings but the name, and leaves the keys where they are."""
    keyed(sun)
    sun.tyndall.active_occluder_edit = 1
    sun.tyndall.occluder_edits[1].noise.seed = 5
    assert bpy.ops.tyndall.occluder_edit_duplicate() == {"FINISHED"}
    assert names(sun) == ["Fill Holes", "Fill Along View", "Fill Along View.001", "Silhouettes"]
    copied = sun.tyndall.occluder_edits[3]
    assert sun.tyndall.active_occluder_edit == 3
    assert (copied.kind, copied.size_m, copied.noise.seed) == ("EPIPOLAR_CLOSE", 2.0, 5)
    assert len(curves(sun)) == 2


def test_moving_ends_at_the_ends_of_the_list(sun: bpy.types.Light) -> None:
    add_edits("CLOSE", "HOLES")
    assert bpy.ops.tyndall.occluder_edit_move(direction="DOWN") == {"CANCELLED"}
    assert bpy.ops.tyndall.occluder_edit_move(direction="UP") == {"FINISHED"}
    assert bpy.ops.tyndall.occluder_edit_move(direction="UP") == {"CANCELLED"}
    assert names(sun) == ["Make Holes", "Fill Holes"]


def test_operators_ask_for_what_they_need(sun: bpy.types.Light) -> None:
    """No light, a light of another scene, a light without edits."""
    assert not bpy.ops.tyndall.occluder_edit_remove.poll()
    assert bpy.ops.tyndall.occluder_edit_add.poll()
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    assert not bpy.ops.tyndall.occluder_edit_add.poll()
    bpy.context.scene.tyndall.edited_light = bpy.data.objects["Sun"]
    assert bpy.ops.tyndall.occluder_edit_add.poll()
    bpy.context.scene.collection.objects.unlink(bpy.data.objects["Sun"])
    assert not bpy.ops.tyndall.occluder_edit_add.poll()
    with pytest.raises(RuntimeError):
        bpy.ops.tyndall.occluder_edit_add()


OPERATORS = {
    "add": lambda: bpy.ops.tyndall.occluder_edit_add(kind="HOLES"),
    "remove": bpy.ops.tyndall.occluder_edit_remove,
    "duplicate": bpy.ops.tyndall.occluder_edit_duplicate,
    "move": lambda: bpy.ops.tyndall.occluder_edit_move(direction="UP"),
    "solo": bpy.ops.tyndall.occluder_edit_solo,
}


# What is shown


def shown(owner: bpy.types.Light, *, in_sidebar: bool = False) -> list[str]:
    panels = occluder_edits
    panel = panels.TYNDALL_PT_sidebar_occluder_edits if in_sidebar else panels.TYNDALL_PT_occluder_edits
    return drawn(panel, light=None if in_sidebar else owner)


def test_the_list_shows_edits_in_their_order(sun: bpy.types.Light) -> None:
    """Although they never move in their collection; an empty list says what it is for."""
    assert any("add an edit" in line for line in shown(sun))
    add_edits("CLOSE", "SILHOUETTE", "HOLES")
    bpy.ops.tyndall.occluder_edit_move(direction="UP")
    rows = [line for line in shown(sun) if line.startswith("row: ")]
    assert rows == ["row: Fill Holes", "row: Make Holes", "row: Silhouettes"]
    assert shown(sun)[-5:] == shown(sun, in_sidebar=True)[-5:]


SIZES = {"CLOSE": {"size_m", "shape"}, "EPIPOLAR_CLOSE": {"size_m"}, "SILHOUETTE": {"size_m"}, "HOLES": {"probability"}}


@pytest.mark.parametrize("light_type", ["SUN", "POINT", "SPOT"])
@pytest.mark.parametrize("kind", SIZES)
def test_only_settings_that_the_edit_reads_are_shown(sun: bpy.types.Light, kind: str, light_type: str) -> None:
    """By its kind, the light's, and what it affects."""
    sun.type = light_type
    data = bpy.context.object.data  # another type of light is another type in Python
    add_edits(kind)
    edit = data.tyndall.occluder_edits[0]
    settings = set(shown(data))
    assert settings & {"size_m", "shape", "probability"} == SIZES[kind]
    assert "affects_surfaces" in settings
    assert ("distance_m" in settings) == (light_type != "SUN")
    assert not settings & {"target_object", "target_collection", "mask_channel", "mask_size_m"}
    edit.target, edit.mask_image = "COLLECTION", image("Mask", np.ones((2, 2)))
    settings = set(shown(data))
    assert {"target_collection", "mask_image", "mask_channel"} <= settings
    assert ("mask_size_m" in settings) == (light_type == "SUN")


def test_the_sidebar_offers_lights_while_none_is_active(sun: bpy.types.Light) -> None:
    """Lights of this scene that are rendered, and no other objects."""
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    assert shown(sun, in_sidebar=True)[0] == "edited_light"
    settings = bpy.context.scene.tyndall
    area, elsewhere = light("AREA", (0, 0, 1)), bpy.data.objects.new("Elsewhere", sun)
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    offered = [thing for thing in bpy.data.objects if is_light_of_scene(settings, thing)]
    assert set(offered) == {bpy.data.objects["Sun"], area}
    assert elsewhere not in offered
    settings.edited_light = bpy.data.objects["Sun"]
    add_edits("HOLES")
    assert "probability" in shown(sun, in_sidebar=True)


# What a change costs


@pytest.fixture
def updated_types() -> Iterator[list[str]]:
    seen: list[str] = []

    def note(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        seen.extend(update.id.bl_rna.identifier for update in depsgraph.updates)

    bpy.app.handlers.depsgraph_update_post.append(note)
    yield seen
    bpy.app.handlers.depsgraph_update_post.remove(note)


def test_each_setting_reaches_the_dependency_graph(sun: bpy.types.Light, updated_types: list[str]) -> None:
    """Set by a script, every property of an edit tags the light; so does every operator."""
    add_edits("CLOSE", "HOLES")
    edit = sun.tyndall.occluder_edits[0]
    for group in (edit, edit.noise):
        for name in set(type(group).__annotations__) - {"noise"}:
            bpy.context.view_layer.update()
            updated_types.clear()
            setattr(group, name, getattr(group, name))
            bpy.context.view_layer.update()
            assert "SunLight" in updated_types, f"{name} tags nothing"
    for name, run in OPERATORS.items():
        bpy.context.view_layer.update()
        updated_types.clear()
        run()
        bpy.context.view_layer.update()
        assert "SunLight" in updated_types, f"{name} tags nothing"


def test_a_moved_slider_sends_the_light_and_no_geometry(sun: bpy.types.Light) -> None:
    """Live, as in a viewport: meshes are the same objects, the session finds them in place, and renders anew."""
    add_edits("CLOSE")
    edit = sun.tyndall.occluder_edits[0]
    edit.target, edit.target_object, edit.mask_image = "OBJECT", bpy.data.objects["Cube"], image("Mask", np.eye(8))
    reader, session = SceneReader(), Session()

    def note(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        reader.note_updates(depsgraph)

    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        before = read(reader, is_live=True)
        session.update(before, Progress())
        edit.size_m = 0.75
        bpy.context.view_layer.update()
        after = read(reader, is_live=True)
        session.update(after, Progress())
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)
    assert after.lights[0].occluder_edits[0].size_m == 0.75
    assert all(new.mesh is old.mesh for new, old in zip(after.instances, before.instances, strict=True))
    counts = session.statistics["counts"]
    assert (counts["scene rebuilt"], counts["scene relit"], counts["meshes reused"]) == (0, 1, 2)
    session.update(read(reader, is_live=True), Progress())
    counts = session.statistics["counts"]
    assert (counts["scene rebuilt"], counts["scene relit"]) == (0, 0)
