# SPDX-License-Identifier: GPL-3.0-or-later
"""The final render as Blender sees it: sizes, passes, layers, animation, Esc and errors."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from addon import last_render
from addon.engine import failures, final, sessions
from support.exr import read_channels, read_planes
from support.small_scenes import add, cube, empty_scene, light, material, mesh, node, plane
from tyndall.renderer import Session

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture
def stage(tmp_path: Path) -> bpy.types.Scene:
    """A cube on a plane under a sun, 40 x 20 pixels, one ray each, written as a bare float EXR."""
    scene = empty_scene()
    scene.render.resolution_x, scene.render.resolution_y = 40, 20
    scene.camera.location, scene.camera.rotation_euler = (0, -8, 6), (0.9, 0, 0)
    scene.camera.data.type = "PERSP"
    grey = material(
        "Grey", surface=lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.5, 0.4, 0.3, 1)).outputs[0]
    )
    cube(material=grey).location.z = 1
    plane(material=grey)
    light("SUN", (0, 0, 5), energy=3.0).rotation_euler = (0.5, 0.3, 0)
    scene.tyndall.pixel_samples = 1
    scene.render.filepath = str(tmp_path / "frame.exr")
    set_format(scene, multilayer=False)
    return scene


def set_format(scene: bpy.types.Scene, *, multilayer: bool) -> None:
    settings = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER" if multilayer else "OPEN_EXR"
    settings.color_mode, settings.color_depth, settings.exr_codec = "RGBA", "32", "NONE"


def picture(scene: bpy.types.Scene) -> NDArray[np.float32]:
    """Render Combined to a file, and give its pixels: (height, width, 4)."""
    bpy.ops.render.render(write_still=True)
    return read_planes(Path(scene.render.filepath))[""]


def test_a_border_shows_the_same_pixels_as_the_whole_frame(stage: bpy.types.Scene) -> None:
    """Cropped, it is that part of the frame alone; not cropped, the rest is empty."""
    whole = picture(stage)
    assert whole.shape == (20, 40, 4)
    assert whole[..., :3].max() > 0.1
    render = stage.render
    render.use_border, render.use_crop_to_border = True, True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.3, 0.7, 0.1, 0.6
    inside = (slice(2, 12), slice(12, 28))
    assert np.array_equal(picture(stage), whole[inside])
    render.use_crop_to_border = False
    framed = picture(stage)
    assert np.array_equal(framed[inside], whole[inside])
    framed[inside] = 0
    assert not framed.any()


def test_the_resolution_percentage_scales_the_frame(stage: bpy.types.Scene) -> None:
    stage.render.resolution_percentage = 50
    assert picture(stage).shape == (10, 20, 4)


def test_film_transparent_leaves_the_sky_out(stage: bpy.types.Scene) -> None:
    stage.camera.rotation_euler.x = math.radians(80)  # a horizon
    stage.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.2, 0.3, 1)
    opaque = picture(stage)
    assert (opaque[..., 3] == 1).all()
    assert opaque[-1, 0, :3] == pytest.approx((0.1, 0.2, 0.3))
    stage.render.film_transparent = True
    transparent = picture(stage)
    assert set(np.unique(transparent[..., 3])) == {0, 1}
    assert not transparent[-1, 0].any()


def test_passes_arrive_under_the_names_of_the_version(stage: bpy.types.Scene) -> None:
    """Each holds what it says: geometry from the camera's point of view, colours of the material."""
    layer = stage.view_layers[0]
    for name in ("z", "position", "normal", "diffuse_color", "emit"):
        setattr(layer, f"use_pass_{name}", True)
    for name in ("shafts", "shafts_visibility", "transmittance"):
        setattr(layer.tyndall, f"use_pass_{name}", True)
    set_format(stage, multilayer=True)
    bpy.ops.render.render(write_still=True)
    planes = {name.partition(".")[2]: plane for name, plane in read_planes(Path(stage.render.filepath)).items()}
    is_5 = bpy.app.version >= (5, 0, 0)
    diffuse, emission = ("Diffuse Color", "Emission") if is_5 else ("DiffCol", "Emit")
    expected = {"Combined", "Depth", "Position", "Normal", diffuse, emission, "Shafts", "Shafts Visibility"}
    assert expected | {"Transmittance"} == set(planes)
    middle = (10, 20)
    camera = np.array(stage.camera.matrix_world.translation)
    assert planes["Depth"][middle][0] == pytest.approx(np.linalg.norm(planes["Position"][middle] - camera), rel=0.01), (
        "in the middle of the frame, depth and distance are one"
    )
    assert planes[diffuse][middle] == pytest.approx((0.5, 0.4, 0.3))
    assert np.linalg.norm(planes["Normal"][middle]) == pytest.approx(1.0)
    assert not planes["Shafts"].any()
    assert (planes["Transmittance"] == 1).all()


