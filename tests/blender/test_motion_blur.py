# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: the mean over a shutter's time, of everything that Blender animates, as Cycles has it where it blurs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from addon import last_render
from addon.engine import film_parts, final
from addon.shutter_position import position_settings
from support.cycles_reference import (
    rendered_pixels,
)
from support.exr import read_planes
from support.moving_scenes import (
    FRAME,
    SIZE_PX,
    Scene,
    add_mesh,
    animate,
    blurred,
    counts,
    curves_of,
    mean_of_stills,
    middles,
    move,
    move_lens,
    move_light,
    move_occluder_in_fog,
    new_stage,
    reports,
    set_position,
)

pytestmark = pytest.mark.dealt


@pytest.fixture
def stage() -> Scene:
    """A bright wall, seen from above at frame 10."""
    return new_stage()


@pytest.mark.parametrize(("position", "opens"), [("START", 0.0), ("CENTER", -0.5), ("END", -1.0)])
def test_an_edge_that_moves_evenly_is_a_ramp(stage: Scene, position: str, opens: float) -> None:
    """A pixel is covered for the share of the shutter's time in which the edge is beyond it."""
    if position_settings(stage) is None:
        pytest.skip("Cycles, which keeps the position before 4.2, is not enabled")
    bar = add_mesh(stage, "bar", (1, 4, 0.1), (0, 0, 1), glow=1.0)
    animate(bar, "location", (-2.0, 0, 1), (2.0, 0, 1))  # 2 m per frame; its right edge is at x + 1
    stage.frame_set(FRAME)
    set_position(stage, position)
    bpy.data.objects["wall"].hide_render = True
    row = blurred(stage, 64)[SIZE_PX // 2, :, 0]
    at = (np.arange(SIZE_PX) + 0.5) * 4 / SIZE_PX - 2
    fine = 2.0 * np.array(middles(10_000, opens, opens + 1.0))
    share = (np.abs(at[:, None] - fine) < 1).mean(axis=1)
    assert np.abs(row - share).max() <= 1 / 64, "an edge in time is known to half a moment, and there are two"
    assert counts(stage)["motion blur: renders"] == 64


def test_where_nothing_changes_the_picture_is_that_without_blur(stage: Scene) -> None:
    """Bit for bit, and the statistics say why; also where something is animated that does not move now."""
    bar = add_mesh(stage, "bar", (1, 1, 0.1), (0, 0, 1))
    animate(bar, "location", (0, 0, 1), (1, 0, 1), frames=(20, 30))
    for curve in curves_of(bar):
        curve.extrapolation = "CONSTANT"
    stage.frame_set(FRAME)
    still = blurred(stage)
    assert counts(stage)["motion blur: renders"] == 1
    skipped = (last_render.statistics_of(stage.name) or {})["skipped"]
    assert {
        "what": "motion blur",
        "reason": "nothing that the picture shows changes while the shutter is open",
    } in skipped
    stage.render.use_motion_blur = False
    assert np.array_equal(still, blurred(stage))
    assert "motion blur: renders" not in counts(stage)


def test_moments_that_look_alike_are_one_render(stage: Scene) -> None:
    """What moves in the second half of the shutter's time alone."""
    bar = add_mesh(stage, "bar", (1, 1, 0.1), (0, 0, 1))
    animate(bar, "location", (0, 0, 1), (1, 0, 1), frames=(FRAME, FRAME + 1))
    for curve in curves_of(bar):
        curve.extrapolation = "CONSTANT"
    stage.frame_set(FRAME)
    picture = blurred(stage)
    assert counts(stage)["motion blur: moments"] == 16
    assert counts(stage)["motion blur: renders"] == 9
    assert counts(stage)["meshes sent"] == 2, "of 9 renders"
    assert np.abs(picture - mean_of_stills(stage, middles(16, -0.5, 0.5))).mean() < 1e-3


CHANGES: dict[str, Callable[[Scene], None]] = {
    "light": move_light,
    "lens": move_lens,
    "fog": move_occluder_in_fog,
}


@pytest.mark.parametrize("name", CHANGES)
def test_all_that_is_animated_blurs(stage: Scene, name: str) -> None:
    """The mean of pictures at the moments, of surfaces, lights, lenses and shafts, at the centres of pixels."""
    CHANGES[name](stage)
    stage.frame_set(FRAME)
    picture = blurred(stage)
    assert counts(stage)["motion blur: renders"] == 16
    expected = mean_of_stills(stage, middles(16, -0.5, 0.5))
    off = np.abs(picture - expected).max(axis=2) / expected.mean()
    assert np.median(off) < 2e-4
    assert (off > 2e-3).mean() < 0.05, "an edge within 0.005 px of a centre is on either side"
    stage.render.use_motion_blur = False
    assert np.abs(picture - blurred(stage)).max() > 0.2 * expected.mean(), "the blur is seen"


def test_the_strata_of_a_soft_light_are_dealt_out_to_the_moments(stage: Scene) -> None:
    """Each moment prepares few; its picture's mean has all, with what moves in the light, and with what does not."""
    move_occluder_in_fog(stage)
    lamp = next(thing for thing in stage.objects if thing.type == "LIGHT")
    lamp.data.type = "POINT"  # the stage's is a sun without a size
    lamp.location, lamp.data.energy, lamp.data.shadow_soft_size = (0.5, 0.2, 4.0), 400.0, 0.5
    stage.tyndall.shafts.light_samples = 64
    stage.frame_set(FRAME)
    blurred_picture = blurred(stage)
    of_moments = counts(stage)["light shafts: light samples"]
    expected = mean_of_stills(stage, middles(16, -0.5, 0.5))
    of_still = counts(stage)["light shafts: light samples"]
    assert of_still >= 32
    assert of_moments <= of_still / 8
    off = np.abs(blurred_picture - expected).max(axis=2) / expected.mean()
    assert np.median(off) < 1e-3
    assert np.percentile(off, 90) < 4e-3
    assert abs(blurred_picture.mean() / expected.mean() - 1) < 2e-4


def test_places_are_of_the_middle_and_mattes_of_all_moments(stage: Scene, tmp_path: Path) -> None:
    """A ball above a wall: Depth is a picture without blur; shares of the ball add up to its blurred cover."""
    bar = add_mesh(stage, "bar", (1, 4, 0.5), (0, 0, 1))
    animate(bar, "location", (-2.0, 0, 1), (2.0, 0, 1))
    stage.frame_set(FRAME)
    layer = stage.view_layers[0]
    layer.use_pass_z = layer.use_pass_cryptomatte_object = layer.use_pass_object_index = True
    bar.pass_index = 3
    stage.tyndall.pixel_samples = stage.tyndall.motion_steps = 32
    planes = passes_of(stage, tmp_path)
    middle = 2.0 * 0.5 / 32  # m, of the moment that the sample behind the middle sees
    at = (np.arange(SIZE_PX) + 0.5) * 4 / SIZE_PX - 2
    is_bar = np.abs(at - middle) < 1
    assert np.allclose(planes["Depth"][SIZE_PX // 2, :, 0], np.where(is_bar, 4.5, 6.0), atol=1e-3)
    assert np.array_equal(planes["IndexOB"][SIZE_PX // 2, :, 0], np.where(is_bar, 3.0, 0.0))
    pairs = planes["CryptoObject00"][SIZE_PX // 2].reshape(SIZE_PX, 2, 2)
    both = pairs[(pairs[..., 1] > 0.2).all(axis=1)]
    assert len(both) > 4
    assert np.allclose(both[..., 1].sum(axis=1), 1.0, atol=1e-5)
    assert (both[:, 0, 1] >= both[:, 1, 1]).all(), "ranked by share"
    assert len(np.unique(both[..., 0])) == 2


def passes_of(scene: Scene, folder: Path) -> dict[str, NDArray[np.float32]]:
    """As files hold them, under the names of 4.5."""
    settings = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth, settings.exr_codec = "32", "NONE"
    scene.render.use_compositing = False
    scene.render.filepath = str(folder / "passes.exr")
    bpy.ops.render.render(write_still=True, scene=scene.name)
    planes = {name.partition(".")[2]: plane for name, plane in read_planes(Path(scene.render.filepath)).items()}
    return {{"Object Index": "IndexOB"}.get(name, name): plane for name, plane in planes.items()}


def test_a_view_layer_may_stay_sharp(stage: Scene) -> None:
    move(stage)
    stage.frame_set(FRAME)
    if not hasattr(stage.view_layers[0], "use_motion_blur"):
        pytest.skip("view layers of this version have no such setting")
    stage.view_layers[0].use_motion_blur = False
    sharp = blurred(stage)
    stage.render.use_motion_blur = False
    assert np.array_equal(sharp, blurred(stage))


def test_what_is_not_followed_is_reported(stage: Scene) -> None:
    if not hasattr(stage, "cycles"):
        pytest.skip("Cycles, whose settings these are, is not enabled")
    move(stage)
    stage.frame_set(FRAME)
    ball = bpy.context.object
    ball.cycles.use_motion_blur = False
    stage.cycles.rolling_shutter_type = "TOP"
    blurred(stage)
    assert f'Object "{ball.name}": its motion blur is off' in reports(stage)
    assert "its shutter rolls, which is not followed" in reports(stage)


def test_absurd_shutters_render(stage: Scene) -> None:
    """Blender's frames have an end."""
    move(stage)
    stage.frame_set(FRAME)
    for shutter in (0.0, 1e30):
        stage.render.motion_blur_shutter = shutter
        assert np.isfinite(blurred(stage, 4)).all()


def test_the_frame_is_back_after_esc(stage: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    move(stage)
    stage.frame_set(FRAME)
    asked = 0

    def is_esc_pressed(_engine: bpy.types.RenderEngine) -> bool:
        nonlocal asked
        asked += 1
        return asked > 20

    monkeypatch.setattr(final, "is_esc_pressed", is_esc_pressed)
    stage.tyndall.pixel_samples = stage.tyndall.motion_steps = 64
    bpy.ops.render.render(scene=stage.name)
    assert (stage.frame_current, stage.frame_subframe) == (FRAME, 0.0)


def test_the_frame_is_back_after_an_error(stage: Scene) -> None:
    """The camera has no size any more in the second half of the shutter's time."""
    animate(stage.camera, "scale", (1, 1, 1), (0, 0, 0), frames=(FRAME, FRAME + 1))
    for curve in curves_of(stage.camera):
        for key in curve.keyframe_points:
            key.interpolation = "CONSTANT"
    stage.frame_set(FRAME)
    set_position(stage, "START")
    stage.render.motion_blur_shutter = 2.0
    with pytest.raises(RuntimeError, match="its scale is 0"):
        bpy.ops.render.render(scene=stage.name)
    assert (stage.frame_current, stage.frame_subframe) == (FRAME, 0.0)


def test_image_sequences_show_the_picture_of_the_frame(stage: Scene, tmp_path: Path) -> None:
    """As in Cycles, although half of the shutter's time is the frame before."""
    for frame in (FRAME - 1, FRAME):
        image = bpy.data.images.new("grey", 2, 2)
        image.pixels = [0.2 if frame == FRAME else 0.8] * 3 * 4 + [1.0] * 4
        image.filepath_raw, image.file_format = str(tmp_path / f"grey_{frame:04d}.png"), "PNG"
        image.save()
    card = add_mesh(stage, "card", (1, 1, 0.1), (0, 0, 1), glow=1.0)
    tree = card.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.load(str(tmp_path / f"grey_{FRAME:04d}.png"))
    node.image.source = "SEQUENCE"
    user = node.image_user
    user.frame_start, user.frame_duration, user.use_auto_refresh, user.frame_offset = 1, 20, True, 0
    emission = next(one for one in tree.nodes if one.type == "EMISSION")
    tree.links.new(node.outputs[0], emission.inputs["Color"])
    animate(emission.inputs["Strength"], "default_value", 0.0, 2.0, owner=tree)
    stage.frame_set(FRAME)
    picture = blurred(stage)
    assert counts(stage)["motion blur: renders"] == 16
    stage.render.use_motion_blur = False
    still = blurred(stage)
    middle = SIZE_PX // 2
    assert picture[middle, middle] == pytest.approx(still[middle, middle], rel=1e-4)


def test_tiles_put_together_are_the_frame(stage: Scene) -> None:
    """Farms' parts: bit for bit."""
    move(stage)
    stage.frame_set(FRAME)
    stage.tyndall.pixel_samples = stage.tyndall.motion_steps = 4

    def planes_of(tile: film_parts.Tile) -> NDArray[np.float32]:
        part = film_parts.Taking(stage.name, stage.view_layers[0].name, tile)
        with film_parts.taking(part):
            bpy.ops.render.render(scene=stage.name)
        return part.films[""]["Combined"]

    whole = planes_of(film_parts.Tile(0, 0, 1, 1))
    halves = [planes_of(film_parts.Tile(column, 0, 2, 1)) for column in (0, 1)]
    assert counts(stage)["motion blur: renders"] == 4
    assert np.array_equal(np.concatenate(halves, axis=1), whole)


def test_an_animation_keeps_its_maps(stage: Scene, tmp_path: Path) -> None:
    """Frames of an animation are those of stills, blurred or not."""
    move_occluder_in_fog(stage)
    stage.tyndall.pixel_samples = stage.tyndall.motion_steps = 4
    stage.tyndall.shafts.method = "EPIPOLAR"
    stage.frame_start, stage.frame_end = FRAME, FRAME + 1
    settings = stage.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR", "32", "NONE"
    stage.render.filepath = str(tmp_path / "frame_")
    bpy.ops.render.render(animation=True, scene=stage.name)
    for frame in (FRAME, FRAME + 1):
        of_animation = read_planes(tmp_path / f"frame_{frame:04d}.exr")[""]
        stage.frame_set(frame)
        assert np.allclose(rendered_pixels(stage), of_animation[..., :3], rtol=1e-5, atol=1e-6)
