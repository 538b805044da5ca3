# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface programs (see program.py) evaluated here: over the texels of their pictures, and at the corners of triangles.

A value that depends on pictures and on attributes of corners is taken for a product of a part of either, which it is
exactly where nodes multiply them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tyndall.linear_colours import linear_colours
from tyndall.scene_description import Code, attribute_maps
from tyndall.surface_operations import is_known_without_point, run_on_answers

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from tyndall.scene_description import Image, Material, SurfaceOp

    #: What answers for the pictures and attributes that an operation reads: (..., 3).
    Read = Callable[[SurfaceOp], NDArray[Any]]
    #: Of a material and what answers for it, (..., channels).
    Value = Callable[[Material, Read], NDArray[Any]]

PICTURES = frozenset({Code.TEXTURE, Code.TEXTURE_ALPHA})
_ANSWERED = PICTURES | {Code.UV, Code.BACKFACING}
_TRIALS = 8
_WHITE = np.ones(3, np.float32)
_BLACK = np.zeros(3, np.float32)
_HALF = np.full(3, 0.5, np.float32)


@dataclass(frozen=True, kw_only=True, eq=False)
class Parts:
    """A value of a surface: texels, times what corners have."""

    texels: NDArray[np.float32]  #: (height, width, channels), linear, rows from the bottom; one: the same everywhere.
    #: Of n corners and a mesh's attributes, each (n, 2) by its name as attribute_maps() has it: (n, channels). None: no
    #: attribute is read.
    at_corners: Callable[[int, Mapping[str, NDArray[np.float32]]], NDArray[np.float32]] | None = None
    #: Not, where nodes join pictures and attributes otherwise than as a product, or bend what lies between corners.
    is_exact: bool = True


def colour_per_weight(material: Material, read: Read) -> NDArray[Any]:
    """A sum and its weight, as MaterialReader.channels has them, (..., 3) from 0 to 1. Without weight it is 0."""
    total, weight = _run(material, "diffuse", read), _run(material, "transparent", read)[..., :1]
    shape = np.broadcast_shapes(total.shape, weight.shape)
    per_weight = np.divide(total, weight, out=np.zeros(shape), where=weight > 0.0)
    clipped: NDArray[Any] = np.clip(per_weight, 0.0, 1.0)
    return clipped


def number_per_weight(material: Material, read: Read) -> NDArray[Any]:
    """Likewise, (..., 1)."""
    return colour_per_weight(material, read)[..., :1]


def diffuse_radiance(material: Material, read: Read) -> NDArray[Any]:
    """The diffuse part, however bright."""
    radiance: NDArray[Any] = np.maximum(_run(material, "diffuse", read), 0.0)
    return radiance


def parts_of(material: Material, value: Value) -> Parts:
    codes = {op.code for op in material.program}
    size = _largest([material.textures[op.texture].image for op in material.program if op.code in PICTURES])

    def on_texels(op: SurfaceOp) -> NDArray[Any]:
        if op.code is Code.UV:
            return _of_attribute(op, material, np.ones(4))
        image = material.textures[op.texture].image
        return _taken(linear_colours(image) if op.code is Code.TEXTURE else _alpha(image), size)

    if Code.UV not in codes:
        return Parts(texels=_texels(value(material, on_texels), size))
    at_white = value(material, _same_everywhere(material, _WHITE, np.ones(4)))
    is_divided = bool(codes & PICTURES)

    def at_corners(count: int, maps: Mapping[str, NDArray[np.float32]]) -> NDArray[np.float32]:
        def on_corners(op: SurfaceOp) -> NDArray[Any]:
            if op.code is not Code.UV:
                return _WHITE
            uvs = maps.get(material.uv_maps[op.uv_map])
            if uvs is None:
                return _BLACK
            through: NDArray[Any] = np.column_stack([uvs, np.ones(len(uvs))]) @ np.array(op.uv_matrix).reshape(3, 3).T
            return through

        found = value(material, on_corners)
        if is_divided:
            found = np.divide(found, at_white, out=np.zeros_like(found), where=at_white > 0.0)
        at_each: NDArray[np.float32] = np.broadcast_to(found, (count, found.shape[-1])).astype(np.float32)
        return at_each

    if not is_divided:
        return Parts(
            texels=np.ones((1, 1, at_white.shape[-1]), np.float32),
            at_corners=at_corners,
            is_exact=_is_linear(material, value),
        )
    return Parts(
        texels=_texels(value(material, on_texels), size),
        at_corners=at_corners,
        is_exact=_is_linear(material, value) and _is_product(material, value, at_white),
    )


