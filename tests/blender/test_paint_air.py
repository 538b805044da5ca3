# SPDX-License-Identifier: GPL-3.0-or-later
"""Painting the air: strokes by scripts, the plane that is painted on, and what buttons do to the box."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from addon import painted_air
from addon.air_plane import AirPlane, Ray, axes_of, normal_of
from addon.painted_air import VOLUMES, edited_box, read_volume, world_from_unit, write_volume
from addon.panels import paint_air as panels
from support.recording_layout import drawn
from support.small_scenes import add, cube, empty_scene
from tyndall.air_tiles import VOLUME_KINDS

VOXELS = 32
#: Of the box: 4 m around the origin.
HALF_SIDE_M = 2.0


@pytest.fixture
def box() -> bpy.types.Object:
    """The scene's painted air, 32 voxels of 12.5 cm along each side; a hard brush that sets 0.5 fully."""
    scene = empty_scene()
    painted_air.forget()
    thing = add("Air", None)
    thing.empty_display_type, thing.empty_display_size = "CUBE", HALF_SIDE_M
    thing.tyndall.painted_air.resolution = (VOXELS,) * 3
    scene.tyndall.heterogeneity.painted = thing
    brush = scene.tyndall.air_brush
    brush.volume, brush.mode, brush.radius_m, brush.depth = "AMOUNT", "PAINT", 0.5, 1.0
    brush.amount, brush.opacity, brush.hardness = 0.5, 1.0, 1.0
    bpy.context.view_layer.update()
    return thing


def stroke(*places_m: Sequence[float], pressure: float = 1.0, **options: Any) -> set[str]:
    dabs = [{"name": "", "location": tuple(place_m), "pressure": pressure} for place_m in places_m]
    return bpy.ops.tyndall.paint_air_stroke(dabs=dabs, **options)


def centres_m() -> np.ndarray:
    """(nz, ny, nx, 3)."""
    at = (np.arange(VOXELS) + 0.5) * (2.0 * HALF_SIDE_M / VOXELS) - HALF_SIDE_M
    z, y, x = np.meshgrid(at, at, at, indexing="ij")
    return np.stack([x, y, z], axis=-1)


# Strokes


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
    assert "0.125 MiB per painted volume" in drawn(panels.TYNDALL_PT_painted_volumes)


def test_the_tool_says_that_it_needs_a_mouse(box: bpy.types.Object) -> None:
    with pytest.raises(RuntimeError, match=r"in a script, call tyndall.paint_air_stroke"):
        bpy.ops.tyndall.paint_air()


# The plane


def view_from(*, rotation: tuple[float, float, float], eye: Vector | None = None) -> Any:
    """What the plane reads of a 3D view."""
    turn = Euler(rotation).to_quaternion()
    camera = Matrix.Translation(eye or Vector((0.0, 0.0, 10.0))) @ turn.to_matrix().to_4x4()
    return SimpleNamespace(view_rotation=turn, view_matrix=camera.inverted(), is_perspective=eye is not None)


def plane_of(box: bpy.types.Object) -> AirPlane:
    return AirPlane(Matrix(world_from_unit(box)))


@pytest.mark.parametrize("rotation", [(0.0, 0.0, 0.0), (math.pi / 2, 0.0, 0.0), (1.1, 0.2, 0.7)])
def test_the_plane_faces_the_view_and_stays_in_the_box(
    box: bpy.types.Object, rotation: tuple[float, float, float]
) -> None:
    """It slides from one end of the box to the other, and no further."""
    view, plane = view_from(rotation=rotation), plane_of(box)
    assert plane.depth_in_box(view) == pytest.approx(0.5)
    plane.slide(view, 1000)
    assert plane.depth_in_box(view) == pytest.approx(1.0, abs=1e-5)
    plane.slide(view, -20)
    assert plane.depth_in_box(view) == pytest.approx(0.5, abs=1e-5)
    plane.slide(view, -1000)
    assert plane.depth_in_box(view) == pytest.approx(0.0, abs=1e-5)


