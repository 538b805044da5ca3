# SPDX-License-Identifier: GPL-3.0-or-later
"""Painting the air by script: strokes in the scene's box, and what cannot be painted."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import painted_air
from addon.painted_air import VOLUMES, edited_box, read_volume, write_volume
from addon.panels import paint_air as panels
from support.painted_box import HALF_SIDE_M, VOXELS, painted_box, stroke
from support.recording_layout import drawn
from support.small_scenes import add, empty_scene


@pytest.fixture
def box() -> bpy.types.Object:
    return painted_box()


def centres_m() -> np.ndarray:
    """(nz, ny, nx, 3)."""
    at = (np.arange(VOXELS) + 0.5) * (2.0 * HALF_SIDE_M / VOXELS) - HALF_SIDE_M
    z, y, x = np.meshgrid(at, at, at, indexing="ij")
    return np.stack([x, y, z], axis=-1)


def test_a_stroke_sets_the_value_where_it_goes(box: bpy.types.Object) -> None:
    """All of what is within its radius of the way, and nothing else; the other volumes are as they were."""
    assert stroke((-1.0, 0.0, 0.5), (1.0, 0.0, 0.5)) == {"FINISHED"}
    values = read_volume(box, "amount")
    offset = centres_m() - [0.0, 0.0, 0.5]
    beyond = np.maximum(np.abs(offset[..., 0]) - 1.0, 0.0)
    distance_m = np.sqrt(beyond**2 + offset[..., 1] ** 2 + offset[..., 2] ** 2)
    is_clear = np.abs(distance_m - 0.5) > 1e-5
    assert np.array_equal(values[is_clear], np.where(distance_m < 0.5, np.float32(0.5), 0.0)[is_clear])
    assert read_volume(box, "level") is None


@pytest.mark.parametrize("volume", ["AMOUNT", "LEVEL", "INTENSITY"])
def test_each_volume_is_painted_with_its_own_value(box: bpy.types.Object, volume: str) -> None:
    brush = bpy.context.scene.tyndall.air_brush
    brush.volume, brush.amount, brush.level, brush.intensity = volume, -0.5, 3.0, 0.25
    stroke((0.0, 0.0, 0.0))
    expected = {"AMOUNT": -0.5, "LEVEL": 3.0, "INTENSITY": 0.25}[volume]
    assert read_volume(box, volume.lower())[16, 16, 16] == expected
    assert [name for name in VOLUMES if read_volume(box, name) is not None] == [volume.lower()]


def test_the_brush_is_as_deep_along_the_normal_as_it_says(box: bpy.types.Object) -> None:
    """Four times its size along y, as a view from the front has it."""
    bpy.context.scene.tyndall.air_brush.depth = 3.0
    stroke((0.0, 0.0, 0.0), normal=(0.0, 2.0, 0.0))
    z, y, x = (np.ptp(one) + 1 for one in np.nonzero(read_volume(box, "amount")))
    assert (z, x) == (8, 8)
    assert y == 24


def test_pressure_fades_a_stroke_where_it_is_asked_to(box: bpy.types.Object) -> None:
    brush = bpy.context.scene.tyndall.air_brush
    for brush.pressure_fades, expected in ((True, 0.25), (False, 0.5)):
        write_volume(box, "amount", None)
        stroke((0.0, 0.0, 0.0), pressure=0.5)
        assert read_volume(box, "amount")[16, 16, 16] == expected


def test_the_eraser_leaves_no_tile_behind(box: bpy.types.Object) -> None:
    """A box that was painted and erased is as if it had never been painted."""
    stroke((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    assert len(box.tyndall.painted_air.amount.tiles) > 0
    brush = bpy.context.scene.tyndall.air_brush
    brush.mode, brush.radius_m = "ERASE", 9.0
    stroke((0.0, 0.0, 0.0))
    assert len(box.tyndall.painted_air.amount.tiles) == 0
    assert painted_air.painted_air(box).amount is None


def test_a_stroke_is_undone_and_redone(box: bpy.types.Object) -> None:
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    stroke((0.0, 0.0, 0.0))
    bpy.ops.ed.undo_push(message="first")
    first = read_volume(bpy.data.objects["Air"], "amount").copy()
    stroke((1.0, 0.0, 0.0))
    bpy.ops.ed.undo_push(message="second")
    second = read_volume(bpy.data.objects["Air"], "amount").copy()
    bpy.ops.ed.undo()
    assert np.array_equal(read_volume(bpy.data.objects["Air"], "amount"), first)
    bpy.ops.ed.undo()
    assert read_volume(bpy.data.objects["Air"], "amount") is None
    bpy.ops.ed.redo()
    bpy.ops.ed.redo()
    assert np.array_equal(read_volume(bpy.data.objects["Air"], "amount"), second)


def test_a_stroke_reaches_the_dependency_graph(box: bpy.types.Object) -> None:
    """So that a rendered viewport follows."""
    seen: list[str] = []

    def note(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        seen.extend(update.id.name for update in depsgraph.updates)

    bpy.context.view_layer.update()
    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        stroke((0.0, 0.0, 0.0))
        bpy.context.view_layer.update()
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)
    assert "Air" in seen


def test_the_brush_has_no_scene_read_again(box: bpy.types.Object) -> None:
    """A size that follows the mouse would stop a rendered viewport at every move."""
    seen: list[bool] = []

    def note(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        seen.append(bool(depsgraph.updates))

    bpy.context.view_layer.update()
    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        bpy.context.scene.tyndall.air_brush.radius_m = 0.7
        bpy.context.view_layer.update()
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)
    assert not any(seen)


# What cannot be painted


def test_a_stroke_outside_the_box_paints_nothing_and_says_so(box: bpy.types.Object) -> None:
    """Nor does one without places."""
    assert stroke((5.0, 0.0, 0.0), (5.0, 5.0, 0.0)) == {"CANCELLED"}
    assert stroke() == {"CANCELLED"}
    assert read_volume(box, "amount") is None
    assert tuple(box.tyndall.painted_air.kept_resolution) == (0, 0, 0)


def test_a_plane_without_a_normal_is_named(box: bpy.types.Object) -> None:
    with pytest.raises(RuntimeError, match="The normal of the plane is 0"):
        stroke((0.0, 0.0, 0.0), normal=(0.0, 0.0, 0.0))


def test_a_box_without_space_cannot_be_painted(box: bpy.types.Object) -> None:
    box.scale.z = 0.0
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match='"Air" has a scale or a size of 0: there is no space in it'):
        stroke((0.0, 0.0, 0.0))


def test_a_deleted_box_is_not_painted(box: bpy.types.Object) -> None:
    """It lives on in the scene's pointer; another Empty takes its place when it is active."""
    bpy.data.scenes["Scene"].collection.objects.unlink(box)
    assert edited_box(bpy.context) is None
    with pytest.raises(RuntimeError, match="Add a box to paint in, or choose an Empty"):
        stroke((0.0, 0.0, 0.0))
    other = add("Other", None)
    bpy.context.view_layer.objects.active = other
    assert edited_box(bpy.context) is None
    other.empty_display_type = "CUBE"
    assert edited_box(bpy.context) == other


