# SPDX-License-Identifier: GPL-3.0-or-later
"""Strokes painted over cameras become a light's gobo: headless, undoable, kept in the file; and what cannot be."""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import fitted_maps
from addon.fitted_maps import keep, new_fit
from addon.sync.images import ImageReader
from addon.sync.reports import Reports
from support.small_scenes import add, cube, empty_scene, light, material, node, plane
from tyndall import Progress

pytestmark = pytest.mark.dealt

SIZE_PX = 32


@pytest.fixture
def sun() -> bpy.types.Object:
    """Straight above a metre of fog on the ground, that a camera looks down at."""
    empty_scene()
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = SIZE_PX
    scene.render.resolution_percentage = 100
    plane(half_side=4.0)
    fog = material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.05).outputs["Volume"])
    box = cube("Fog", fog)
    box.location, box.scale = (0.0, 0.0, 0.5), (4.0, 4.0, 0.5)
    scene.camera = camera((0.0, 0.0, 6.0))
    thing = light("SUN", (0.0, 0.0, 5.0))
    bpy.context.view_layer.objects.active = thing
    thing.data.tyndall.light_map_fit.resolution = 64
    return thing


def camera(location: tuple[float, float, float]) -> bpy.types.Object:
    return add("Camera", bpy.data.cameras.new("Camera"), location)


def paint(image: bpy.types.Image, left: tuple[float, ...], right: tuple[float, ...]) -> None:
    """Each half one colour, RGBA."""
    width, height = image.size
    texels = np.empty((height, width, 4), np.float32)
    texels[:, : width // 2], texels[:, width // 2 :] = left, right
    texels[..., :3] *= texels[..., 3:]  # as Blender keeps what is painted on float images
    image.pixels.foreach_set(texels.ravel())
    image.update()


def texels_of(image: bpy.types.Image) -> np.ndarray:
    values = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)


def painted(thing: bpy.types.Object) -> bpy.types.Image:
    assert bpy.ops.tyndall.paint_strokes() == {"FINISHED"}
    image = thing.data.tyndall.light_map_fit.views[0].strokes
    paint(image, (1.0, 0.1, 0.1, 1.0), (0.1, 0.1, 1.0, 0.5))
    return image


def rendered() -> np.ndarray:
    """(height, width, 3), of the last of the film's rows first."""
    bpy.context.scene.render.engine = "TYNDALL"
    bpy.context.scene.tyndall.pixel_samples = 1
    bpy.context.scene.render.image_settings.file_format = "OPEN_EXR"
    path = Path(bpy.app.tempdir) / "fit.exr"
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    texels = texels_of(image)[..., :3]
    bpy.data.images.remove(image)
    return texels


def test_strokes_make_an_image_of_the_frames_size_that_is_transparent(sun: bpy.types.Object) -> None:
    assert bpy.ops.tyndall.paint_strokes() == {"FINISHED"}
    (view,) = sun.data.tyndall.light_map_fit.views
    assert view.camera == bpy.context.scene.camera
    assert tuple(view.strokes.size) == (SIZE_PX, SIZE_PX)
    assert view.strokes.is_float
    assert not texels_of(view.strokes).any()
    paint(view.strokes, (1.0, 0.0, 0.0, 1.0), (0.0,) * 4)
    assert bpy.ops.tyndall.paint_strokes() == {"FINISHED"}  # again: what is painted stays
    assert len(sun.data.tyndall.light_map_fit.views) == 1
    assert texels_of(view.strokes).any()


def test_the_fitted_map_becomes_the_gobo_and_the_render_looks_as_it_was_painted(sun: bpy.types.Object) -> None:
    before = rendered()
    painted(sun)
    assert bpy.ops.tyndall.fit_light_map() == {"FINISHED"}
    settings = sun.data.tyndall
    assert tuple(settings.gobo_image.size) == (64, 64)
    assert settings.gobo_image.is_float
    assert settings.gobo_image.packed_file is not None
    residuals = [float(text) for text in settings.light_map_fit.residuals.split()]
    assert residuals[-1] < 0.2 * residuals[0]
    share = (rendered() / before)[4:-4].mean(axis=0)
    assert share[4:12].mean(axis=0) == pytest.approx((1.0, 0.1, 0.1), abs=0.1)
    assert share[-12:-4].mean(axis=0) == pytest.approx((0.1, 0.1, 1.0), abs=0.1)


def test_a_second_fit_writes_to_the_same_image_and_continue_takes_more_steps(sun: bpy.types.Object) -> None:
    strokes = painted(sun)
    settings = sun.data.tyndall
    settings.light_map_fit.steps = 3
    assert bpy.ops.tyndall.fit_light_map() == {"FINISHED"}
    image, first = settings.gobo_image, texels_of(settings.gobo_image)
    key = ImageReader().read(image, Reports(), "").key
    assert len(settings.light_map_fit.residuals.split()) == 4
    assert bpy.ops.tyndall.continue_light_map() == {"FINISHED"}
    residuals = [float(text) for text in settings.light_map_fit.residuals.split()]
    assert len(residuals) == 7
    assert residuals == sorted(residuals, reverse=True)
    assert settings.gobo_image == image
    assert not np.array_equal(texels_of(image), first)
    assert ImageReader().read(image, Reports(), "").key != key  # what a session keeps of it is not drawn again
    paint(strokes, (0.1, 1.0, 0.1, 1.0), (0.1, 1.0, 0.1, 1.0))
    red = texels_of(image)[32, 24:40, 0].mean()
    settings.light_map_fit.steps = 32
    assert bpy.ops.tyndall.fit_light_map() == {"FINISHED"}
    assert settings.gobo_image == image
    assert texels_of(image)[32, 24:40, 0].mean() < 0.5 * red


