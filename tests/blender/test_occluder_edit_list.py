# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of a light's occluder edits: their keys and drivers, their order, and what is shown of them."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import numpy as np
import pytest

from addon.animation_paths import path_without_item
from addon.edited_light import is_light_of_scene
from addon.panels import occluder_edits
from addon.sync.scene import SceneReader
from support.occluder_edit_scenes import add_edits, curves, image, names, sent, sun_over_cube
from support.recording_layout import drawn
from support.small_scenes import add, light, read
from tyndall import Progress
from tyndall.renderer import Session

EDITS = "tyndall.occluder_edits"


@pytest.fixture
def sun() -> bpy.types.Light:
    return sun_over_cube()


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
