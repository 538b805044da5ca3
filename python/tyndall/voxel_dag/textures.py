# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that give the voxels of a mesh their colours."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyndall import _native
from tyndall.linear_colours import linear_from_srgb
from tyndall.scene_description import Extension, Interpolation

from .checks import MOST_INDEX, refuse

MOST_CHANNELS = 4
FEWEST_OF_COLOURS = 3  #: Fewer channels are grey, and alpha.
LINEAR_FILES = (".exr", ".hdr")


@dataclass(frozen=True, kw_only=True, eq=False)
class Material:
    """A colour, or a picture that is laid on triangles by their ``corner_uvs``; and channels.

    Where no material has a colour, channels alone are kept.
    """

    color: Sequence[float] | None = None  #: 0 to 1, as sRGB encodes it.
    #: An array (height, width) or (height, width, 1 to 4), rows from the bottom, uint8 or float; or an image file. Its
    #: alpha is not looked at.
    picture: ArrayLike | str | os.PathLike[str] | None = None
    is_srgb: bool | None = None  #: Whether values are encoded; None: all are but floats and .exr and .hdr files.
    outside: Literal["repeat", "extend", "clip", "mirror"] = "repeat"  #: What lies beyond [0, 1]; clip: black.
    #: By name: a number from 0 to 1, or a picture (height, width) of such, uint8 or float, laid on like the other one.
    channels: Mapping[str, ArrayLike] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class Textures:
    """The materials of a mesh of m triangles."""

    materials: Sequence[Material]
    corner_uvs: ArrayLike | None = None  #: (m, 3, 2); (0, 0) is the lower left of a picture.
    material_of_triangle: ArrayLike | None = None  #: (m,), indices of materials; None: all have the first.

    @property
    def has_colors(self) -> bool:
        """Whether some material has a colour or a picture."""
        return any(material.color is not None or material.picture is not None for material in self.materials)

    @property
    def channels(self) -> list[str]:
        """Names of those that some material has, in the order in which they come up."""
        return list(dict.fromkeys(name for material in self.materials for name in material.channels))

    def native_materials(self, channels: Mapping[str, float]) -> list[_native.SurfaceMaterial]:
        """``channels``: what a material has where it does not say, by name, in the order of the surface's.

        Raises InvalidInput, which names the material, and IoError, which names the file.
        """
        if not self.materials:
            raise refuse("textures have no materials")
        return [
            _native_material(material, index, channels, has_color=self.has_colors or not self.channels)
            for index, material in enumerate(self.materials)
        ]

    def native_uvs(self) -> NDArray[np.float32] | None:
        """Float32 (m, 3, 2). Raises InvalidInput."""
        if self.corner_uvs is None:
            return None
        uvs = np.asarray(self.corner_uvs)
        if uvs.ndim != 3 or uvs.shape[1:] != (3, 2) or uvs.dtype.kind not in "fiu":  # noqa: PLR2004 - corners, u and v
            raise refuse(f"corner_uvs are {uvs.dtype} {uvs.shape}, not numbers (m, 3, 2)")
        return np.ascontiguousarray(uvs, np.float32)

    def native_indices(self) -> NDArray[np.uint32] | None:
        """Uint32 (m,). Raises InvalidInput."""
        if self.material_of_triangle is None:
            return None
        indices = np.asarray(self.material_of_triangle)
        if indices.ndim != 1 or indices.dtype.kind not in "iu":
            raise refuse(f"material_of_triangle is {indices.dtype} {indices.shape}, not whole numbers (m,)")
        if indices.size and not 0 <= indices.min() <= indices.max() <= MOST_INDEX:
            raise refuse(f"material_of_triangle reaches from {indices.min()} to {indices.max()}")
        return np.ascontiguousarray(indices, np.uint32)


