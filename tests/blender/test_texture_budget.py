# SPDX-License-Identifier: GPL-3.0-or-later
"""Images that memory has no room for: the picture is the same, and what is read is not kept twice."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import last_render
from addon.shader_nodes import use_nodes
from addon.sync import texture_budget
from support.engine_pictures import tyndall_pixels
from support.full_disk import largest_file
from support.small_scenes import add, empty_scene, mesh

pytestmark = pytest.mark.dealt

_SIDE_PX = 300  #: No multiple of a tile's.
_RANDOM = np.random.default_rng(7)


def _saved(name: str, folder: Path, *, is_float: bool = False, alpha: bool = True) -> Path:
    """Noise in a file that Blender has not loaded."""
    image = bpy.data.images.new(name, _SIDE_PX, _SIDE_PX, alpha=alpha, float_buffer=is_float)
    pixels = _RANDOM.random((_SIDE_PX, _SIDE_PX, 4), np.float32)
    image.pixels.foreach_set(pixels.ravel())
    path = folder / f"{name}.{'exr' if is_float else 'png'}"
    image.filepath_raw, image.file_format = str(path), "OPEN_EXR" if is_float else "PNG"
    image.save()
    bpy.data.images.remove(image)
    return path


def _material(image: bpy.types.Image, *, has_alpha: bool, interpolation: str) -> bpy.types.Material:
    material = bpy.data.materials.new(image.name)
    use_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    texture, glow = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
    texture.image, texture.interpolation = image, interpolation
    tree.links.new(texture.outputs["Color"], glow.inputs["Color"])
    if has_alpha:
        tree.links.new(texture.outputs["Alpha"], glow.inputs["Strength"])
    tree.links.new(glow.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def _images(folder: Path) -> dict[str, bpy.types.Image]:
    """Bytes and floats from files, some with alpha in use, a packed and a generated one."""
    loaded = {
        name: bpy.data.images.load(str(path))
        for name, path in (
            ("bytes", _saved("bytes", folder)),
            ("bytes and alpha", _saved("bytes and alpha", folder)),
            ("opaque", _saved("opaque", folder, alpha=False)),
            ("floats", _saved("floats", folder, is_float=True)),
            ("floats and alpha", _saved("floats and alpha", folder, is_float=True)),
        )
    }
    packed = bpy.data.images.load(str(_saved("packed", folder)))
    packed.pack()
    generated = bpy.data.images.new("generated", _SIDE_PX, _SIDE_PX)
    generated.generated_type = "COLOR_GRID"
    return loaded | {"packed": packed, "generated": generated}


def _walls(folder: Path) -> bpy.types.Scene:
    """Each image, more than once, on a strip of what the camera sees."""
    scene = empty_scene(48)
    images = _images(folder)
    for index, (name, image) in enumerate(images.items()):
        x0, x1 = (-0.005 + 0.01 * (index + side) / len(images) for side in (0, 1))
        corners = [(x0, -0.005, 0), (x1, -0.005, 0), (x1, 0.005, 0), (x0, 0.005, 0)]
        material = _material(image, has_alpha="alpha" in name, interpolation=("Linear", "Cubic")[index % 2])
        wall = mesh(name, corners, [(0, 1, 2, 3)], material)
        wall.uv_layers.new().data.foreach_set("uv", [-0.3, -0.2, 1.4, -0.2, 1.4, 1.3, -0.3, 1.3])
        add(name, wall)
    return scene


def _counts() -> dict[str, float]:
    counts: dict[str, float] = last_render.statistics_of("Scene")["counts"]
    return counts


def test_images_beyond_the_budget_show_the_same_picture_bit_for_bit(tmp_path: Path) -> None:
    scene = _walls(tmp_path)
    in_memory = tyndall_pixels(scene, mode="RGBA")
    assert "texture tiles read" not in _counts()
    scene.tyndall.texture_budget_mib = 1
    in_file = tyndall_pixels(scene, mode="RGBA")
    counts = _counts()
    assert (in_memory == in_file).all()
    assert len(np.unique(in_memory.reshape(-1, 4), axis=0)) > 1000  # there is something to see
    assert counts["images in a file"] == len(bpy.data.materials) - 1  # that one has room beside the tiles
    assert counts["texture tiles read"] > 0
    assert 0 < counts["texture tiles in memory, MiB"] <= counts["texture tiles in memory at most, MiB"] == 0.5


def test_blender_does_not_keep_what_only_the_render_has_read(tmp_path: Path) -> None:
    scene = _walls(tmp_path)
    edited, shown = bpy.data.images["bytes.png"], bpy.data.images["opaque.png"]
    edited.pixels[0] = 0.5
    assert shown.size[0] == _SIDE_PX  # which loads it
    for _ in range(2):  # the second time nothing is read anew
        tyndall_pixels(scene)
        held = {image.name for image in bpy.data.images if image.has_data}
        assert held >= {edited.name, shown.name, "generated"}
        assert not held & {"bytes and alpha.png", "floats.exr", "floats and alpha.exr"}
    assert edited.is_dirty


def test_an_image_that_changes_between_frames_is_read_again(tmp_path: Path) -> None:
    scene = _walls(tmp_path)
    scene.tyndall.texture_budget_mib = 1
    scene.render.use_persistent_data = True
    before = tyndall_pixels(scene)
    assert (tyndall_pixels(scene) == before).all()
    bpy.data.images["generated"].generated_type = "BLANK"
    after = tyndall_pixels(scene)
    strips = np.abs(after - before).max(axis=(0, 2)) > 0.0
    assert strips[-6:].all()  # that of the generated image
    assert not strips[:-8].any()
    scene.tyndall.texture_budget_mib = 0
    assert (tyndall_pixels(scene) == after).all()
    assert "texture tiles read" not in _counts()


def test_a_full_disk_is_one_error_that_names_image_and_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = _walls(tmp_path)
    scene.tyndall.texture_budget_mib = 1
    monkeypatch.setattr(texture_budget, "folder", lambda: str(tmp_path))
    with largest_file(100_000), pytest.raises(RuntimeError) as caught:
        tyndall_pixels(scene)
    message = str(caught.value)
    assert len(set(message.strip().splitlines())) == 1
    assert 'image "bytes.png"' in message
    assert str(tmp_path) in message
    assert not list(tmp_path.glob("tyndall-texels*"))  # not even while it is in use
    monkeypatch.setattr(texture_budget, "folder", lambda: str(tmp_path / "nowhere"))
    with pytest.raises(RuntimeError, match="nowhere: no room for textures: No such file"):
        tyndall_pixels(scene)


def test_by_itself_the_budget_is_half_of_the_machines_memory() -> None:
    scene = empty_scene()
    assert scene.tyndall.texture_budget_mib == 0
    words = Path("/proc/meminfo").read_text(encoding="ascii").split()
    of_machine = 1024 * int(words[words.index("MemTotal:") + 1])
    assert texture_budget.budget_bytes(scene) == pytest.approx(of_machine / 2, rel=1e-3)
    scene.tyndall.texture_budget_mib = 3
    assert texture_budget.budget_bytes(scene) == 3 << 20