def test_the_plane_cuts_the_box_in_a_polygon(box: bpy.types.Object) -> None:
    """A square from the front, a hexagon along the diagonal; its grid ends on its rim."""
    front = view_from(rotation=(math.pi / 2, 0.0, 0.0))
    plane = plane_of(box)
    corners = plane.outline(front)
    assert (
        sorted((round(abs(x), 5), round(abs(y), 5), round(abs(z), 5)) for x, y, z in corners) == [(2.0, 0.0, 2.0)] * 4
    )
    diagonal = view_from(rotation=(math.atan(math.sqrt(2.0)), 0.0, math.pi / 4))
    corners = plane.outline(diagonal)
    assert len(corners) == 6
    sides = [(one - other).length for one, other in zip(corners, corners[1:] + corners[:1], strict=True)]
    assert sides == pytest.approx([2.0 * math.sqrt(2.0)] * 6, rel=1e-5)
    lines = list(plane.grid(diagonal))
    assert len(lines) == 30
    for end in (end for line in lines for end in line):
        assert max(map(abs, end)) == pytest.approx(2.0, rel=1e-5)
        assert end.dot(normal_of(diagonal)) == pytest.approx(0.0, abs=1e-5)


def test_a_viewer_within_the_box_has_the_plane_before_them(box: bpy.types.Object) -> None:
    view = view_from(rotation=(0.0, 0.0, 0.0), eye=Vector((0.0, 0.0, -0.5)))
    plane = plane_of(box)
    assert plane.keep_in(view)
    assert -2.0 <= plane.point.z < -0.5
    behind = view_from(rotation=(0.0, 0.0, 0.0), eye=Vector((0.0, 0.0, -3.0)))
    assert not plane.keep_in(behind)


def test_a_place_on_the_plane_is_under_the_mouse(box: bpy.types.Object) -> None:
    """The ray through it meets the plane there; one that looks away meets nothing."""
    view = view_from(rotation=(1.1, 0.2, 0.7), eye=Vector((3.0, -6.0, 4.0)))
    plane = plane_of(box)
    across, up, normal = axes_of(view)
    place = plane.point + across * 0.3 - up * 0.7
    eye = Vector((3.0, -6.0, 4.0))
    met = plane.meet(view, Ray(origin=eye, direction=(place - eye).normalized()))
    assert (met - place).length < 1e-5
    assert plane.meet(view, Ray(origin=eye, direction=-normal)) is None