def test_a_linked_box_cannot_be_painted(box: bpy.types.Object, tmp_path: Path) -> None:
    stroke((0.0, 0.0, 0.0))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    scene = empty_scene()
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_there, here):
        here.objects = ["Air"]
    scene.collection.objects.link(here.objects[0])
    scene.tyndall.heterogeneity.painted = here.objects[0]
    with pytest.raises(RuntimeError, match='"Air" is linked: make it local, or a library override of it'):
        stroke((0.0, 0.0, 0.0))
    shown = drawn(panels.TYNDALL_PT_paint_air)
    assert any("is linked" in line for line in shown)


def test_a_damaged_box_is_named(box: bpy.types.Object) -> None:
    stroke((0.0, 0.0, 0.0))
    box.tyndall.painted_air.amount.tiles[0].halves = b"xyz"
    with pytest.raises(RuntimeError, match='"Air", painted amount: a tile is damaged'):
        stroke((0.0, 0.0, 0.0))
    assert bpy.ops.tyndall.painted_air_clear() == {"FINISHED"}
    assert stroke((0.0, 0.0, 0.0)) == {"FINISHED"}


def test_no_resolution_is_absurd(box: bpy.types.Object) -> None:
    """Blender clamps it; the panel says what it takes."""
    settings = box.tyndall.painted_air
    settings.resolution = (0, 10**6, 64)
    assert tuple(settings.resolution) == (1, 512, 64)
    assert "128 KiB per painted volume" in drawn(panels.TYNDALL_PT_painted_volumes)


def test_the_tool_says_that_it_needs_a_mouse(box: bpy.types.Object) -> None:
    with pytest.raises(RuntimeError, match=r"in a script, call tyndall.paint_air_stroke"):
        bpy.ops.tyndall.paint_air()