def _is_product(material: Material, value: Value, at_white: NDArray[Any]) -> bool:
    """Whether the value of both is that of the picture times that of the attribute, in a few trials."""
    random = np.random.default_rng(1)
    for _ in range(_TRIALS):
        picture, attribute = random.uniform(0.1, 1.0, 3), random.uniform(0.1, 1.0, 4)
        both, one, other = (
            value(material, _same_everywhere(material, texel, rgba))
            for texel, rgba in ((picture, attribute), (picture, np.ones(4)), (_WHITE, attribute))
        )
        if not np.allclose(both * at_white, one * other, atol=1e-4):
            return False
    return True


def _is_linear(material: Material, value: Value) -> bool:
    """Whether it is between those of corners as attributes are, in a few trials."""
    random = np.random.default_rng(2)
    for _ in range(_TRIALS):
        corners = random.uniform(0.1, 1.0, (2, 4))
        of_both, first, second = (
            value(material, _same_everywhere(material, _WHITE, rgba)) for rgba in (corners.mean(axis=0), *corners)
        )
        if not np.allclose(2.0 * of_both, first + second, atol=1e-4):
            return False
    return True


def _same_everywhere(material: Material, texel: NDArray[Any], rgba: NDArray[Any]) -> Read:
    """Pictures of one colour, and attributes of one."""
    return lambda op: _of_attribute(op, material, rgba) if op.code is Code.UV else texel


def _of_attribute(op: SurfaceOp, material: Material, rgba: NDArray[Any]) -> NDArray[Any]:
    """What the operation makes of its half of an attribute."""
    is_first = material.uv_maps[op.uv_map].startswith(attribute_maps("")[0])
    pair = rgba[:2] if is_first else rgba[2:]
    through: NDArray[Any] = np.array(op.uv_matrix).reshape(3, 3) @ np.append(pair, 1.0)
    return through


def _texels(value: NDArray[Any], size: tuple[int, int]) -> NDArray[np.float32]:
    texels = np.broadcast_to(value, (*size, value.shape[-1])).astype(np.float32)
    return texels[:1, :1] if (texels == texels[0, 0]).all() else texels


def _largest(images: list[Image]) -> tuple[int, int]:
    """Height and width that every picture is taken at."""
    sizes = [image.shape[:2] for image in images]
    return max((height for height, _ in sizes), default=1), max((width for _, width in sizes), default=1)


def _run(material: Material, name: str, read: Read) -> NDArray[Any]:
    """A result of the program."""
    if not material.program:
        return np.array(getattr(material, name), np.float32)
    answers = {place: _answer(op, read) for place, op in enumerate(material.program) if not is_known_without_point(op)}
    shape = np.broadcast_shapes((3,), *(answer.shape for answer in answers.values()))
    flat = {
        place: np.ascontiguousarray(np.broadcast_to(answer, shape), np.float32).reshape(-1, 3)
        for place, answer in answers.items()
    }
    count = int(np.prod(shape[:-1]))
    return run_on_answers(material, getattr(material, f"{name}_register"), flat, count).reshape(shape)


def reads_more(material: Material) -> bool:
    """Whether its program asks points for something that is half grey here: patterns, positions, what looks at it."""
    return any(not is_known_without_point(op) and op.code not in _ANSWERED for op in material.program)


def _answer(op: SurfaceOp, read: Read) -> NDArray[Any]:
    if op.code is Code.BACKFACING:
        return _BLACK
    return read(op) if op.code in _ANSWERED else _HALF


def _alpha(image: Image) -> NDArray[Any]:
    alpha = image.pixels[..., 3:] if image.has_alpha else np.ones((*image.shape[:2], 1), np.float32)
    return np.repeat(alpha / np.float32(255.0) if alpha.dtype == np.uint8 else alpha, 3, axis=2)


def _taken(texels: NDArray[Any], size: tuple[int, int]) -> NDArray[Any]:
    """At another size: the texel that is there."""
    rows, columns = ((np.arange(wanted) * has) // wanted for wanted, has in zip(size, texels.shape[:2], strict=True))
    return texels if texels.shape[:2] == size else texels[rows[:, None], columns]
