# SPDX-License-Identifier: GPL-3.0-or-later
"""Densities that a program gives at points of a closed mesh, as a grid of voxels.

Based on: trilinear interpolation between the centres of voxels, halved until it is as near to the program as asked.
Differs:  voxels are halved along those axes alone along which straight lines miss the program: air in layers has thin
          ones. Where the mesh does not fill a voxel its density is that share of it: an edge is a voxel wide, half
          of it outside. Where a voxel is no small part of a free path, the light that the field scatters
          counts, too (field_light.py). All fields of a mesh have the same voxels, as fine as the one that bends most
          asks for: a ray walks through them together.
Bound:    one evaluation of each program per voxel, at most as many more for coarser grids, a fifth more where it is
          dense; 4 bytes per voxel and field.
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
from .voxel_dag import filled_shares

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

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
_MOST_CHANNELS = 4  #: Of a grid.


@dataclass(frozen=True, eq=False)
class Field:
    """What varies: one channel of what a program gives."""

    program: Material
    channel: int
    sigma_t_per_m: float  #: The greatest extinction coefficient where it is 1.


@dataclass(frozen=True, eq=False)
class SampledFields:
    """The grid of each field that is not 0 everywhere, all of the same voxels, and what is to be said of them."""

    grids: tuple[tuple[DensityGrid, int] | None, ...]  #: And its channel.
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Voxels:
    """Of a box that begins at ``lower``; (3,) each."""

    lower: NDArray[np.float64]
    step: NDArray[np.float64]
    counts: NDArray[np.int64]

    def places(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """In voxels."""
        return (positions - self.lower) / self.step


def fields_key(fields: Sequence[Field], mesh: Mesh, place: PointPlace, most_voxels: int) -> str:
    """Equal where the grids are: of all instances, wherever they go, that ask for no more than places in the mesh."""
    read = tuple(
        (field.program, field.channel, place.read_by(field.program), _optical(field, place)) for field in fields
    )
    return f"{mesh.key} holds {fingerprint((read, most_voxels)).hex()}"


def _optical(field: Field, place: PointPlace) -> str:
    return f"{field.sigma_t_per_m * place.unit_m():.3g}"  # turned instances differ by rounding


def sampled(
    fields: Sequence[Field],
    mesh: Mesh,
    place: PointPlace,
    key: str,
    most_voxels: int,
    poll: Callable[[], None],
) -> SampledFields:
    """At most ``most_voxels`` to the third in the box of a closed mesh; ``poll`` may raise between parts.

    Raises InvalidInput of a mesh without a volume, and IoError of textures that lie in a file.
    """
    lower, upper = mesh.positions.min(axis=0).astype(np.float64), mesh.positions.max(axis=0)
    sides = upper - lower
    if not (np.isfinite(sides).all() and (sides > 0.0).all()):
        raise InvalidInput(f'mesh "{mesh.name}" is flat or not finite, and holds no volume')
    notes: list[str] = []
    values_at = _Together(fields, place, notes)
    probes = lower + np.random.default_rng(1).random((_PROBES, 3)) * sides
    truth = values_at(probes)
    sizes = np.sqrt(np.mean(truth**2, axis=0, dtype=np.float64))
    scales = np.where(sizes > 0.0, sizes, 1.0)
    counts = np.maximum(np.ceil(_FIRST_VOXELS * sides / sides.max() - 1e-6).astype(np.int64), 1)
    while True:
        voxels = _Voxels(lower, sides / counts, counts)
        dense = _evaluated(values_at, len(fields), voxels, poll)
        errors = _rms(_interpolated(dense, voxels.places(probes)) - truth)
        is_far = errors > ERROR_TARGET * sizes
        bends = np.zeros(3)
        if is_far.any():
            of_fields = _bends(values_at, probes, truth, (lower, upper), voxels.step) / scales
            bends = of_fields[:, is_far].max(axis=1)
        finer = _halved(counts, voxels.step, bends, most_voxels)
        of_light = LightError(0.0, 0.0)
        if finer is None or not is_far.any():
            of_light = _light_error(fields, values_at, dense, place, voxels, poll)
        if finer is None or (not is_far.any() and of_light.rms <= LIGHT_ERROR_TARGET):
            break
        counts = finer
    dense *= filled_shares(mesh.positions, mesh.triangles, lower, voxels.step, counts)[..., np.newaxis]
    local_from_index = np.diag([*voxels.step, 1.0])
    local_from_index[:3, 3] = lower + 0.5 * voxels.step
    if is_far.any() or of_light.rms > LIGHT_ERROR_TARGET:
        by = " x ".join(str(count) for count in counts)
        said = f"its varying volume is drawn from {by} voxels, {100.0 * (errors / scales).max():.0f} % off between them"
        if of_light.rms > LIGHT_ERROR_TARGET:
            said += (
                "; light ends within a few of them: what it scatters is about"
                f" {100.0 * of_light.rms:.0f} % off from one line of sight to the next,"
                f" {100.0 * of_light.of_sum:+.0f} % on the whole"
            )
        notes.append(said)
    return SampledFields(_joined(dense, local_from_index, key), tuple(notes))


def _joined(
    dense: FloatArray, local_from_index: NDArray[np.float64], key: str
) -> tuple[tuple[DensityGrid, int] | None, ...]:
    """As SampledFields has them, of the values of all fields in each voxel."""
    found: list[tuple[DensityGrid, int] | None] = [None] * dense.shape[3]
    there = np.flatnonzero(dense.any(axis=(0, 1, 2)))
    for first in range(0, len(there), _MOST_CHANNELS):
        fields = there[first : first + _MOST_CHANNELS]
        parts = [from_dense("density", np.ascontiguousarray(dense[..., field]), local_from_index) for field in fields]
        grid = DensityGrid(key=f"{key} {first}", grid=parts[0], further=tuple(parts[1:]))
        for channel, field in enumerate(fields):
            found[field] = grid, channel
    return tuple(found)


class _Together:
    """All fields at once: each program is asked once for all of its channels."""

    def __init__(self, fields: Sequence[Field], place: PointPlace, notes: list[str]) -> None:
        programs = dict.fromkeys(field.program for field in fields)
        self._values = [values_of(program, place, notes) for program in programs]
        order = {program: index for index, program in enumerate(programs)}
        self._parts = [(order[field.program], field.channel) for field in fields]

    def __call__(self, positions: NDArray[np.float64]) -> FloatArray:
        """(n, fields), for positions (n, 3)."""
        found = [values(positions, {}) for values in self._values]
        return np.stack([found[program][:, channel] for program, channel in self._parts], axis=-1)

    def of_field(self, index: int) -> Callable[[NDArray[np.float64]], FloatArray]:
        """Gives (n,)."""
        program, channel = self._parts[index]
        return lambda positions: self._values[program](positions, {})[:, channel]


def _rms(values: FloatArray) -> NDArray[np.float64]:
    """Of each column."""
    return np.asarray(np.sqrt(np.mean(values**2, axis=0, dtype=np.float64)))


def _light_error(
    fields: Sequence[Field],
    values_at: _Together,
    dense: FloatArray,
    place: PointPlace,
    voxels: _Voxels,
    poll: Callable[[], None],
) -> LightError:
    """The worst one of those fields of which a voxel is no small part of a free path."""
    worst = LightError(0.0, 0.0)
    for index, field in enumerate(fields):
        sigma_t = field.sigma_t_per_m * place.unit_m()
        if sigma_t * float(dense[..., index].max() * voxels.step.max()) <= _THICK:
            continue
        poll()

        def between(positions: NDArray[np.float64], index: int = index) -> FloatArray:
            return _interpolated(dense[..., index, np.newaxis], voxels.places(positions))[:, 0]

        found = light_error(values_at.of_field(index), between, voxels.lower, voxels.step, voxels.counts, sigma_t)
        worst = max(worst, found, key=lambda error: error.rms)
    return worst


def _bends(
    values_at: _Together,
    probes: NDArray[np.float64],
    truth: FloatArray,
    box: tuple[NDArray[np.float64], NDArray[np.float64]],
    step: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Per axis and field, (3, fields): how far it is off a straight line through one voxel, RMS."""
    found = np.zeros((3, truth.shape[1]))
    for axis in range(3):
        half = np.zeros(3)
        half[axis] = 0.5 * step[axis]
        before, behind = (values_at(np.clip(probes + way * half, *box)) for way in (-1.0, 1.0))
        found[axis] = _rms(0.5 * (before + behind) - truth)
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


