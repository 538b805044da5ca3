# SPDX-License-Identifier: GPL-3.0-or-later
"""What making a voxel DAG takes, before it is made, and the refusal of what has no room."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass, replace
from time import perf_counter

from numpy.typing import ArrayLike

from tyndall._native import Progress

from .checks import MOST_INDEX, refuse, whole
from .config import Config
from .meshes import voxelize
from .parts import budget_of, scratch_of

#: What joining and packing take per node of the graph, and a part's file: measured, rounded up.
_MEMORY_BYTES_PER_NODE, _SCRATCH_BYTES_PER_NODE = 100, 32
#: The mesh is made at this resolution and the next, at least, and then while the last one had fewer voxels.
_FIRST_SAMPLE, _FEW_VOXELS = 512, 16_000_000
_FIRST_SOLID_SAMPLE = 128  #: It is full.
_BYTES_PER_SAMPLED_VOXEL = 24  #: Of the last one that may be made more of: the next has four times as many.
_DOUBT = 1.5  #: How far beyond the room a forecast lies before anything is refused for it.
LEAST_RESOLUTION, MOST_RESOLUTION = 4, 131_072


@dataclass(frozen=True, kw_only=True)
class Forecast:
    """What making a voxel DAG out of core takes: extrapolated, seldom off by a factor of two."""

    resolution: int  #: Voxels a side.
    voxel_count: int
    memory_bytes: int  #: Of the graph while it is joined and packed; parts take what the budget allows.
    scratch_bytes: int  #: Of the parts' files.
    file_bytes: int
    seconds: float  #: On this machine, as it is now.

    def __str__(self) -> str:
        return (
            f"about {self.voxel_count / 1e6:,.1f} million voxels at {self.resolution}, "
            f"{self.file_bytes / 1e6:,.1f} MB of file, {self.memory_bytes / 2**20:,.0f} MiB of memory, "
            f"{self.scratch_bytes / 1e6:,.0f} MB of scratch, {self.seconds:,.0f} s"
        )


def forecast(
    positions_m: ArrayLike, triangles: ArrayLike, config: Config | None = None, progress: Progress | None = None
) -> Forecast:
    """What ``voxelize_to_file`` takes, from two small resolutions of the mesh and how it grows between them.

    Takes a second or so. Raises InvalidInput, which names the vertex, the triangle or the setting, and Cancelled.
    """
    return _forecasts(positions_m, triangles, config or Config(), progress or Progress())[-1]


def _forecasts(positions_m: ArrayLike, triangles: ArrayLike, config: Config, progress: Progress) -> list[Forecast]:
    """By resolution, up to that of the configuration."""
    resolution = whole("resolution", config.resolution, MOST_INDEX)
    if resolution.bit_count() != 1 or not LEAST_RESOLUTION <= resolution <= MOST_RESOLUTION:
        raise refuse(
            f"resolution is {resolution}; powers of two from {LEAST_RESOLUTION} to {MOST_RESOLUTION} are possible"
        )
    samples: list[Forecast] = []
    few_voxels = min(_FEW_VOXELS, budget_of(config) // _BYTES_PER_SAMPLED_VOXEL)
    at = min(_FIRST_SOLID_SAMPLE if config.solid else _FIRST_SAMPLE, resolution)
    while at <= resolution and (len(samples) < 2 or samples[-1].voxel_count < few_voxels):  # noqa: PLR2004
        started = perf_counter()
        dag = voxelize(positions_m, triangles, replace(config, resolution=at, memory_budget_bytes=None), progress)
        samples.append(
            Forecast(
                resolution=at,
                voxel_count=dag.voxel_count,
                memory_bytes=_MEMORY_BYTES_PER_NODE * dag.node_count,
                # Numbers of materials lie in the parts, and once more before their size is known.
                scratch_bytes=_SCRATCH_BYTES_PER_NODE * dag.node_count + 2 * dag.attribute_bytes,
                file_bytes=dag.geometry_bytes + dag.attribute_bytes,
                seconds=perf_counter() - started,
            )
        )
        at *= 2
    while samples[-1].resolution < resolution:
        before, last = samples[-2:]
        growth = min(max(last.voxel_count / max(before.voxel_count, 1), 4.0), 8.0) if config.solid else 4.0
        # Between 2 and 4: each node of a surface becomes four, some of which are there already.
        nodes, file = (
            min(max(now / max(then, 1), 2.0), 4.0)
            for then, now in ((before.memory_bytes, last.memory_bytes), (before.file_bytes, last.file_bytes))
        )
        samples.append(
            Forecast(
                resolution=2 * last.resolution,
                voxel_count=round(growth * last.voxel_count),
                memory_bytes=round(last.memory_bytes * nodes),
                scratch_bytes=round(last.scratch_bytes * nodes),
                file_bytes=round(last.file_bytes * file),
                seconds=growth * last.seconds,
            )
        )
    return samples


def require_room(
    positions_m: ArrayLike,
    triangles: ArrayLike,
    path: str | os.PathLike[str],
    config: Config,
    *,
    scratch: str | os.PathLike[str] | None,
    progress: Progress,
) -> None:
    """Refuse before an hour of work what memory or disk have no room for, by far. Raises InvalidInput and Cancelled."""
    forecasts = _forecasts(positions_m, triangles, config, progress)
    folder = scratch_of(path, scratch)
    while not folder.exists():
        folder = folder.parent
    rooms = {"memory, by its budget": budget_of(config), f"disk, in {folder}": shutil.disk_usage(folder).free}

    def lacking(one: Forecast) -> list[str]:
        needs = (one.memory_bytes, one.scratch_bytes + one.file_bytes)
        return [
            f"{room >> 20} MiB of {name}, and about {need >> 20} MiB are needed"
            for (name, room), need in zip(rooms.items(), needs, strict=True)
            if need > _DOUBT * room
        ]

    wrong = lacking(forecasts[-1])
    if wrong:
        fitting = [one.resolution for one in forecasts if not lacking(one)]
        advice = f"a resolution of {fitting[-1]} would fit" if fitting else "no resolution would fit"
        raise refuse(f"a resolution of {config.resolution}: there are {'; '.join(wrong)}; {advice}")
