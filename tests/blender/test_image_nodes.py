# SPDX-License-Identifier: GPL-3.0-or-later
"""Images at any vector, and normals that images and heights bend, are what Cycles makes of them."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import last_render
from support.engine_pictures import tyndall_pixels
from support.image_setups import IMAGES, NORMALS, mapped
from support.patch_nodes import Link, New, Shown, Socket, patch_scene, shown_on_patches
from support.small_scenes import empty_scene, material, node, plane, read

#: A picture of Cycles is up to a hundredth of a pixel off its pixels' centres, and its textures are steep here.
BOUND = 0.02


@pytest.fixture(scope="module")
def images() -> dict[str, Shown]:
    return shown_on_patches(IMAGES)


# Seen to fail with half of what the sides of a box blend.
@pytest.mark.parametrize("name", IMAGES)
def test_an_image_is_read_as_in_cycles(images: dict[str, Shown], name: str) -> None:
    # Where texels, sides or borders jump, a pixel's centre may lie on either side.
    share = 0.9 if name in {"closest", "sphere", "tube", "box", "environment", "alpha of a clipped one"} else 1.0
    shown = images[name]
    assert shown.off(share) < BOUND, np.abs(shown.ours - shown.cycles).max(axis=1)


@pytest.fixture(scope="module", params=[False, True], ids=["smooth", "flat"])
def normals(request: pytest.FixtureRequest) -> dict[str, Shown]:
    return shown_on_patches(NORMALS, is_flat=request.param)


# Seen to fail with the two places beside a point swapped, and with tangents whose other side is the wrong one.
@pytest.mark.parametrize("name", NORMALS)
def test_a_normal_is_bent_as_in_cycles(normals: dict[str, Shown], name: str) -> None:
    shown = normals[name]
    assert shown.off(0.95) < BOUND, np.abs(shown.ours - shown.cycles).max(axis=1)
    lengths = np.linalg.norm(shown.ours, axis=1)
    if name != "layer weight of a bump":
        assert lengths == pytest.approx(np.ones(len(lengths)), abs=1e-4)


def test_a_normal_map_without_its_uv_map_is_named() -> None:
    tyndall_pixels(patch_scene({"Bare": mapped("TANGENT", uv_map="Nothing")}))
    reports = [line for line in last_render.statistics_of("Scene")["reports"] if "tangents" in line]
    assert len(reports) == 1
    assert "Patch Bare" in reports[0]
    assert "Nothing" in reports[0]


def test_a_normal_map_that_bends_nothing_asks_for_no_uv_map() -> None:
    def unbent(new: New, _: Link) -> Socket:
        created = new("ShaderNodeNormalMap")
        created.uv_map = "Nothing"
        return created.outputs[0]

    shown = shown_on_patches({"unbent": unbent})["unbent"]
    assert shown.off() < BOUND
    assert not [line for line in last_render.statistics_of("Scene")["reports"] if "tangents" in line]


def test_a_bump_of_an_even_height_is_none() -> None:
    """That of an image whose file is missing, most of all: nothing of it is left out."""

    def even(new: New, link: Link) -> Socket:
        diffuse, bump = new("ShaderNodeBsdfDiffuse"), node(new, "ShaderNodeBump", Height=0.7)
        link(bump.outputs["Normal"], diffuse.inputs["Normal"])
        return diffuse.outputs[0]

    empty_scene()
    plane(material=material("Even", even))
    assert read().reports == ()


def test_tiles_and_frames_come_from_their_files(tmp_path: Path) -> None:
    """Beside Cycles: two tiles of a UV map, and the third frame of a sequence."""
    for number, colour in (("1001", (0.2, 0.4, 0.6, 1)), ("1002", (0.9, 0.3, 0.1, 1)), ("0003", (0.1, 0.8, 0.3, 1))):
        created = bpy.data.images.new(number, 4, 4)
        created.generated_color = colour
        created.filepath_raw, created.file_format = str(tmp_path / f"tile.{number}.png"), "PNG"
        created.save()

    def tiled(new: New, link: Link) -> Socket:
        texture, moved = new("ShaderNodeTexImage"), new("ShaderNodeVectorMath")
        texture.image = bpy.data.images.load(str(tmp_path / "tile.1001.png"))
        texture.image.source = "TILED"
        texture.image.filepath = str(tmp_path / "tile.<UDIM>.png")
        texture.image.tiles.new(1002)
        moved.operation = "MULTIPLY_ADD"
        moved.inputs[1].default_value, moved.inputs[2].default_value = (2.0, 1.0, 0.0), (0.0, 0.0, 0.0)
        link(new("ShaderNodeTexCoord").outputs["UV"], moved.inputs[0])
        link(moved.outputs[0], texture.inputs["Vector"])
        return texture.outputs[0]

    def framed(new: New, _: Link) -> Socket:
        texture = new("ShaderNodeTexImage")
        texture.image = bpy.data.images.load(str(tmp_path / "tile.0003.png"))
        texture.image.source = "SEQUENCE"
        user = texture.image_user
        user.frame_duration, user.frame_start, user.frame_offset = 5, 1, 2
        user.use_auto_refresh = True
        return texture.outputs[0]

    shown = shown_on_patches({"tiled": tiled, "framed": framed})
    assert shown["framed"].off() < 1e-3
    assert shown["tiled"].off(0.9) < BOUND
    assert len(np.unique(shown["tiled"].ours.round(2), axis=0)) > 1


def test_a_missing_frame_is_magenta_and_named(tmp_path: Path) -> None:
    def framed(new: New, _: Link) -> Socket:
        texture = new("ShaderNodeTexImage")
        texture.image = bpy.data.images.new("Lost", 4, 4)
        texture.image.source, texture.image.filepath = "SEQUENCE", str(tmp_path / "lost.0001.png")
        return texture.outputs[0]

    pixels = tyndall_pixels(patch_scene({"Lost": framed}))
    assert pixels[7, 7] == pytest.approx((9.0, 8.0, 9.0), abs=1e-4)
    assert any("lost.0001.png" in line for line in last_render.statistics_of("Scene")["reports"])