def test_each_view_layer_shows_its_own_collections(stage: bpy.types.Scene) -> None:
    extra = bpy.data.collections.new("Extra")
    stage.collection.children.link(extra)
    blocker = bpy.data.objects.new(
        "Wall", mesh("Wall", [(-9, -5, 0), (9, -5, 0), (9, -5, 9), (-9, -5, 9)], [(0, 1, 2, 3)])
    )
    extra.objects.link(blocker)
    second = stage.view_layers.new("Without")
    second.layer_collection.children["Extra"].exclude = True
    for layer in stage.view_layers:
        layer.use_pass_z = True
    set_format(stage, multilayer=True)
    bpy.ops.render.render(write_still=True)
    planes = read_planes(Path(stage.render.filepath))
    with_wall, without_wall = (planes[f"{layer.name}.Depth"] for layer in stage.view_layers)
    assert (with_wall < without_wall).all()


def test_an_animation_sends_geometry_once(stage: bpy.types.Scene, tmp_path: Path) -> None:
    """Only the camera moves: the second frame sends and rebuilds nothing; three pictures, all different."""
    stage.frame_end = 3
    for frame in (1, 3):
        stage.camera.location.x = frame
        stage.camera.keyframe_insert("location", frame=frame)
    stage.render.filepath = str(tmp_path / "anim_")
    counts = []

    def note(scene: bpy.types.Scene, *_: object) -> None:
        counts.append(last_render.statistics_of(scene.name)["counts"])

    bpy.app.handlers.render_post.append(note)
    try:
        bpy.ops.render.render(animation=True)
    finally:
        bpy.app.handlers.render_post.remove(note)
    pictures = [read_channels(tmp_path / f"anim_{frame:04d}.exr")["R"] for frame in (1, 2, 3)]
    assert not np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[1], pictures[2])
    assert [count["meshes sent"] for count in counts] == [2, 0, 0]
    assert [count.get("scene rebuilt", 0) for count in counts] == [1, 0, 0]
    assert not sessions._kept, "nothing is kept after the last frame"  # noqa: SLF001


