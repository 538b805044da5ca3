# SPDX-License-Identifier: GPL-3.0-or-later
"""A brush in space: strokes of an ellipsoid through the voxels of a box.

Based on: Kol, dissertation, TU Delft 2018, 5.4.3: an ellipsoidal brush and eraser with size, opacity and hardness.
Differs:  between two moves of the mouse the ellipsoid is swept along the straight way, by the distance to that segment
          instead of single dabs: a stroke has no beads, however far apart the moves are. Where a stroke crosses itself
          it covers no more than its opacity, as Blender's brushes do.
Bound:    per move, the voxels of the swept ellipsoid's bounds, 15 operations on arrays each.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .air_tiles import VolumeKind, local_from_index, tile_block, tiles_in
from .scene_description import FloatArray

MODES = ("PAINT", "ADD", "MULTIPLY", "ERASE", "SMOOTH")

Vector = NDArray[np.float64]  #: (3,)
Block = tuple[slice, slice, slice]  #: Of an array (nz, ny, nx).

#: Of the filters 1 2 1 that SMOOTH blends towards, voxels apart: together a standard deviation of 1.6 voxels.
_SMOOTHING_STEPS = (1, 2)
_SMOOTHING_REACH = sum(_SMOOTHING_STEPS)
#: A way is swept in parts of at most so many radii: the bounds of a long slanted one hold much that it never touches.
_LONGEST_PART = 2.0
#: Voxels that are worked on at once: in their cache a brush of 64 voxels is three times as fast.
_SLAB_VOXELS = 1 << 15


@dataclass(frozen=True, kw_only=True)
class AirBrush:
    """What a stroke does; the ellipsoid is a disc across ``normal``, and as deep as ``depth_m`` along it."""

    mode: str = "PAINT"  #: One of MODES.
    value: float = 1.0  #: What PAINT sets, ADD adds and MULTIPLY multiplies by.
    radius_m: float = 1.0  #: Across the normal.
    depth_m: float = 1.0  #: Half axis along the normal.
    hardness: float = 0.5  #: Share of the radius at full opacity, [0, 1]; from there a smooth falloff to the rim.
    opacity: float = 1.0  #: [0, 1]
    pressure_sizes: bool = False  #: Pressure scales the ellipsoid.
    pressure_fades: bool = False  #: Pressure scales the opacity.


class Stroke:
    """From the press of the button to its release. The painted array is new; what was there before stays."""

    def __init__(
        self,
        before: FloatArray,
        kind: VolumeKind,
        world_from_unit: NDArray[np.float64],
        normal: Vector,
        brush: AirBrush,
    ) -> None:
        """``before``: (nz, ny, nx); ``world_from_unit``: (4, 4), not singular; ``normal``: of any length but 0."""
        self.values = before.copy()  #: With the stroke so far.
        self.touched: set[int] = set()  #: Tiles that it may have changed.
        self._before = before
        self._kind = kind
        self._brush = brush
        self._coverage = np.zeros(before.shape, np.float32)  # not zeros_like, which writes to every page
        nz, ny, nx = before.shape
        world_from_voxel = local_from_index((nx, ny, nz), world_from_unit)
        brush_from_world = _brush_from_world(brush, normal, world_from_voxel)
        self._brush_from_voxel = brush_from_world @ world_from_voxel[:3, :3]
        self._voxel_from_brush = np.linalg.inv(self._brush_from_voxel)
        self._voxel_from_world = np.linalg.inv(world_from_voxel)
        self._end: tuple[Vector, float] | None = None
        self._smoothed = np.empty(before.shape if brush.mode == "SMOOTH" else (0, 0, 0), np.float32)
        self._smoothed_tiles: set[int] = set()

    def move_to(self, place_m: Vector, pressure: float = 1.0) -> bool:
        """Go on to a place in the world, straight, or begin there. True if the way met voxels."""
        place = self._voxel_from_world[:3, :3] @ np.asarray(place_m, np.float64) + self._voxel_from_world[:3, 3]
        begin, begin_pressure = self._end or (place, pressure)
        self._end = place, pressure
        length = float(np.linalg.norm(self._brush_from_voxel @ (place - begin)))
        largest = max(self._scale(begin_pressure), self._scale(pressure))
        count = max(1, int(np.ceil(length / (_LONGEST_PART * largest))))
        shares = np.linspace(0.0, 1.0, count + 1)
        ends = [(begin + (place - begin) * t, begin_pressure + (pressure - begin_pressure) * t) for t in shares]
        is_met = [self._sweep(*one, *other) for one, other in pairwise(ends)]
        return any(is_met)

    def _sweep(self, begin: Vector, begin_pressure: float, end: Vector, end_pressure: float) -> bool:
        """A part of the way, between voxel coordinates."""
        block = self._bounds(begin, begin_pressure, end, end_pressure)
        if any(part.start >= part.stop for part in block):
            return False
        is_met = False
        z, y, x = block
        layers = max(1, _SLAB_VOXELS // ((y.stop - y.start) * (x.stop - x.start)))
        for start in range(z.start, z.stop, layers):
            slab = slice(start, min(start + layers, z.stop)), y, x
            coverage = self._part_coverage(slab, begin, begin_pressure, end, end_pressure)
            if coverage.any():
                is_met = True
                np.maximum(self._coverage[slab], coverage, out=self._coverage[slab])
                self._blend(slab)
                self.touched |= tiles_in(slab, self.values.shape)
        return is_met

    def _scale(self, pressure: float) -> float:
        """Of the ellipsoid."""
        return max(pressure, 1e-3) if self._brush.pressure_sizes else 1.0

    def _bounds(self, begin: Vector, begin_pressure: float, end: Vector, end_pressure: float) -> Block:
        """The voxels whose centres the swept ellipsoid may hold: along an axis it reaches as far as the row is long."""
        reach = np.linalg.norm(self._voxel_from_brush, axis=1)
        low = np.minimum(begin - reach * self._scale(begin_pressure), end - reach * self._scale(end_pressure))
        high = np.maximum(begin + reach * self._scale(begin_pressure), end + reach * self._scale(end_pressure))
        shape = self.values.shape
        starts = [max(0, int(np.ceil(at))) for at in reversed(low)]
        stops = [min(voxels, int(np.floor(at)) + 1) for at, voxels in zip(reversed(high), shape, strict=True)]
        z, y, x = (slice(start, stop) for start, stop in zip(starts, stops, strict=True))
        return z, y, x

    def _part_coverage(
        self, block: Block, begin: Vector, begin_pressure: float, end: Vector, end_pressure: float
    ) -> FloatArray:
        """Of the voxels of a block, [0, 1], by their distance to the segment in radii of the ellipsoid."""
        axes = [np.arange(part.start, part.stop, dtype=np.float64) for part in reversed(block)]
        steps = [
            (self._brush_from_voxel[:, axis, None] * (axes[axis] - begin[axis])).astype(np.float32) for axis in range(3)
        ]
        way = (self._brush_from_voxel @ (end - begin)).astype(np.float32)
        length_2 = float(way @ way)
        offsets = [steps[2][one][:, None, None] + steps[1][one][:, None] + steps[0][one] for one in range(3)]
        share: FloatArray | np.float32 = np.float32(0.0)
        if length_2 > 0.0:
            share = np.clip(
                sum(offset * (along / length_2) for offset, along in zip(offsets, way, strict=True)), 0.0, 1.0
            )
            offsets = [offset - share * along for offset, along in zip(offsets, way, strict=True)]
        distance_2 = sum(offset * offset for offset in offsets)
        scale = _between(self._scale(begin_pressure), self._scale(end_pressure), share)
        fade = _between(begin_pressure, end_pressure, share) if self._brush.pressure_fades else np.float32(1.0)
        falloff = _falloff(np.sqrt(distance_2) / scale, self._brush.hardness)
        return np.asarray(falloff * (fade * np.float32(self._brush.opacity)), np.float32)

    def _blend(self, block: Block) -> None:
        """Written as a weighted mean: full coverage gives the value to the bit, none what was there."""
        before, coverage, brush = self._before[block], self._coverage[block], self._brush
        if brush.mode == "ADD":
            target: FloatArray | np.float32 = before + np.float32(brush.value)
        elif brush.mode == "MULTIPLY":
            target = before * np.float32(brush.value)
        elif brush.mode == "ERASE":
            target = np.float32(self._kind.neutral)
        elif brush.mode == "SMOOTH":
            target = self._smooth(block)
        else:
            target = np.float32(brush.value)
        blended = (np.float32(1.0) - coverage) * before + coverage * target
        self.values[block] = np.clip(blended, self._kind.lowest, self._kind.highest)

    def _smooth(self, block: Block) -> FloatArray:
        """What was there before, smoothed: each tile once in a stroke."""
        shape = self._before.shape
        for index in tiles_in(block, shape) - self._smoothed_tiles:
            tile = tile_block(index, shape)
            self._smoothed[tile] = _smoothed(self._before, tile)
            self._smoothed_tiles.add(index)
        return self._smoothed[block]


def _between(begin: float, end: float, share: FloatArray | np.float32) -> FloatArray | np.float32:
    return np.float32(begin) if begin == end else np.float32(begin) + share * np.float32(end - begin)


def _falloff(distance: FloatArray, hardness: float) -> FloatArray:
    """1 up to the hardness, 0 from 1 on, and a smooth step between them; ``distance`` is used up."""
    if hardness >= 1.0:
        return (distance <= 1.0).astype(np.float32)
    distance -= np.float32(hardness)
    distance *= np.float32(1.0 / (1.0 - hardness))
    t = np.clip(distance, 0.0, 1.0, out=distance)
    return np.float32(1.0) - t * t * (np.float32(3.0) - np.float32(2.0) * t)


def _smoothed(values: FloatArray, block: Block) -> FloatArray:
    """A block of the whole volume, smoothed; what is beyond the border is as at the border."""
    wide = [
        np.clip(np.arange(part.start - _SMOOTHING_REACH, part.stop + _SMOOTHING_REACH), 0, voxels - 1)
        for part, voxels in zip(block, values.shape, strict=True)
    ]
    smooth: FloatArray = values[np.ix_(*wide)]
    for axis in range(3):
        lines = np.moveaxis(smooth, axis, 0)
        for step in _SMOOTHING_STEPS:
            outer = lines[: -2 * step] + lines[2 * step :]
            lines = np.float32(0.25) * outer + np.float32(0.5) * lines[step:-step]
        smooth = np.moveaxis(lines, 0, axis)
    return smooth


def _brush_from_world(brush: AirBrush, normal: Vector, world_from_voxel: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 3), of directions: the ellipsoid is the unit ball of it.

    It is at least so large that it always holds the centre of a voxel: a brush that is finer than these paints one.
    """
    corners = world_from_voxel[:3, :3] @ (np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1))
    least_m = float(np.linalg.norm(corners, axis=0).max())
    along = np.asarray(normal, np.float64) / np.linalg.norm(normal)
    across = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    across /= np.linalg.norm(across)
    radius_m, depth_m = max(brush.radius_m, least_m), max(brush.depth_m, least_m)
    return np.stack([across / radius_m, np.cross(along, across) / radius_m, along / depth_m])