def _evaluated(values_at: _Together, field_count: int, voxels: _Voxels, poll: Callable[[], None]) -> FloatArray:
    """(nx, ny, nz, fields), at the centres of voxels."""
    nx, ny, nz = voxels.counts
    dense = np.empty((nx, ny, nz, field_count), np.float32)
    x, y, z = (voxels.lower[axis] + (np.arange(voxels.counts[axis]) + 0.5) * voxels.step[axis] for axis in range(3))
    slices = max(int(_POINTS_AT_ONCE // (ny * nz)), 1)
    for first in range(0, int(nx), slices):
        poll()
        points = np.stack(np.meshgrid(x[first : first + slices], y, z, indexing="ij"), axis=-1).reshape(-1, 3)
        dense[first : first + slices] = values_at(points).reshape(-1, ny, nz, field_count)
    return dense


def _interpolated(dense: FloatArray, at: NDArray[np.float64]) -> FloatArray:
    """Trilinear at places in voxels, (n, fields); before the first centres and behind the last it is as there."""
    last = np.array(dense.shape[:3]) - 1
    place = np.clip(at - 0.5, 0.0, last)
    first = np.minimum(place.astype(np.int64), np.maximum(last - 1, 0))
    share = place - first
    found = np.zeros((len(at), dense.shape[3]))
    for corner in np.ndindex(2, 2, 2):
        index = np.minimum(first + corner, last)
        found += dense[tuple(index.T)] * np.where(corner, share, 1.0 - share).prod(axis=1)[:, np.newaxis]
    return found.astype(np.float32)