def test_esc_while_the_scene_is_read(stage: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """No native render begins, nobody reports an error, and the next render is whole."""
    went_on: list[object] = []
    monkeypatch.setattr(final, "_POLL_S", 0.0)
    monkeypatch.setattr(final, "is_esc_pressed", lambda _engine: True)
    monkeypatch.setattr(Session, "update", lambda *_: went_on.append(True))
    bpy.ops.render.render()
    assert not went_on
    assert failures.last_error() is None
    monkeypatch.undo()
    assert picture(stage)[..., :3].any()


def test_esc_while_the_native_side_renders(stage: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """The native call, here one that begins anew until it is told to stop, hears of it."""
    outcomes: list[str] = []
    original = Session.render

    def rendering(session: Session, *arguments: Any) -> None:
        outcomes.append("began")
        try:
            for _ in range(100_000):
                original(session, *arguments)
        except Exception as error:
            outcomes.append(type(error).__name__)
            raise

    monkeypatch.setattr(Session, "render", rendering)
    monkeypatch.setattr(final, "is_esc_pressed", lambda _engine: bool(outcomes))
    bpy.ops.render.render()
    assert outcomes == ["began", "Cancelled"]
    assert failures.last_error() is None


def test_ctrl_c_stops_the_native_side_and_is_told(stage: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of scripts: the frame is delivered, the thread has ended, and the caller gets an exception."""

    def interrupt(_engine: bpy.types.RenderEngine) -> bool:
        raise KeyboardInterrupt

    monkeypatch.setattr(final, "is_esc_pressed", interrupt)
    stage.tyndall.pixel_samples, stage.tyndall.noise_threshold = 65536, 0.0
    threads = threading.active_count()
    with pytest.raises(RuntimeError, match="interrupted"):
        bpy.ops.render.render(write_still=True)
    assert threading.active_count() == threads
    assert not Path(stage.render.filepath).exists()


def test_an_error_is_an_exception_and_leaves_no_picture(stage: bpy.types.Scene) -> None:
    """Blender crashes if it is to save an EXR of a render that delivered no frame, even a cancelled one."""
    stage.camera.location.x = math.nan
    with pytest.raises(RuntimeError, match="Camera"):
        bpy.ops.render.render(write_still=True)
    assert "Camera" in failures.last_error()
    assert not Path(stage.render.filepath).exists()
    stage.camera.location.x = 0
    bpy.ops.render.render()
    assert failures.last_error() is None


def test_an_error_of_ours_in_python_is_an_exception_too(
    stage: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    from addon.sync.scene import SceneReader  # noqa: PLC0415

    def broken(*_: object, **__: object) -> None:
        raise KeyError("planted")

    monkeypatch.setattr(SceneReader, "read", broken)
    with pytest.raises(RuntimeError, match="planted"):
        bpy.ops.render.render(write_still=True)


def test_what_was_replaced_is_reported_once(stage: bpy.types.Scene) -> None:
    """An unknown node never fails a render."""
    odd = material("Odd", surface=lambda new, _: node(new, "ShaderNodeBsdfGlass").outputs[0])
    cube("Odd cube", odd)
    cube("Odd cube again", odd)
    add("Hair", bpy.data.hair_curves.new("Hair") if hasattr(bpy.data, "hair_curves") else None)
    bpy.ops.render.render()
    reports = last_render.statistics_of(stage.name)["reports"]
    assert sum('Material "Odd"' in line for line in reports) == 1


@pytest.mark.skipif(not bpy.app.binary_path or getattr(bpy.app, "module", False), reason="bpy has no command line")
@pytest.mark.parametrize("is_broken", [False, True])
def test_blenders_command_line_ends_with_an_exit_code(
    stage: bpy.types.Scene, tmp_path: Path, *, is_broken: bool
) -> None:
    """``blender -b file -E TYNDALL -f 1``: 0 and a picture, or 1 and the reason."""
    if is_broken:
        stage.camera.location.x = math.nan
    blend = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True)
    enable = (
        f"import sys; sys.path[:0] = {[str(REPOSITORY / folder) for folder in ('python', 'build/release/python')]!r};"
        "import tyndall.blender; tyndall.blender.enable()"
    )
    command = [bpy.app.binary_path, "-b", "--factory-startup", "--python-expr", enable, str(blend)]
    command += ["-E", "TYNDALL", "-o", str(tmp_path / "out_"), "-F", "OPEN_EXR", "-f", "1"]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=120, check=False, env={"PATH": "/usr/bin:/bin"}
    )
    assert done.returncode == int(is_broken), done.stdout + done.stderr
    if is_broken:
        assert "Camera" in done.stdout + done.stderr
    else:
        assert (tmp_path / "out_0001.exr").is_file()


def test_the_process_ends_clean_although_nobody_unregistered(tmp_path: Path) -> None:
    """A RenderEngine class that is still registered at exit crashes bpy 4.2 and hangs bpy 4.5; ``enable`` helps."""
    if not getattr(bpy.app, "module", False):
        pytest.skip("only the bpy module has this trap")
    script = tmp_path / "script.py"
    script.write_text(
        "import bpy, tyndall.blender\n"
        "tyndall.blender.enable()\n"
        "bpy.context.scene.render.engine = 'TYNDALL'\n"
        "bpy.context.scene.render.resolution_percentage = 2\n"
        "for _ in range(3):\n"
        "    twig = bpy.data.objects.new('Twig', None)\n"
        "    twig.instance_type, twig.instance_collection = 'COLLECTION', bpy.data.collections['Collection']\n"
        "    bpy.context.scene.collection.objects.link(twig)\n"
        "bpy.ops.render.render()\n"
    )
    environment = {
        "PYTHONPATH": f"{REPOSITORY / 'python'}:{REPOSITORY / 'build/release/python'}",
        "PATH": "/usr/bin:/bin",
    }
    command = [sys.executable, str(script)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, env=environment)
    assert done.returncode == 0
    assert "Not freed memory" not in done.stdout + done.stderr
