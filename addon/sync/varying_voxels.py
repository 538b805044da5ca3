# SPDX-License-Identifier: GPL-3.0-or-later
"""What voxels keep of surfaces whose nodes vary from place to place: the programs, drawn into pictures.

Each triangle has a piece of a picture, to scale: its longest edge lies along the lower side, with a texel per voxel. So
a look-up of a voxel's size never leaves the piece.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from tyndall.linear_colours import srgb_from_linear
from tyndall.program_points import values_of
from tyndall.scene_description import Code

from .materials import COLOUR
from .unit_vectors import unit_vectors

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping

    from numpy.typing import NDArray

    from tyndall.program_points import PointPlace, Values
    from tyndall.scene_description import Material

#: Of all pictures together; beyond them a texel is larger than a voxel.
MOST_TEXELS = 2**24
_TEXELS_AT_ONCE = 2**18


@dataclass(frozen=True, kw_only=True, eq=False)
class Varying:
    """Triangles of a mesh in those of its instances that look alike."""

    colouring: int  #: Into VoxelMesh.colourings.
    programs: Mapping[str, Material]  #: As MaterialReader.channels has them.
    place: PointPlace
    corners: NDArray[np.float64]  #: (t, 3, 3), metres in the object.
    normals: NDArray[np.float32]  #: (t, 3, 3), unit, in the object; 0: flat.
    uv_maps: Mapping[str, NDArray[np.float32]]  #: By the names that programs have for them, (t, 3, 2).
    triangles: list[NDArray[np.intp]] = field(default_factory=list)  #: Their indices among all, for each instance.
    is_mirrored: list[bool] = field(default_factory=list)  #: Whether the corners of these go round the other way.

    def area_m2(self) -> float:
        """In the world."""
        first, second, third = self.in_world().transpose(1, 0, 2)
        across = np.cross(second - first, third - first)
        return 0.5 * float(np.linalg.norm(across, axis=1).sum())

    def in_world(self) -> NDArray[np.float64]:
        """Corners, turned and scaled."""
        turned: NDArray[np.float64] = self.corners @ self.place.world_from_object[:3, :3].T
        return turned


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawn:
    """A picture of each thing that is kept, and where triangles lie on it."""

    pictures: dict[str, NDArray[np.uint8]]  #: By name, rows from the bottom; the colour has three, as sRGB encodes it.
    corner_uvs: NDArray[np.float32]  #: (t, 3, 2)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Pieces:
    """Of a picture, one for each triangle, with the corners in the order in which the longest edge comes first."""

    corner_order: NDArray[np.intp]  #: (t, 3)
    #: (t, 2), from texel to texel along the longest edge and upwards; 0 where a voxel is larger.
    steps: NDArray[np.intp]
    lower_left: NDArray[np.intp]  #: (t, 2)
    foot: NDArray[np.float64]  #: Of the third corner, as a share of the longest edge, (t,).
    size: tuple[int, int]  #: Width and height of the picture.


def texel_size_m(surfaces: Collection[Varying], voxel_m: float) -> float:
    """A voxel's side, or more where there would be too many texels; a metre where all is one point."""
    area_m2 = 2.0 * sum(one.area_m2() for one in surfaces)  # pieces are rectangles
    return max(voxel_m, math.sqrt(area_m2 / MOST_TEXELS)) or 1.0


