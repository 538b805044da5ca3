# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted air in a .blend: kept, undone, copied and sent as it was painted."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import painted_air
from addon.painted_air import VOLUMES, content_key, read_volume, write_volume
from support.small_scenes import add, empty_scene
from tyndall.air_tiles import VOLUME_KINDS

RESOLUTION = (20, 16, 40)


@pytest.fixture
def box() -> Iterator[bpy.types.Object]:
    """An Empty of 2 m at (1, 2, 3), turned and scaled, as a box of 20 x 16 x 40 voxels: 2 x 1 x 3 tiles."""
    empty_scene()
    painted_air.forget()
    thing = add("Air", None, (1.0, 2.0, 3.0))
    thing.empty_display_type, thing.empty_display_size = "CUBE", 2.0
    thing.rotation_euler, thing.scale = (0.1, 0.2, 0.3), (1.0, 2.0, 0.5)
    thing.tyndall.painted_air.resolution = RESOLUTION
    bpy.context.view_layer.update()
    return thing


def paint(thing: bpy.types.Object, name: str = "amount", seed: int = 1) -> np.ndarray:
    """Random numbers that half floats hold, in one corner."""
    kind = VOLUME_KINDS[name]
    values = np.full(RESOLUTION[::-1], kind.neutral, np.float32)
    corner = np.random.default_rng(seed).uniform(kind.lowest, kind.highest, (20, 10, 10))
    values[:20, :10, :10] = corner.astype(np.float16)
    write_volume(thing, name, values)
    return values


def reread(thing: bpy.types.Object, name: str = "amount") -> np.ndarray | None:
    """From the tiles alone."""
    painted_air.forget()
    return read_volume(thing, name)


def test_an_empty_without_paint_sends_nothing_but_its_place(box: bpy.types.Object) -> None:
    """Its cube is the unit cube's image: corner to corner, whatever the display type."""
    sent = painted_air.painted_air(box)
    assert (sent.amount, sent.level, sent.intensity) == (None, None, None)
    world_from_unit = np.array(sent.world_from_unit)
    for corner in np.ndindex(2, 2, 2):
        local = (2.0 * np.array(corner) - 1.0) * 2.0
        expected = np.array(box.matrix_world) @ [*local, 1.0]
        assert np.abs(world_from_unit @ [*corner, 1.0] - expected).max() < 1e-6


@pytest.mark.parametrize("name", VOLUMES)
def test_paint_comes_back_from_its_tiles(box: bpy.types.Object, name: str) -> None:
    """Bit for bit, and only the tiles that have any are kept: a corner of 20 x 10 x 10 lies in two."""
    values = paint(box, name)
    assert len(getattr(box.tyndall.painted_air, name).tiles) == 2
    assert np.array_equal(reread(box, name), values)
    sent = painted_air.painted_air(box)
    assert np.array_equal(getattr(sent, name), values)
    assert all(getattr(sent, other) is None for other in VOLUMES if other != name)


def test_only_touched_tiles_are_written(box: bpy.types.Object) -> None:
    """The third tile, beside two others that keep their bytes."""
    paint(box)
    before = [tile.halves for tile in box.tyndall.painted_air.amount.tiles]
    values = read_volume(box, "amount").copy()
    values[39, 15, 19] = 0.5
    write_volume(box, "amount", values, touched={5})
    tiles = box.tyndall.painted_air.amount.tiles
    assert [tile.index for tile in tiles] == [0, 2, 5]
    assert [tile.halves for tile in tiles][:2] == before
    assert reread(box)[39, 15, 19] == 0.5


def test_a_tile_that_is_neutral_again_is_dropped(box: bpy.types.Object) -> None:
    values = paint(box, "intensity").copy()
    values[:16] = 1.0
    write_volume(box, "intensity", values, touched={0})
    assert [tile.index for tile in box.tyndall.painted_air.intensity.tiles] == [2]
    assert (reread(box, "intensity")[:16] == 1.0).all()
    values = np.ones_like(values)
    write_volume(box, "intensity", values, touched={2})
    assert read_volume(box, "intensity") is None


def test_the_key_changes_with_the_paint_and_the_resolution_alone(box: bpy.types.Object) -> None:
    keys = [content_key(box)]
    box.location.x += 1.0
    bpy.context.view_layer.update()
    assert content_key(box) == keys[0]
    paint(box)
    keys.append(content_key(box))
    paint(box, "level")
    keys.append(content_key(box))
    box.tyndall.painted_air.resolution[0] = 21
    keys.append(content_key(box))
    box.tyndall.painted_air.amount.tiles[0].halves = b""  # by a script
    keys.append(content_key(box))
    box.tyndall.painted_air.level.tiles.remove(0)
    keys.append(content_key(box))
    assert len(set(keys)) == 6


def test_a_volume_that_has_not_changed_is_not_read_again(box: bpy.types.Object) -> None:
    paint(box)
    assert read_volume(box, "amount") is read_volume(box, "amount")
    first = reread(box)
    assert read_volume(box, "amount") is first
    assert not first.flags.writeable


def test_what_a_script_does_to_a_tile_is_seen(box: bpy.types.Object) -> None:
    values = paint(box)
    tiles = box.tyndall.painted_air.amount.tiles
    tiles[0].halves = tiles[1].halves[:0]
    seen = read_volume(box, "amount")
    assert (seen[:16] == 0.0).all()
    assert np.array_equal(seen[16:], values[16:])


