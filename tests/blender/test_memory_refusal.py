# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture that memory has no room for is refused before the scene is read, and no file is touched."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from addon.engine import film_parts, final
from support.small_scenes import empty_scene, material, plane
from tyndall import memory_estimate
from tyndall._image_io import write_png


def test_a_picture_without_room_is_an_error_that_says_what_to_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory_estimate, "free_bytes", lambda: 100 << 20)
    monkeypatch.setattr(final, "LookReader", lambda **_: pytest.fail("the scene was read"))
    scene = empty_scene(3000)
    plane()
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(tmp_path / "picture.png")
    with pytest.raises(RuntimeError, match=r"3000 x 3000 pixels takes 0\.3 GiB .* 0\.1 GiB are free: lower the resol"):
        bpy.ops.render.render(write_still=True)
    assert not list(tmp_path.iterdir())


def test_memory_that_ends_amid_a_render_is_told_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the native core it says "std::bad_alloc"."""
    scene = empty_scene(8)
    scene.tyndall.pixel_samples = 1
    with monkeypatch.context() as short_of_memory:
        short_of_memory.setattr(final, "LookReader", lambda **_: np.empty(1 << 59))
        with pytest.raises(RuntimeError, match="no memory left for this: try a smaller picture"):
            bpy.ops.render.render()
    bpy.ops.render.render()


def test_a_tile_takes_no_room_for_the_frame_around_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seen to fail where the whole frame was asked for: farms cut into tiles what one machine has no room for."""
    monkeypatch.setattr(memory_estimate, "free_bytes", lambda: 100 << 20)
    scene = empty_scene(3000)
    scene.tyndall.pixel_samples = 1
    plane()
    tile = film_parts.Tile(column=0, row=0, columns=16, rows=16)
    part = film_parts.Taking(scene_name=scene.name, layer_name=bpy.context.view_layer.name, tile=tile)
    with film_parts.taking(part):
        bpy.ops.render.render()
    (planes,) = part.films.values()
    assert planes["Combined"].shape == (187, 187, 4)


@pytest.mark.parametrize("place", ["file", "packed", "generated"])
def test_an_image_without_room_is_refused_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    scene = empty_scene(8)
    scene.tyndall.pixel_samples = 1
    image = bpy.data.images.new("wall.png", 64, 64)
    if place != "generated":
        write_png(tmp_path / "wall.png", np.zeros((64, 64, 4), np.uint8))
        image = bpy.data.images.load(str(tmp_path / "wall.png"))
    if place == "packed":
        image.pack()

    def shows_it(new: Callable[[str], Any], link: Callable[..., Any]) -> object:
        texture, emission = new("ShaderNodeTexImage"), new("ShaderNodeEmission")
        texture.image = image
        link(texture.outputs["Color"], emission.inputs["Color"])
        return emission.outputs[0]

    plane(material=material("shows it", shows_it))
    monkeypatch.setattr(memory_estimate, "_CHECKED_FROM_BYTES", 0)
    bpy.ops.render.render()  # which has room
    monkeypatch.setattr(memory_estimate, "free_bytes", lambda: 12_000)
    with pytest.raises(RuntimeError, match=r'image "wall\.png.*" of 64 x 64 pixels takes .* scale it down'):
        bpy.ops.render.render()