def _native_material(
    material: Material, index: int, wanted: Mapping[str, float], *, has_color: bool
) -> _native.SurfaceMaterial:
    if has_color and (material.color is None) == (material.picture is None):
        raise refuse(f"material {index} has to have either a color or a picture")
    if material.outside.upper() not in Extension.__members__:
        names = ", ".join(name.lower() for name in Extension.__members__)
        raise refuse(f"material {index}: outside is {material.outside!r}, not one of {names}")
    channels = [_channel(material, index, name, default) for name, default in wanted.items()]
    if not has_color:
        return _native.SurfaceMaterial(color=(0.0, 0.0, 0.0), texture=None, channels=channels)
    if material.picture is None:
        color = np.asarray(material.color)
        if color.shape != (3,) or color.dtype.kind not in "fiu":
            raise refuse(f"material {index}: color is {material.color!r}, not three numbers")
        linear = linear_from_srgb(color.astype(float)).tolist()
        return _native.SurfaceMaterial(color=linear, texture=None, channels=channels)
    pixels, is_srgb = pixels_of(material, index)
    texture = _filtered(material, index, pixels, is_srgb=is_srgb)
    return _native.SurfaceMaterial(color=(0.0, 0.0, 0.0), texture=texture, channels=channels)


def _channel(material: Material, index: int, name: str, default: float) -> float | _native.FilteredTexture:
    """A number, or a picture of numbers."""
    value = np.asarray(material.channels.get(name, default))
    if value.ndim == 0 and value.dtype.kind in "fiu":
        return float(value)
    if value.ndim != 2 or value.size == 0 or (value.dtype != np.uint8 and value.dtype.kind != "f"):  # noqa: PLR2004
        raise refuse(
            f'material {index}: channel "{name}" is {value.dtype} {value.shape}, neither a number nor a picture '
            "(height, width), uint8 or float"
        )
    numbers = value / np.float32(255) if value.dtype == np.uint8 else value
    if not ((numbers >= 0) & (numbers <= 1)).all():
        raise refuse(f'material {index}: channel "{name}" has values outside [0, 1]')
    pixels = np.repeat(numbers[:, :, None], MOST_CHANNELS, axis=2)
    return _filtered(material, index, np.ascontiguousarray(pixels, np.float32), is_srgb=False)


def _filtered(
    material: Material, index: int, pixels: NDArray[np.uint8] | NDArray[np.float32], *, is_srgb: bool
) -> _native.FilteredTexture:
    texture = _native.Texture(
        name=f"material {index}",
        pixels=pixels,
        is_srgb=is_srgb,
        has_alpha=False,
        extension=int(Extension[material.outside.upper()]),
        interpolation=int(Interpolation.LINEAR),
    )
    return _native.FilteredTexture(texture)


def pixels_of(material: Material, index: int) -> tuple[NDArray[np.uint8] | NDArray[np.float32], bool]:
    """(height, width, 4), and whether the bytes are encoded; floats are linear."""
    is_srgb = material.is_srgb
    if isinstance(material.picture, str | os.PathLike):
        from tyndall import _image_io  # noqa: PLC0415 - who has arrays does not need what reads files

        pixels, _, _ = _image_io.read(material.picture)
        if is_srgb is None:
            is_srgb = not os.fspath(material.picture).lower().endswith(LINEAR_FILES)
    else:
        pixels = np.asarray(material.picture)
    if pixels.ndim == 2:  # noqa: PLR2004 - rows and columns
        pixels = pixels[:, :, None]
    if pixels.ndim != 3 or not 1 <= pixels.shape[2] <= MOST_CHANNELS or pixels.size == 0:  # noqa: PLR2004 - and channels
        raise refuse(f"material {index}: the picture has the shape {pixels.shape}, not (height, width, 1 to 4)")
    if pixels.dtype != np.uint8 and pixels.dtype.kind != "f":
        raise refuse(f"material {index}: the picture is {pixels.dtype}, neither uint8 nor float")
    colours = pixels[:, :, :3] if pixels.shape[2] >= FEWEST_OF_COLOURS else np.repeat(pixels[:, :, :1], 3, axis=2)
    if pixels.dtype == np.uint8:
        opaque = np.full((*pixels.shape[:2], 1), 255, np.uint8)
        return np.ascontiguousarray(np.concatenate([colours, opaque], axis=2)), is_srgb is not False
    if not np.isfinite(colours).all():
        row, column = np.argwhere(~np.isfinite(colours).all(axis=2))[0].tolist()
        raise refuse(f"material {index}: the picture is not finite in row {row}, column {column}")
    linear = linear_from_srgb(colours) if is_srgb else colours
    opaque = np.ones((*pixels.shape[:2], 1))
    return np.ascontiguousarray(np.concatenate([linear, opaque], axis=2), np.float32), False
