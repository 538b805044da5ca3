# SPDX-License-Identifier: GPL-3.0-or-later
"""Images at any vector, and normals that images and heights bend, are what Cycles makes of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import last_render
from support.engine_pictures import tyndall_pixels
from support.patch_nodes import Link, New, Shown, Socket, patch_scene, shown_on_patches
from support.small_scenes import node

#: A picture of Cycles is up to a hundredth of a pixel off its pixels' centres, and its textures are steep here.
BOUND = 0.02
Build = Callable[[New, Link], Socket]


def picture(name: str = "Picture", size: int = 16, *, smooth: bool = True) -> bpy.types.Image:
    """Waves: bytes, opaque."""
    if name in bpy.data.images:
        return bpy.data.images[name]
    created = bpy.data.images.new(name, size, size)
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    turn = 2.0 * np.pi / size
    rgba = np.ones((size, size, 4), np.float32)
    rgba[..., 0] = 0.5 + 0.45 * np.sin(turn * x) * np.cos(turn * y)
    rgba[..., 1] = 0.5 + 0.45 * np.cos(turn * (x + y))
    rgba[..., 2] = (x + 0.3 * y) / (1.3 * size) if smooth else 0.7
    created.pixels.foreach_set(rgba.ravel())
    created.update()
    return created


def textured(
    place: str = "Generated", scale: float = 1.0, kind: str = "ShaderNodeTexImage", **properties: object
) -> Build:
    """An image at Texture Coordinate's output of this name, times ``scale``."""

    def build(new: New, link: Link) -> Socket:
        texture, scaled = new(kind), new("ShaderNodeVectorMath")
        texture.image = picture()
        for name, value in properties.items():
            setattr(texture, name, value)
        scaled.operation = "SCALE"
        scaled.inputs["Scale"].default_value = scale
        link(new("ShaderNodeTexCoord").outputs[place], scaled.inputs[0])
        link(scaled.outputs[0], texture.inputs["Vector"])
        return texture.outputs[0]

    return build


def warped(new: New, link: Link) -> Socket:
    """An image where another image says."""
    texture = new("ShaderNodeTexImage")
    texture.image = picture()
    link(textured("UV")(new, link), texture.inputs["Vector"])
    return texture.outputs[0]


def alpha_outside(new: New, link: Link) -> Socket:
    texture = new("ShaderNodeTexImage")
    texture.image, texture.extension = picture(), "CLIP"
    link(new("ShaderNodeTexCoord").outputs["Object"], texture.inputs["Vector"])
    return texture.outputs["Alpha"]


IMAGES: dict[str, Build] = {
    "flat": textured(),
    "flat on object coordinates": textured("Object", 2.0),
    "flat on the window": textured("Window", 3.0),
    "box": textured("Object", 2.0, projection="BOX"),
    "blended box": textured("Object", 2.0, projection="BOX", projection_blend=0.4),
    "fully blended box": textured("Object", 2.0, projection="BOX", projection_blend=1.0),
    "sphere": textured(projection="SPHERE"),
    "tube": textured(projection="TUBE"),
    "closest": textured("UV", 0.5, interpolation="Closest"),
    "cubic": textured("UV", 0.5, interpolation="Cubic"),
    "smart": textured("Generated", 0.5, interpolation="Smart"),
    "extended": textured("Object", 4.0, extension="EXTEND"),
    "clipped": textured("Object", 4.0, extension="CLIP"),
    "alpha of a clipped one": alpha_outside,
    "where an image says": warped,
    "environment": textured("Normal", kind="ShaderNodeTexEnvironment"),
    "mirror ball": textured("Reflection", kind="ShaderNodeTexEnvironment", projection="MIRROR_BALL"),
}
if bpy.app.version >= (4, 0, 0):
    IMAGES["mirrored"] = textured("Object", 4.0, extension="MIRROR")


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


def bumped(strength: float = 0.7, distance: float = 0.1, *, invert: bool = False, coordinate: str = "UV") -> Build:
    def build(new: New, link: Link) -> Socket:
        bump = node(new, "ShaderNodeBump", Strength=strength, Distance=distance)
        bump.invert = invert
        link(textured(coordinate, 0.5)(new, link), bump.inputs["Height"])
        return bump.outputs["Normal"]

    return build


def bump_on_bump(new: New, link: Link) -> Socket:
    bump = node(new, "ShaderNodeBump", Strength=1.0, Distance=0.05)
    link(bumped(coordinate="Object")(new, link), bump.inputs["Normal"])
    link(textured("UV", 1.0)(new, link), bump.inputs["Height"])
    return bump.outputs["Normal"]


def bump_by_position(new: New, link: Link) -> Socket:
    """A height that is no texture: a wave of the position."""
    bump, wave = node(new, "ShaderNodeBump", Distance=0.05), new("ShaderNodeMath")
    wave.operation = "SINE"
    scaled = new("ShaderNodeVectorMath")
    scaled.operation = "DOT_PRODUCT"
    scaled.inputs[1].default_value = (9.0, 5.0, 2.0)
    link(new("ShaderNodeNewGeometry").outputs["Position"], scaled.inputs[0])
    link(scaled.outputs["Value"], wave.inputs[0])
    link(wave.outputs[0], bump.inputs["Height"])
    return bump.outputs["Normal"]


def mapped(space: str, strength: float = 1.0, uv_map: str = "") -> Build:
    def build(new: New, link: Link) -> Socket:
        created = node(new, "ShaderNodeNormalMap", Strength=strength)
        created.space, created.uv_map = space, uv_map
        link(textured("UV", 0.5)(new, link), created.inputs["Color"])
        return created.outputs["Normal"]

    return build


def fresnel_of_bump(new: New, link: Link) -> Socket:
    created = node(new, "ShaderNodeLayerWeight", Blend=0.4)
    link(bumped()(new, link), created.inputs["Normal"])
    return created.outputs["Facing"]


NORMALS: dict[str, Build] = {
    "bump": bumped(),
    "strong bump": bumped(2.0, 1.0),
    "inverted bump": bumped(invert=True),
    "bump of generated coordinates": bumped(coordinate="Generated"),
    "bump on a bump": bump_on_bump,
    "bump by position": bump_by_position,
    **{f"{space.lower()} map": mapped(space) for space in ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT")},
    "weak tangent map": mapped("TANGENT", 0.4),
    "strong tangent map": mapped("TANGENT", 1.7),
    "weak world map": mapped("WORLD", 0.4),
    "tangent map of another UV map": mapped("TANGENT", uv_map="Other"),
    "tangent map without a UV map": mapped("TANGENT", uv_map="Nothing"),
    "layer weight of a bump": fresnel_of_bump,
}


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
