# SPDX-License-Identifier: GPL-3.0-or-later
"""How many distinct cubes of a DAG would be left if equal ones might lie shifted, too, not turned alone.

scripts/python benchmarks/voxel_translations_bench.py --context FILE --output FILE [--mesh MESH] [--resolution SIDE...]
As transform-aware DAGs have it (Molenaar and Eisemann 2025): cubes are the same where one of the 48 turns, and a shift
by whole voxels that leaves all of them within the cube, makes them equal. Counted for cubes of 4 (the leaves), 8 and 16
voxels a side.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Iterator

import numpy as np
from bare_meshes import bare_mesh
from numpy.typing import NDArray

from report import Row, argument_parser, row, write_report
from tyndall.voxel_dag import Config, VoxelDag, voxelize

SIDES = (4, 8, 16)
TURNS = tuple(itertools.product(itertools.permutations((1, 2, 3)), itertools.product((1, -1), repeat=3)))
#: Voxels of cubes that are turned at once.
AT_ONCE = 1 << 25

Patterns = NDArray[np.uint8]  #: (n, side^3 / 8): cubes of bits.


def distinct(patterns: Patterns) -> Patterns:
    """Each once."""
    whole = np.ascontiguousarray(patterns).view(np.dtype((np.void, patterns.shape[1]))).ravel()
    return np.unique(whole).view(np.uint8).reshape(-1, patterns.shape[1])


def whole_cubes(dag: VoxelDag, side: int) -> Iterator[NDArray[np.uint32]]:
    """All voxels, some cubes at a time, which Morton order leaves together."""
    rest = np.empty((0, 3), np.uint32)
    for voxels in dag.coordinates():
        rest = np.concatenate([rest, voxels])
        is_of_last = (rest // side == rest[-1] // side).all(axis=1)
        first_of_last = len(rest) - int(np.argmin(np.append(is_of_last[::-1], False)))
        yield rest[:first_of_last]
        rest = rest[first_of_last:]
    yield rest


def patterns_of(voxels: NDArray[np.uint32], side: int) -> Patterns:
    """Of each cube that has one of the voxels, which come cube by cube."""
    cubes, within = voxels // side, voxels % side
    of_cube = np.cumsum(np.append(False, (cubes[1:] != cubes[:-1]).any(axis=1)))
    bits = np.zeros((int(of_cube[-1]) + 1, side, side, side), np.uint8)
    bits[of_cube, *within.T] = 1
    return np.packbits(bits.reshape(len(bits), -1), axis=1)


def cubes_of(dag: VoxelDag, side: int) -> Patterns:
    """The distinct ones, as they lie."""
    found = np.empty((0, side**3 // 8), np.uint8)
    waiting: list[Patterns] = []
    for voxels in whole_cubes(dag, side):
        if len(voxels) > 0:
            waiting.append(patterns_of(voxels, side))
        if sum(map(len, waiting)) > 1 << 20:
            found, waiting = distinct(np.concatenate([found, *waiting])), []
    return distinct(np.concatenate([found, *waiting]))


def shifted_low(bits: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Each cube (n, side, side, side) with its voxels as low as they go along each axis."""
    for axis in (1, 2, 3):
        others = tuple({1, 2, 3} - {axis})
        lowest = bits.any(axis=others).argmax(axis=1)
        for by in range(1, bits.shape[axis]):
            is_so_high = lowest == by
            bits[is_so_high] = np.roll(bits[is_so_high], -by, axis=axis)
    return bits


def representatives(patterns: Patterns, side: int, *, may_shift: bool) -> Patterns:
    """Of each the least of all that it may be turned, and shifted, into."""
    least = np.empty_like(patterns)
    step = AT_ONCE // side**3
    for first in range(0, len(patterns), step):
        bits = np.unpackbits(patterns[first : first + step], axis=1).reshape(-1, side, side, side)
        best = np.full((len(bits), side**3 // 64), ~np.uint64(0), ">u8")
        for axes, steps in TURNS:
            turned = bits.transpose(0, *axes)[:, *(slice(None, None, along) for along in steps)]
            if may_shift:
                turned = shifted_low(turned.copy())
            words = np.packbits(turned.reshape(len(turned), -1), axis=1).view(">u8")
            each, where = np.arange(len(words)), (words != best).argmax(axis=1)
            is_less = words[each, where] < best[each, where]
            best[is_less] = words[is_less]
        least[first : first + step] = best.view(np.uint8)
    return least


def count(mesh: str, resolution: int) -> list[Row]:
    """Rows of one voxel set."""
    positions, triangles = bare_mesh(mesh)
    dag = voxelize(positions, triangles, Config(resolution=resolution))
    turned = {level.side: level.node_count for level in dag.levels()}
    rows = []
    for side in SIDES:
        begin = time.perf_counter()
        cubes = cubes_of(dag, side)
        if len(distinct(representatives(cubes, side, may_shift=False))) != turned[side]:
            raise RuntimeError(f"the DAG's cubes of {side} are others than these")
        left = len(distinct(representatives(cubes, side, may_shift=True)))
        seconds = time.perf_counter() - begin
        rows.append(
            row(
                f"{mesh} {resolution}/cubes of {side}",
                seconds,
                as_they_lie=len(cubes),
                turned=turned[side],
                turned_and_shifted=left,
                saved_percent=100.0 * (1.0 - left / turned[side]),
            )
        )
        print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Count and write the report."""
    parser = argument_parser(__doc__)
    parser.add_argument("--mesh", choices=("dragon", "sponza"), default="dragon")
    parser.add_argument("--resolution", type=int, nargs="+", default=(2048, 4096))
    arguments = parser.parse_args(sys.argv[1:])
    write_report([line for side in arguments.resolution for line in count(arguments.mesh, side)], arguments)


if __name__ == "__main__":
    main()
