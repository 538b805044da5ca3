# SPDX-License-Identifier: GPL-3.0-or-later
"""What colours the voxels of a surface: the diffuse part of its material, as one colour or as one picture.

A surface program (see program.py) is evaluated texel by texel where all of its pictures lie on the surface alike: nodes
between an image and a shader change the picture, exactly but for what lies between texels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tyndall.linear_colours import linear_colours
from tyndall.scene_description import Code, Extension

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from tyndall.scene_description import Image, Material, SurfaceOp

    from .reports import Reports

_SAME = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Colouring:
    """Linear, rows from the bottom."""

    texels: NDArray[np.float32]  #: (height, width, 3); a colour is one texel.
    extension: Extension = Extension.REPEAT
    uv_map: str = ""  #: "" is the active one.
    uv_matrix: tuple[float, ...] = _SAME  #: 3x3, row by row, applied to (u, v, 1).

    @property
    def is_picture(self) -> bool:
        return self.texels.shape[:2] != (1, 1)

    def placed(self, uvs: NDArray[np.float32]) -> NDArray[np.float32]:
        """Where a picture is read for these coordinates, (n, 3, 2)."""
        matrix = np.array(self.uv_matrix).reshape(3, 3)
        points = np.concatenate([uvs, np.ones((*uvs.shape[:2], 1))], axis=2) @ matrix.T
        placed: NDArray[np.float32] = (points[..., :2] / points[..., 2:]).astype(np.float32)
        return placed


def colouring_of(material: Material, reports: Reports) -> Colouring:
    if not material.program:
        return Colouring(texels=_texel(material.diffuse))
    read = [op for op in material.program if op.code in {Code.TEXTURE, Code.TEXTURE_ALPHA}]
    first = next(iter(read), None)
    if first is not None and any(_place(op, material) != _place(first, material) for op in read):
        reports.add(f'Material "{material.name}"', "its pictures lie differently: voxels have the first one's place")
    size = _largest([material.textures[op.texture].image for op in read])
    texels = np.clip(_evaluated(material, size), 0.0, 1.0).astype(np.float32)
    if first is None or (texels == texels[0, 0]).all():
        return Colouring(texels=texels[:1, :1])
    return Colouring(
        texels=texels,
        extension=material.textures[first.texture].extension,
        uv_map=material.uv_maps[first.uv_map],
        uv_matrix=first.uv_matrix,
    )


def _texel(colour: tuple[float, float, float]) -> NDArray[np.float32]:
    return np.clip(np.array(colour, np.float32), 0.0, 1.0)[None, None]


def _place(op: SurfaceOp, material: Material) -> tuple[object, ...]:
    return op.uv_map, op.uv_matrix, material.textures[op.texture].extension


def _largest(images: list[Image]) -> tuple[int, int]:
    """Height and width that every picture is taken at."""
    sizes = [image.pixels.shape[:2] for image in images]
    return max((height for height, _ in sizes), default=1), max((width for _, width in sizes), default=1)


def _evaluated(material: Material, size: tuple[int, int]) -> NDArray[Any]:
    """The diffuse part, (height, width, 3)."""
    registers: dict[int, NDArray[Any]] = {}
    for op in material.program:
        if op.code in _OPERATIONS:
            operands = (registers.get(register, _BLACK) for register in (op.a, op.b, op.c))
            registers[op.out] = _OPERATIONS[op.code](*operands)
        elif op.code is Code.TEXTURE:
            registers[op.out] = _taken(linear_colours(material.textures[op.texture].image), size)
        elif op.code is Code.TEXTURE_ALPHA:
            registers[op.out] = _taken(_alpha(material.textures[op.texture].image), size)
        else:
            registers[op.out] = np.array(op.value, np.float32)
    return np.broadcast_to(registers[material.diffuse_register], (*size, 3))


_BLACK = np.zeros(3, np.float32)
_OPERATIONS: dict[Code, Callable[..., NDArray[Any]]] = {
    Code.MULTIPLY: lambda a, b, _c: a * b,
    Code.ADD: lambda a, b, _c: a + b,
    Code.SUBTRACT: lambda a, b, _c: a - b,
    Code.MIX: lambda a, b, c: a + (b - a) * np.clip(c, 0.0, 1.0),
    Code.CLAMP: lambda a, _b, _c: np.clip(a, 0.0, 1.0),
    Code.AVERAGE: lambda a, _b, _c: np.repeat(a.mean(axis=-1, keepdims=True), 3, axis=-1),
    Code.BACKFACING: lambda _a, _b, _c: _BLACK,
}


def _alpha(image: Image) -> NDArray[Any]:
    alpha = image.pixels[..., 3:] if image.has_alpha else np.ones((*image.pixels.shape[:2], 1), np.float32)
    return np.repeat(alpha / np.float32(255.0) if alpha.dtype == np.uint8 else alpha, 3, axis=2)


def _taken(texels: NDArray[Any], size: tuple[int, int]) -> NDArray[Any]:
    """At another size: the texel that is there."""
    rows, columns = ((np.arange(wanted) * has) // wanted for wanted, has in zip(size, texels.shape[:2], strict=True))
    return texels if texels.shape[:2] == size else texels[rows[:, None], columns]
