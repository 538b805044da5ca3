# SPDX-License-Identifier: GPL-3.0-or-later
"""What buttons do to the box that the air is painted in, and to all of a volume at once."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector

from addon import painted_air
from addon.painted_air import VOLUMES, edited_box, read_volume, world_from_unit, write_volume
from addon.panels import paint_air as panels
from addon.sync.heterogeneity import read_heterogeneity
from addon.sync.reports import Reports
from support.engine_pictures import tyndall_pixels
from support.painted_box import VOXELS, painted_box, stroke
from support.recording_layout import drawn
from support.small_scenes import cube, light
from tyndall import Progress
from tyndall.air_tiles import VOLUME_KINDS
from tyndall.baked_air import bake_air
from tyndall.heterogeneity import Heterogeneity


@pytest.fixture
def box() -> bpy.types.Object:
    return painted_box()


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


def test_baked_air_scatters_as_it_did(box: bpy.types.Object) -> None:
    """What a render is sent: noise and paint before, after it one volume that gives the same at the voxels' centres."""
    texture = bpy.context.scene.tyndall.heterogeneity
    texture.is_enabled, texture.scale_m, texture.amount, texture.intensity = True, 0.5, 0.8, 3.0
    stroke((0.0, 0.0, 0.0))
    before = sent()
    expected = bake_air(before, (VOXELS,) * 3, Progress())
    assert expected.std() > 0.1
    assert bpy.ops.tyndall.painted_air_bake() == {"FINISHED"}
    after = sent()
    assert (after.amount, after.intensity) == (before.amount, before.intensity)
    assert after.painted.level is None
    assert (after.painted.amount == -1.0).all()
    assert np.abs(after.painted.intensity / expected - 1.0).max() < 2.0**-10
    texture.wind_m_per_s, texture.seed = (1.0, 0.0, 0.0), 7
    bpy.context.scene.frame_set(50)
    assert np.abs(bake_air(sent(), (VOXELS,) * 3, Progress()) / expected - 1.0).max() < 2.0**-10


def sent() -> Heterogeneity:
    reports = Reports()
    heterogeneity = read_heterogeneity(bpy.context.evaluated_depsgraph_get(), reports)
    assert heterogeneity is not None, reports.lines()
    return heterogeneity


def test_what_cannot_be_baked_is_said(box: bpy.types.Object) -> None:
    """A texture that is off, a box that is not the scene's."""
    with pytest.raises(RuntimeError, match="Texture the Air is off"):
        bpy.ops.tyndall.painted_air_bake()
    texture = bpy.context.scene.tyndall.heterogeneity
    texture.is_enabled, texture.painted = True, None
    bpy.context.view_layer.objects.active = box
    with pytest.raises(RuntimeError, match='"Air" is not the painted air of the scene'):
        bpy.ops.tyndall.painted_air_bake()
    assert read_volume(box, "intensity") is None


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


def test_a_render_shows_what_is_painted(box: bpy.types.Object) -> None:
    """From above, through fog under a sun: no shafts where 0 is painted, twice as bright where 2 is, else as before."""
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.camera.location.z, scene.camera.data.ortho_scale = 10.0, 4.0
    light("SUN", (0.0, 0.0, 5.0))
    bpy.ops.tyndall.add_fog_box(optical_depth=5.0, with_camera_and_lights=False)
    bpy.data.objects["Fog Box"].scale = (0.4, 0.4, 0.05)  # of 10 m around the origin: within the painted box
    scene.tyndall.heterogeneity.is_enabled, scene.tyndall.heterogeneity.amount = True, 0.0
    before = tyndall_pixels(scene)
    assert before.min() > 0.0
    intensity = np.ones((VOXELS,) * 3, np.float32)
    intensity[..., : VOXELS // 4], intensity[..., -VOXELS // 4 :] = 0.0, 2.0
    write_volume(box, "intensity", intensity)
    after = tyndall_pixels(scene)
    ratio = (after / before)[:, [1, 7, 8, 14]].mean(axis=(0, 2))
    assert ratio == pytest.approx([0.0, 1.0, 1.0, 2.0], abs=1e-3)
