# SPDX-License-Identifier: GPL-3.0-or-later
"""Densities that a program gives at points of a closed mesh, as a grid of voxels.

Based on: trilinear interpolation between the centres of voxels, halved until it is as near to the program as asked.
Differs:  voxels are halved along those axes alone along which straight lines miss the program: air in layers has thin
          ones. Where the mesh does not fill a voxel its density is that share of it, of 8 places: an edge is a voxel
          wide, half of it outside. Where a voxel is no small part of a free path, the light that the field scatters
          counts, too (field_light.py).
Bound:    one evaluation of the program per voxel, at most as many more for coarser grids, a fifth more where it is
          dense; 4 bytes per voxel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import InvalidInput
from .field_light import LightError, light_error
from .fingerprints import fingerprint
from .program_points import values_of
from .scene_description import DensityGrid
from .volumes import from_dense
from .voxel_dag import Config, voxelize

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .program_points import PointPlace
    from .scene_description import Material, Mesh

    FloatArray = NDArray[np.float32]

#: Relative RMS error between voxels at which they are fine enough.
ERROR_TARGET = 0.01
#: The same of the light that it scatters, from one line of sight to the next, where it is dense.
LIGHT_ERROR_TARGET = 0.03
_THICK = 0.1  #: Optical depth of a voxel from which on that is asked.
_FIRST_VOXELS = 32  #: Along the longest side.
_ABOUT_AS_MUCH = 0.5  #: Relative, of the axes that are halved together.
_MOST_ALONG_AXIS = 2048  #: Voxels.
_PROBES = 4096  #: Places at which the error is measured.
_POINTS_AT_ONCE = 1 << 20


@dataclass(frozen=True, eq=False)
class SampledField:
    """A grid, and what is to be said of it."""

    grid: DensityGrid
    notes: tuple[str, ...]


#: And the channel of what it gives that is the density.
ChannelOf = tuple["Material", int]


def field_key(program: ChannelOf, mesh: Mesh, place: PointPlace, sigma_t_per_m: float, most_voxels: int) -> str:
    """Equal where the grid is: of all instances, wherever they go, if no more is asked for than places in the mesh."""
    of_object = place.read_by(program[0])
    optical = f"{sigma_t_per_m * place.unit_m():.3g}"  # turned instances differ by rounding
    return f"{mesh.key} holds {fingerprint((program, of_object, optical, most_voxels)).hex()}"


def sampled(
    program: ChannelOf,
    mesh: Mesh,
    place: PointPlace,
    key: str,
    sigma_t_per_m: float,
    most_voxels: int,
    poll: Callable[[], None],
) -> SampledField:
    """At most ``most_voxels`` to the third in the box of a closed mesh; ``poll`` may raise between parts.

    ``sigma_t_per_m`` is the greatest extinction coefficient where the program gives 1.

    Raises InvalidInput of a mesh without a volume, and IoError of textures that lie in a file.
    """
    lower, upper = mesh.positions.min(axis=0).astype(np.float64), mesh.positions.max(axis=0)
    sides = upper - lower
    if not (np.isfinite(sides).all() and (sides > 0.0).all()):
        raise InvalidInput(f'mesh "{mesh.name}" is flat or not finite, and holds no volume')
    notes: list[str] = []
    values, channel = values_of(program[0], place, notes), program[1]

    def values_at(positions: NDArray[np.float64]) -> FloatArray:
        return values(positions, {})[:, channel]

    probes = lower + np.random.default_rng(1).random((_PROBES, 3)) * sides
    truth = values_at(probes)
    size = float(np.sqrt(np.mean(truth**2)))
    sigma_t = sigma_t_per_m * place.unit_m()
    counts = np.maximum(np.ceil(_FIRST_VOXELS * sides / sides.max() - 1e-6).astype(np.int64), 1)
    while True:
        step = sides / counts
        dense = _evaluated(values_at, lower, step, counts, poll)

        def between(
            positions: NDArray[np.float64], dense: FloatArray = dense, step: NDArray[np.float64] = step
        ) -> FloatArray:
            return _interpolated(dense, (positions - lower) / step)

        error = float(np.sqrt(np.mean((between(probes) - truth) ** 2)))
        is_near = error <= ERROR_TARGET * size
        bends = np.zeros(3) if is_near else _bends(values_at, probes, truth, (lower, upper), step)
        finer = _halved(counts, step, bends, most_voxels)
        of_light = LightError(0.0, 0.0)
        if (is_near or finer is None) and sigma_t * float(dense.max() * step.max()) > _THICK:
            poll()
            of_light = light_error(values_at, between, lower, step, counts, sigma_t)
        if finer is None or (is_near and of_light.rms <= LIGHT_ERROR_TARGET):
            break
        counts = finer
    dense *= _coverage(mesh, lower, step, counts)
    local_from_index = np.diag([*step, 1.0])
    local_from_index[:3, 3] = lower + 0.5 * step
    if error > ERROR_TARGET * size or of_light.rms > LIGHT_ERROR_TARGET:
        by = " x ".join(str(count) for count in counts)
        said = f"its varying volume is drawn from {by} voxels, {100.0 * error / size:.0f} % off between them"
        if of_light.rms > LIGHT_ERROR_TARGET:
            said += (
                "; light ends within a few of them: what it scatters is about"
                f" {100.0 * of_light.rms:.0f} % off from one line of sight to the next,"
                f" {100.0 * of_light.of_sum:+.0f} % on the whole"
            )
        notes.append(said)
    return SampledField(DensityGrid(key=key, grid=from_dense("density", dense, local_from_index)), tuple(notes))


def _bends(
    values_at: Callable[[NDArray[np.float64]], FloatArray],
    probes: NDArray[np.float64],
    truth: FloatArray,
    box: tuple[NDArray[np.float64], NDArray[np.float64]],
    step: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Per axis: how far the program is off a straight line through one voxel, RMS."""
    found = np.zeros(3)
    for axis in range(3):
        half = np.zeros(3)
        half[axis] = 0.5 * step[axis]
        before, behind = (values_at(np.clip(probes + way * half, *box)) for way in (-1.0, 1.0))
        found[axis] = np.sqrt(np.mean((0.5 * (before + behind) - truth) ** 2))
    return found