def test_the_plane_goes_where_its_box_goes(box: bpy.types.Object) -> None:
    """At the same place within it."""
    plane = plane_of(box)
    plane.point = Vector((1.0, -1.0, 0.5))
    box.location, box.scale = (5.0, 0.0, 0.0), (2.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    plane.follow(Matrix(world_from_unit(box)))
    assert tuple(plane.point) == pytest.approx((7.0, -1.0, 0.5), abs=1e-5)


# The box


def test_a_new_box_fits_the_fog(box: bpy.types.Object) -> None:
    """To a millimetre. It becomes the scene's, with voxels that are cubes, and the texture is on."""
    cube().scale = (2.0, 1.0, 0.5)
    bpy.context.view_layer.update()
    bpy.ops.tyndall.add_fog_box(with_camera_and_lights=False)
    fog = bpy.context.object
    bpy.context.view_layer.update()
    assert bpy.ops.tyndall.add_painted_box(voxels=64) == {"FINISHED"}
    new = bpy.context.object
    bpy.context.view_layer.update()
    assert bpy.context.scene.tyndall.heterogeneity.painted == new == edited_box(bpy.context)
    assert bpy.context.scene.tyndall.heterogeneity.is_enabled
    corners = [fog.matrix_world @ Vector(corner) for corner in fog.bound_box]
    matrix = Matrix(world_from_unit(new))
    for axis in range(3):
        lowest, highest = min(corner[axis] for corner in corners), max(corner[axis] for corner in corners)
        assert (matrix @ Vector((0.0, 0.0, 0.0)))[axis] == pytest.approx(lowest, abs=2e-3)
        assert (matrix @ Vector((1.0, 1.0, 1.0)))[axis] == pytest.approx(highest, abs=2e-3)
    nx, ny, nz = new.tyndall.painted_air.resolution
    assert nx == 64
    sides_m = [matrix.col[axis].length for axis in range(3)]
    for side_m, voxels in zip(sides_m, (nx, ny, nz), strict=True):
        assert voxels == round(64 * side_m / sides_m[0])


def test_a_new_box_without_fog_fits_the_scene(scene: bpy.types.Scene) -> None:
    """Its surfaces; a scene without any gets one of 10 m."""
    assert bpy.ops.tyndall.add_painted_box() == {"FINISHED"}
    bpy.context.view_layer.update()
    first = Matrix(world_from_unit(bpy.context.object))
    assert 2.0 < first.col[0].length < 3.0
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    assert bpy.ops.tyndall.add_painted_box() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert Matrix(world_from_unit(bpy.context.object)).col[0].length == pytest.approx(10.0)


def test_fill_sets_all_of_the_volume(box: bpy.types.Object) -> None:
    stroke((0.0, 0.0, 0.0))
    bpy.context.scene.tyndall.air_brush.amount = -1.0
    bpy.ops.tyndall.painted_air_fill(opacity=0.5)
    assert set(np.unique(read_volume(box, "amount"))) == {-0.5, -0.25}
    bpy.ops.tyndall.painted_air_fill()
    assert set(np.unique(read_volume(box, "amount"))) == {-1.0}


def test_clear_takes_one_volume_or_all(box: bpy.types.Object) -> None:
    brush = bpy.context.scene.tyndall.air_brush
    for brush.volume in ("AMOUNT", "LEVEL", "INTENSITY"):
        stroke((0.0, 0.0, 0.0))
    bpy.ops.tyndall.painted_air_clear()
    assert [name for name in VOLUMES if read_volume(box, name) is not None] == ["amount", "level"]
    bpy.ops.tyndall.painted_air_clear(takes_all=True)
    assert not any(len(getattr(box.tyndall.painted_air, name).tiles) for name in VOLUMES)


@pytest.mark.parametrize(("axis", "place_m"), [("X", (-1, 0.5, 0.2)), ("Y", (1, -0.5, 0.2)), ("Z", (1, 0.5, -0.2))])
def test_flip_mirrors_what_is_painted(box: bpy.types.Object, axis: str, place_m: Sequence[float]) -> None:
    """In all volumes; twice is nothing."""
    stroke((1.0, 0.5, 0.2))
    before = read_volume(box, "amount")
    write_volume(box, "level", before * 2.0)
    bpy.ops.tyndall.painted_air_flip(axis=axis)
    flipped, level = read_volume(box, "amount"), read_volume(box, "level")
    assert np.array_equal(level, flipped * 2.0)
    bpy.ops.tyndall.painted_air_clear()
    stroke(place_m)
    assert np.array_equal(read_volume(box, "amount"), flipped)
    bpy.ops.tyndall.painted_air_flip(axis=axis)
    assert np.array_equal(read_volume(box, "amount"), before)


def test_resample_keeps_the_paint_at_another_resolution(box: bpy.types.Object) -> None:
    stroke((0.0, 0.0, 0.0))
    mean = read_volume(box, "amount").mean()
    assert bpy.ops.tyndall.painted_air_resample(resolution=(48, 32, 16)) == {"FINISHED"}
    assert tuple(box.tyndall.painted_air.kept_resolution) == (48, 32, 16)
    painted_air.forget()
    finer = read_volume(box, "amount")
    assert finer.shape == (16, 32, 48)
    assert finer.mean() == pytest.approx(mean, rel=0.02)


def test_the_panel_shows_the_value_that_is_painted(box: bpy.types.Object) -> None:
    """And only where the brush brings one."""
    brush = bpy.context.scene.tyndall.air_brush
    for brush.volume in ("AMOUNT", "LEVEL", "INTENSITY"):
        brush.mode = "PAINT"
        assert brush.volume.lower() in drawn(panels.TYNDALL_PT_paint_air)
        brush.mode = "SMOOTH"
        assert brush.volume.lower() not in drawn(panels.TYNDALL_PT_paint_air)
    stroke((0.0, 0.0, 0.0))
    box_shown = drawn(panels.TYNDALL_PT_painted_volumes)
    assert "Intensity: not painted" in box_shown
    assert set(VOLUME_KINDS) == set(VOLUMES)