def test_the_next_fit_takes_over_the_scene_until_another_file_is_opened(sun: bpy.types.Object) -> None:
    painted(sun)
    fit = new_fit(bpy.context, sun.data, sun)
    fit.begin(Progress())
    sun.location.x += 1.0
    bpy.context.view_layer.update()
    again = new_fit(bpy.context, sun.data, sun)
    again.begin(Progress())
    (session,) = fitted_maps._idle_sessions  # noqa: SLF001  what nobody else sees
    assert session.statistics["counts"]["meshes sent"] == 0
    assert session.statistics["counts"]["meshes reused"] > 0
    assert again.fit.light_map.centre_m != fit.fit.light_map.centre_m  # from where the light is now
    bpy.ops.wm.read_homefile(app_template="")
    assert not fitted_maps._idle_sessions  # noqa: SLF001


def test_a_fit_that_was_stopped_goes_on(sun: bpy.types.Object) -> None:
    painted(sun)
    stopped = new_fit(bpy.context, sun.data, sun)
    stopped.begin(Progress())
    keep(sun.data, stopped.fit)  # what Esc does
    assert bpy.ops.tyndall.continue_light_map() == {"FINISHED"}
    assert sun.data.tyndall.gobo_image is not None


def test_an_image_of_the_artists_own_is_not_written_to_but_is_where_the_fit_begins(sun: bpy.types.Object) -> None:
    own = bpy.data.images.new("stained glass", 64, 64, float_buffer=True)
    half_clear = np.array((0.125, 0.25, 0.375, 0.5), np.float32)  # as Blender keeps floats: multiplied with alpha
    own.pixels.foreach_set(np.tile(half_clear, 64 * 64))
    settings = sun.data.tyndall
    settings.gobo_image, settings.gobo_size_m = own, 20.0
    painted(sun)
    before = texels_of(own)
    assert bpy.ops.tyndall.fit_light_map() == {"FINISHED"}
    assert settings.gobo_image != own
    assert np.array_equal(texels_of(own), before)
    assert settings.gobo_size_m == pytest.approx(20.0)  # it covered what the strokes see: it keeps its place
    assert texels_of(settings.gobo_image)[0, 0] == pytest.approx((0.125, 0.25, 0.375, 1.0), abs=1e-3)


def test_everything_is_in_the_file(sun: bpy.types.Object, tmp_path: Path) -> None:
    painted(sun)
    assert bpy.ops.tyndall.fit_light_map() == {"FINISHED"}
    settings = sun.data.tyndall
    strokes, fitted = texels_of(settings.light_map_fit.views[0].strokes), texels_of(settings.gobo_image)
    size_m, offset_m, residuals = settings.gobo_size_m, tuple(settings.gobo_offset_m), settings.light_map_fit.residuals
    name = sun.name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "fit.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "fit.blend"))
    settings = bpy.data.objects[name].data.tyndall
    assert (settings.gobo_size_m, tuple(settings.gobo_offset_m)) == (size_m, offset_m)
    assert settings.light_map_fit.residuals == residuals
    assert texels_of(settings.light_map_fit.views[0].strokes) == pytest.approx(strokes, abs=1e-3)
    assert texels_of(settings.gobo_image) == pytest.approx(fitted, rel=1e-3, abs=1e-3)
    bpy.context.view_layer.objects.active = bpy.data.objects[name]
    assert not bpy.ops.tyndall.continue_light_map.poll()  # what it would go on with was in memory


def test_undo_takes_the_gobo_away(sun: bpy.types.Object) -> None:
    painted(sun)
    name = sun.name
    bpy.ops.ed.undo_push(message="painted")
    assert bpy.ops.tyndall.fit_light_map() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="fitted")
    bpy.ops.ed.undo()
    assert bpy.data.objects[name].data.tyndall.gobo_image is None
    bpy.ops.ed.redo()
    assert bpy.data.objects[name].data.tyndall.gobo_image is not None


def test_several_cameras_have_a_view_each_and_one_that_is_gone_is_left_out(
    sun: bpy.types.Object, capfd: pytest.CaptureFixture[str]
) -> None:
    painted(sun)
    other = camera((2.0, 0.0, 6.0))
    bpy.context.scene.camera = other
    assert bpy.ops.tyndall.fit_view_add() == {"FINISHED"}
    assert bpy.ops.tyndall.paint_strokes() == {"FINISHED"}
    views = sun.data.tyndall.light_map_fit.views
    assert [view.camera.name for view in views] == [views[0].camera.name, other.name]
    paint(views[1].strokes, (0.5, 0.5, 0.5, 1.0), (0.5, 0.5, 0.5, 1.0))
    bpy.data.objects.remove(other)
    assert views[1].camera is None
    assert bpy.ops.tyndall.fit_light_map() == {"FINISHED"}
    sys.stdout.flush()
    assert "left out: it has no camera" in capfd.readouterr().out
    assert bpy.ops.tyndall.fit_view_remove() == {"FINISHED"}
    assert len(views) == 1