def _halved(
    counts: NDArray[np.int64], step: NDArray[np.float64], bends: NDArray[np.float64], most_voxels: int
) -> NDArray[np.int64] | None:
    """Counts of the next grid: twice as many along the axes that bend about as much as any; None: no room for more.

    Where none bends the longest sides of voxels are halved.
    """
    weights = bends if bends.any() else step
    finer = counts.copy()
    for axis in np.argsort(-weights, kind="stable"):
        is_due = weights[axis] >= _ABOUT_AS_MUCH * weights.max()
        if is_due and 2 * int(finer.prod()) <= most_voxels**3 and 2 * finer[axis] <= _MOST_ALONG_AXIS:
            finer[axis] *= 2
    return None if (finer == counts).all() else finer


def _evaluated(
    values_at: Callable[[NDArray[np.float64]], FloatArray],
    lower: NDArray[np.float64],
    step: NDArray[np.float64],
    counts: NDArray[np.int64],
    poll: Callable[[], None],
) -> FloatArray:
    """(nx, ny, nz), at the centres of voxels."""
    dense = np.empty(tuple(counts), np.float32)
    y, z = (lower[axis] + (np.arange(counts[axis]) + 0.5) * step[axis] for axis in (1, 2))
    slices = max(int(_POINTS_AT_ONCE // (counts[1] * counts[2])), 1)
    for first in range(0, int(counts[0]), slices):
        poll()
        x = lower[0] + (np.arange(first, min(first + slices, counts[0])) + 0.5) * step[0]
        points = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
        dense[first : first + slices] = values_at(points).reshape(len(x), len(y), len(z))
    return dense


def _interpolated(dense: FloatArray, at: NDArray[np.float64]) -> FloatArray:
    """Trilinear at places in voxels; what lies before the first centres and behind the last has their values."""
    last = np.array(dense.shape) - 1
    place = np.clip(at - 0.5, 0.0, last)
    first = np.minimum(place.astype(np.int64), np.maximum(last - 1, 0))
    share = place - first
    found = np.zeros(len(at))
    for corner in np.ndindex(2, 2, 2):
        index = np.minimum(first + corner, last)
        found += dense[tuple(index.T)] * np.where(corner, share, 1.0 - share).prod(axis=1)
    return found.astype(np.float32)


def _coverage(
    mesh: Mesh, lower: NDArray[np.float64], step: NDArray[np.float64], counts: NDArray[np.int64]
) -> FloatArray | np.float32:
    """Shares of voxels inside the mesh; 1 of all where it fills its box."""
    corners = mesh.positions.astype(np.float64)[mesh.triangles] - lower
    volume = abs(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6.0
    if volume > (1.0 - 1e-4) * float((counts * step).prod()):
        return np.float32(1.0)
    longest = float((counts * step).max())
    resolution = 1 << int(np.ceil(np.log2(min(2.0 * longest / float(step.min()), _MOST_ALONG_AXIS))))
    solid = voxelize(
        mesh.positions,
        mesh.triangles,
        Config(resolution=resolution, solid=True, bounds_m=(tuple(lower), tuple(lower + longest))),
    )
    inside = np.zeros(tuple(counts), np.uint8)
    for corner in np.ndindex(2, 2, 2):
        x, y, z = (
            ((np.arange(counts[axis]) + 0.25 + 0.5 * corner[axis]) * step[axis] * (resolution / longest)).astype(
                np.uint32
            )
            for axis in range(3)
        )
        across, up = (axis.ravel() for axis in np.meshgrid(y, z, indexing="ij"))
        for index, place in enumerate(x):
            column = np.full(across.size, place, np.uint32)
            inside[index] += solid.contains(np.column_stack([column, across, up])).reshape(len(y), len(z))
    return inside.astype(np.float32) / np.float32(8.0)
