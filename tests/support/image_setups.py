# SPDX-License-Identifier: GPL-3.0-or-later
"""Images at any vector, and normals that images and heights bend, as set-ups of patch_nodes.py."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np

from .patch_nodes import Link, New, Socket
from .pattern_setups import place as place_by
from .small_scenes import node

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
            if name == "mapping":
                place_by(texture.texture_mapping, str(value))
            else:
                setattr(texture, name, value)
        scaled.operation = "SCALE"
        scaled.inputs["Scale"].default_value = scale
        link(new("ShaderNodeTexCoord").outputs[place], scaled.inputs[0])
        link(scaled.outputs[0], texture.inputs["Vector"])
        return texture.outputs[0]

    return build


def placed_by_itself(new: New, _: Link) -> Socket:
    """An image without a vector, on the UV map as its own mapping says."""
    texture = new("ShaderNodeTexImage")
    texture.image = picture()
    texture.texture_mapping.scale, texture.texture_mapping.translation = (0.5, -0.7, 1.0), (0.2, 0.1, 0.0)
    return texture.outputs[0]


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


def lost(output: str, interpolation: str = "Linear", space: str = "sRGB") -> Build:
    """A file that is missing, beyond whose borders there is nothing."""

    def build(new: New, link: Link) -> Socket:
        texture = new("ShaderNodeTexImage")
        texture.image = bpy.data.images.new("Lost", 4, 4)
        texture.image.source, texture.image.filepath = "FILE", f"//lost {space}.png"
        texture.image.colorspace_settings.name = space
        texture.extension, texture.interpolation = "CLIP", interpolation
        link(new("ShaderNodeTexCoord").outputs["UV"], texture.inputs["Vector"])
        return texture.outputs[output]

    return build


def none_chosen(output: str) -> Build:
    """A node that has no image: the same as of a file that is missing."""

    def build(new: New, link: Link) -> Socket:
        socket = lost(output)(new, link)
        socket.node.image = None
        return socket

    return build


def lost_label(new: New, link: Link) -> Socket:
    """A missing picture over a colour, by its alpha: its own colour does not fade."""
    mix = node(new, "ShaderNodeMixRGB", Color1=(0.1, 0.6, 0.2, 1))
    colour = lost("Color")(new, link)
    link(colour, mix.inputs["Color2"])
    link(colour.node.outputs["Alpha"], mix.inputs["Fac"])
    return mix.outputs[0]


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
    "missing and clipped": lost("Color"),
    "missing and clipped, closest": lost("Color", "Closest"),
    "missing and clipped, no colour": lost("Color", space="Non-Color"),
    "alpha of a missing and clipped one": lost("Alpha"),
    "missing and clipped, over a colour": lost_label,
    "none and clipped": none_chosen("Color"),
    "alpha of none and clipped": none_chosen("Alpha"),
    "where an image says": warped,
    "by its own mapping": placed_by_itself,
    **{f"mapped as a {kind.lower()}": textured("UV", 0.5, mapping=kind) for kind in ("POINT", "TEXTURE", "VECTOR")},
    "mapped as a normal": textured("Object", mapping="NORMAL"),
    "box mapped as a point": textured("Object", projection="BOX", projection_blend=0.4, mapping="POINT"),
    "environment mapped as a vector": textured("Normal", kind="ShaderNodeTexEnvironment", mapping="VECTOR"),
    "environment": textured("Normal", kind="ShaderNodeTexEnvironment"),
    "mirror ball": textured("Reflection", kind="ShaderNodeTexEnvironment", projection="MIRROR_BALL"),
}
if bpy.app.version >= (4, 0, 0):
    IMAGES["mirrored"] = textured("Object", 4.0, extension="MIRROR")


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