def test_what_cannot_be_fitted_is_named(sun: bpy.types.Object) -> None:
    with pytest.raises(RuntimeError, match="nothing is painted"):
        bpy.ops.tyndall.fit_light_map()
    assert bpy.ops.tyndall.paint_strokes() == {"FINISHED"}
    with pytest.raises(RuntimeError, match="nothing is painted"):
        bpy.ops.tyndall.fit_light_map()
    view = sun.data.tyndall.light_map_fit.views[0]
    paint(view.strokes, (1.0,) * 4, (1.0,) * 4)
    view.is_enabled = False
    with pytest.raises(RuntimeError, match="nothing is painted"):
        bpy.ops.tyndall.fit_light_map()
    view.is_enabled = True
    bpy.data.images.remove(view.strokes)
    with pytest.raises(RuntimeError, match="it has no strokes"):
        bpy.ops.tyndall.fit_light_map()
    assert sun.data.tyndall.gobo_image is None
    bpy.context.view_layer.objects.active = light("AREA", (0.0, 0.0, 3.0))
    assert not bpy.ops.tyndall.fit_light_map.poll()


@pytest.fixture(params=["SPOT", "POINT"])
def lamp(request: pytest.FixtureRequest, sun: bpy.types.Object) -> bpy.types.Object:
    """In the sun's place, turned around its beam; a spot is stretched, too."""
    bpy.data.objects.remove(sun)
    thing = light(request.param, (0.4, 0.0, 3.0), energy=500.0)
    thing.rotation_euler = (0.0, 0.0, 0.6)
    if request.param == "SPOT":
        thing.scale = (1.3, 1.0, 1.0)
        thing.data.spot_size, thing.data.spot_blend = 1.9, 0.3
    thing.data.shadow_soft_size = 0.0
    bpy.context.view_layer.objects.active = thing
    thing.data.tyndall.light_map_fit.resolution = 64
    return thing


def test_a_lamps_fitted_map_becomes_its_gobo_and_the_render_looks_as_it_was_painted(lamp: bpy.types.Object) -> None:
    before = rendered()
    painted(lamp)
    bpy.ops.ed.undo_push(message="painted")
    assert bpy.ops.tyndall.fit_light_map() == {"FINISHED"}
    settings = lamp.data.tyndall
    assert tuple(settings.gobo_image.size) == (64, 64)
    assert settings.gobo_image.packed_file is not None
    residuals = [float(text) for text in settings.light_map_fit.residuals.split()]
    assert residuals[-1] < 0.2 * residuals[0]
    share = (rendered() / before)[8:-8].mean(axis=0)
    assert share[6:13].mean(axis=0) == pytest.approx((1.0, 0.1, 0.1), abs=0.1)
    assert share[-13:-6].mean(axis=0) == pytest.approx((0.1, 0.1, 1.0), abs=0.1)
    assert bpy.ops.tyndall.continue_light_map() == {"FINISHED"}
    name = lamp.name
    bpy.ops.ed.undo_push(message="fitted")
    bpy.ops.ed.undo()
    assert bpy.data.objects[name].data.tyndall.gobo_image is None


def test_a_lamp_that_glows_as_a_sphere_is_named(sun: bpy.types.Object) -> None:
    if bpy.app.version < (4, 0, 0):
        pytest.skip("lamps of 3.x are discs")
    bpy.data.objects.remove(sun)
    globe = light("POINT", (0.0, 0.0, 3.0))
    globe.data.use_soft_falloff, globe.data.shadow_soft_size = False, 0.2
    bpy.context.view_layer.objects.active = globe
    painted(globe)
    with pytest.raises(RuntimeError, match="glows as a sphere"):
        bpy.ops.tyndall.fit_light_map()


def test_strokes_of_bytes_and_of_another_size_lie_over_the_same_frame(sun: bpy.types.Object) -> None:
    painted(sun)
    view = sun.data.tyndall.light_map_fit.views[0]
    view.strokes = bpy.data.images.new("bytes", 48, 16, alpha=True)
    texels = np.ones((16, 48, 4), np.float32)
    texels[:, :24, :3], texels[:, 24:, :3] = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    view.strokes.pixels.foreach_set(texels.ravel())
    assert bpy.ops.tyndall.fit_light_map() == {"FINISHED"}
    fitted = texels_of(sun.data.tyndall.gobo_image)
    middle = fitted[28:36]
    assert middle[:, 24:30, 0].mean() > 5 * middle[:, 24:30, 2].mean()
    assert middle[:, 34:40, 2].mean() > 5 * middle[:, 34:40, 0].mean()