def test_undo_and_redo_bring_the_paint_back(box: bpy.types.Object) -> None:
    bpy.context.preferences.edit.use_global_undo = True
    first = paint(box, seed=1)
    bpy.ops.ed.undo_push(message="first")
    second = paint(box, seed=2)
    bpy.ops.ed.undo_push(message="second")
    bpy.ops.ed.undo()
    assert np.array_equal(read_volume(bpy.data.objects["Air"], "amount"), first)
    assert np.array_equal(reread(bpy.data.objects["Air"]), first)
    bpy.ops.ed.redo()
    assert np.array_equal(read_volume(bpy.data.objects["Air"], "amount"), second)
    assert np.array_equal(reread(bpy.data.objects["Air"]), second)


def test_paint_survives_save_and_reload(box: bpy.types.Object, tmp_path: Path) -> None:
    """Zero bytes included, at which Blender cuts custom properties."""
    values = {name: paint(box, name) for name in VOLUMES}
    key = content_key(box)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "air.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "air.blend"))
    thing = bpy.data.objects["Air"]
    assert content_key(thing) == key
    assert all(np.array_equal(reread(thing, name), values[name]) for name in VOLUMES)


def test_a_duplicate_has_its_own_paint(box: bpy.types.Object) -> None:
    """The same until one of them changes."""
    first = paint(box)
    copy = box.copy()
    bpy.context.scene.collection.objects.link(copy)
    assert np.array_equal(reread(copy), first)
    assert content_key(copy) == content_key(box)
    second = paint(copy, seed=2)
    assert np.array_equal(reread(box), first)
    assert np.array_equal(reread(copy), second)
    assert content_key(copy) != content_key(box)


def test_the_evaluated_empty_sends_the_same_paint_at_its_own_place(box: bpy.types.Object) -> None:
    """As a constraint moves it."""
    values = paint(box)
    target = add("Target", None, (7.0, 0.0, 0.0))
    box.constraints.new("COPY_LOCATION").target = target
    evaluated = box.evaluated_get(bpy.context.evaluated_depsgraph_get())
    sent = painted_air.painted_air(evaluated)
    assert sent.amount is not None
    assert np.array_equal(sent.amount, values)
    centre = np.array(sent.world_from_unit) @ [0.5, 0.5, 0.5, 1.0]
    assert np.abs(centre - [7.0, 0.0, 0.0, 1.0]).max() < 1e-6


def test_another_resolution_shows_the_paint_and_going_back_loses_nothing(box: bpy.types.Object) -> None:
    values = paint(box)
    settings = box.tyndall.painted_air
    settings.resolution = (10, 8, 20)
    coarser = read_volume(box, "amount")
    assert coarser.shape == (20, 8, 10)
    settings.resolution = RESOLUTION
    assert np.array_equal(read_volume(box, "amount"), values)


def test_the_next_stroke_keeps_the_new_resolution_in_all_volumes(box: bpy.types.Object) -> None:
    paint(box, "amount"), paint(box, "level")
    box.tyndall.painted_air.resolution = (10, 8, 20)
    amount, level = read_volume(box, "amount"), read_volume(box, "level")
    write_volume(box, "amount", amount.copy(), touched=set())
    assert tuple(box.tyndall.painted_air.kept_resolution) == (10, 8, 20)
    assert np.array_equal(reread(box, "amount"), amount)
    assert np.array_equal(reread(box, "level"), level)


@pytest.fixture
def library(box: bpy.types.Object, tmp_path: Path) -> Path:
    paint(box)
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    empty_scene()
    painted_air.forget()
    return path


def load(path: Path, *, link: bool) -> bpy.types.Object:
    with bpy.data.libraries.load(str(path), link=link) as (_there, here):
        here.objects = ["Air"]
    bpy.context.scene.collection.objects.link(here.objects[0])
    return here.objects[0]


def test_an_appended_box_brings_its_paint(library: Path) -> None:
    thing = load(library, link=False)
    assert painted_air.why_not_editable(thing) is None
    assert len(thing.tyndall.painted_air.amount.tiles) == 2
    assert read_volume(thing, "amount").any()


def test_a_linked_box_can_be_rendered_but_not_painted(library: Path) -> None:
    thing = load(library, link=True)
    assert read_volume(thing, "amount").any()
    assert painted_air.why_not_editable(thing) == '"Air" is linked: make it local, or a library override of it'


def test_an_override_has_its_own_paint_after_a_reload(library: Path, tmp_path: Path) -> None:
    """A tile changed, one erased, one added; the linked box keeps its own."""
    thing = load(library, link=True).override_create(remap_local_usages=True)
    values = read_volume(thing, "amount").copy()
    values[0, 0, 0] = 0.5
    values[16:] = 0.0
    values[39, 15, 19] = -0.5
    write_volume(thing, "amount", values, touched={0, 2, 5})
    values = values.copy()
    assert np.array_equal(reread(thing), values)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "override.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "override.blend"))
    (override,) = [one for one in bpy.data.objects if one.override_library is not None]
    assert np.array_equal(reread(override), values)


def test_a_box_without_space_is_named(box: bpy.types.Object) -> None:
    box.scale.y = 0.0
    bpy.context.view_layer.update()
    with pytest.raises(ValueError, match='"Air" has a scale or a size of 0: there is no space in it'):
        painted_air.painted_air(box)


def test_a_damaged_tile_is_named(box: bpy.types.Object) -> None:
    paint(box)
    tile = box.tyndall.painted_air.amount.tiles[0]
    tile.halves = tile.halves[:30]
    with pytest.raises(ValueError, match='"Air", painted amount: a tile is damaged'):
        painted_air.painted_air(box)
    tile.index = 99
    with pytest.raises(ValueError, match='"Air", painted amount: there is no tile 99 in it'):
        painted_air.painted_air(box)