def draw(
    surface: Varying, names: Collection[str], texel_m: float, notes: list[str], poll: Callable[[], None] = lambda: None
) -> Drawn:
    """``poll`` may raise to stop. Raises IoError of textures that lie in a file."""
    pieces = _laid_out(surface.in_world(), texel_m)
    width, height = pieces.size
    wanted = [name for name in names if name in surface.programs]
    pictures = {name: np.zeros((height, width, 3) if name == COLOUR else (height, width), np.uint8) for name in wanted}
    asked = {name: _quotient(surface.programs[name], surface.place, notes) for name in wanted}
    for texels, owners, shares in _texels(pieces):
        poll()
        at = _Points.between(surface, owners, shares)
        rows, columns = np.divmod(texels, width)
        for name, values in asked.items():
            found = values(at)
            encoded = srgb_from_linear(found) if name == COLOUR else found[:, 0]
            pictures[name][rows, columns] = np.rint(255.0 * encoded).astype(np.uint8)
    return Drawn(pictures=pictures, corner_uvs=_corner_uvs(pieces))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Points:
    positions: NDArray[np.float64]
    uv_maps: dict[str, NDArray[np.float32]]
    normals: tuple[NDArray[np.float32], NDArray[np.float32]]  #: Smooth and true ones.

    @classmethod
    def between(cls, surface: Varying, owners: NDArray[np.intp], shares: NDArray[np.float64]) -> _Points:
        """Corners of triangles by their shares, (n, 3)."""

        def mixed(of_corners: NDArray[np.floating]) -> NDArray[np.float64]:
            between: NDArray[np.float64] = np.einsum("nc,ncx->nx", shares, of_corners[owners])
            return between

        corners = surface.corners[owners]
        across = unit_vectors(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        smooth = unit_vectors(mixed(surface.normals))
        return cls(
            positions=mixed(surface.corners),
            uv_maps={name: mixed(uvs).astype(np.float32) for name, uvs in surface.uv_maps.items()},
            normals=(
                np.where(smooth.any(axis=1, keepdims=True), smooth, across).astype(np.float32),
                across.astype(np.float32),
            ),
        )


def _quotient(program: Material, place: PointPlace, notes: list[str]) -> Callable[[_Points], NDArray[np.float64]]:
    """What a program sums up by its weight, each from 0 to 1; without weight it is 0."""
    totals, weights = (_asked(program, name, place, notes) for name in ("diffuse", "transparent"))

    def values(at: _Points) -> NDArray[np.float64]:
        total, weight = (one(at.positions, at.uv_maps, at.normals) for one in (totals, weights))
        per_weight = np.divide(total, weight[:, :1], out=np.zeros(total.shape), where=weight[:, :1] > 0.0)
        return np.clip(per_weight, 0.0, 1.0)

    return values


def _asked(program: Material, name: str, place: PointPlace, notes: list[str]) -> Values:
    """A result of a program."""
    constant = getattr(program, name)
    if program.program:
        register = getattr(program, f"{name}_register")
        last = next(step for step in reversed(program.program) if step.out == register)
        if last.code is not Code.CONSTANT:
            return values_of(replace(program, emission_register=register), place, notes)
        constant = last.value
    everywhere = np.array(constant, np.float32)
    return lambda positions, _uv_maps, _normals=None: np.broadcast_to(everywhere, positions.shape)


def _laid_out(corners_m: NDArray[np.float64], texel_m: float) -> _Pieces:
    lengths = np.linalg.norm(corners_m[:, (1, 2, 0)] - corners_m, axis=2)
    order = (lengths.argmax(axis=1)[:, None] + np.arange(3)) % 3
    first, second, third = np.take_along_axis(corners_m, order[..., None], axis=1).transpose(1, 0, 2)
    along = second - first
    length = lengths.max(axis=1)
    reach = np.where(length > 0.0, length, 1.0)
    foot = (along * (third - first)).sum(axis=1) / reach**2
    above = np.linalg.norm(np.cross(along, third - first), axis=1) / reach
    steps = np.floor(np.stack([length, above], axis=1) / texel_m).astype(np.intp)
    sizes = steps + 1
    # Rows of pieces of about one height, as long as the picture is high.
    by_height = np.lexsort((-sizes[:, 0], -sizes[:, 1]))
    width = max(int(sizes[:, 0].max()), math.isqrt(int(sizes.prod(axis=1).sum())))
    ends = sizes[by_height, 0].cumsum()
    lower_left = np.zeros_like(sizes)
    start = bottom = 0
    while start < len(ends):
        before = ends[start - 1] if start else 0
        end = int(np.searchsorted(ends, before + width, side="right"))
        row = by_height[start:end]
        lower_left[row, 0] = ends[start:end] - sizes[row, 0] - before
        lower_left[row, 1] = bottom
        bottom += int(sizes[row[0], 1])
        start = end
    return _Pieces(corner_order=order, steps=steps, lower_left=lower_left, foot=foot, size=(width, bottom))


def _texels(pieces: _Pieces) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]]:
    """Indices of texels in the picture, their triangles, and the shares of the corners; in parts."""
    counts = (pieces.steps + 1).prod(axis=1)
    ends = counts.cumsum()
    for first in range(0, int(ends[-1]), _TEXELS_AT_ONCE):
        numbers = np.arange(first, min(first + _TEXELS_AT_ONCE, int(ends[-1])))
        owners = np.searchsorted(ends, numbers, side="right")
        steps = pieces.steps[owners]
        up, right = np.divmod(numbers - (ends - counts)[owners], steps[:, 0] + 1)
        foot, is_split = pieces.foot[owners], steps > 0
        per_right, per_up = (1.0 / np.maximum(steps, 1)).T
        # Of what is smaller than a voxel: the middle.
        third = np.where(is_split[:, 1], up * per_up, 1.0 / 3.0)
        second = np.where(is_split[:, 0], right * per_right - third * foot, 1.0 / 3.0)
        shares = np.stack([1.0 - second - third, second, third], axis=1)
        # From inside the triangle, look-ups reach a texel to the right and upwards.
        reach = 1.001 * np.stack([per_right + (1.0 - foot) * per_up, per_right + foot * per_up], axis=1)
        is_read = (shares[:, :2] >= -reach).all(axis=1)
        in_order = np.empty_like(shares)
        np.put_along_axis(in_order, pieces.corner_order[owners], shares, axis=1)
        columns, rows = pieces.lower_left[owners, 0] + right, pieces.lower_left[owners, 1] + up
        yield (rows * pieces.size[0] + columns)[is_read], owners[is_read], in_order[is_read]


def _corner_uvs(pieces: _Pieces) -> NDArray[np.float32]:
    """Through the middle of texels."""
    right, up = pieces.steps.T.astype(np.float64)
    nothing = np.zeros_like(right)
    at = np.stack(
        [np.stack(one, axis=1) for one in ((nothing, nothing), (right, nothing), (pieces.foot * right, up))], 1
    )
    uvs = (pieces.lower_left[:, None] + at + 0.5) / pieces.size
    in_order = np.empty(uvs.shape, np.float32)
    np.put_along_axis(in_order, pieces.corner_order[..., None], uvs, axis=1)
    return in_order
