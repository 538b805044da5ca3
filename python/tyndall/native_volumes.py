# SPDX-License-Identifier: GPL-3.0-or-later
"""Density grids in native memory: each is sent once, by its key."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from .native_scene import NativeParts
    from .scene_description import DensityGrid, Volume


def build_volumes(
    volumes: Iterable[Volume],
    parts: NativeParts,
    origin: NDArray[np.float64],
    reports: list[str],
    progress: _native.Progress,
) -> list[_native.VolumeInstance]:
    """Those whose grid can be used. New grids go into ``parts``, those that are gone leave it. Raises Cancelled."""
    kept: dict[str, _native.DensityGrid] = {}
    refused: set[str] = set()
    built = []
    for volume in volumes:
        key = volume.grid.key
        if key not in kept and key not in refused:
            try:
                kept[key] = _native_grid(volume.grid, parts, reports, progress)
            except _native.InvalidInput as error:
                reports.append(f'Volume "{volume.name}" is left out: {error}')
                refused.add(key)
        if key in kept:
            built.append(_build_volume(volume, kept[key], origin))
    parts.grids = kept
    return built


def _native_grid(
    source: DensityGrid, parts: NativeParts, reports: list[str], progress: _native.Progress
) -> _native.DensityGrid:
    native = parts.grids.get(source.key)
    parts.counts["grids sent" if native is None else "grids reused"] += 1
    if native is not None:
        return native
    grids = (source.grid, *source.further)
    reports += [
        f'grid "{grid.name}" has a background of {grid.background:g}, read as 0: its density would have no end'
        for grid in grids
        if grid.background != 0.0
    ]
    progress.message = f"Sending {source.grid.name}"
    native = _native.DensityGrid(
        channels=[
            (
                grid.name,
                np.ascontiguousarray(grid.leaf_origins, np.int32),
                np.ascontiguousarray(grid.leaf_values, np.float32),
            )
            for grid in grids
        ],
        local_from_index=np.ascontiguousarray(source.grid.local_from_index, np.float64),
        progress=progress,
    )
    parts.grids[source.key] = native  # what a cancelled update has built serves the next one
    return native


def _build_volume(volume: Volume, grid: _native.DensityGrid, origin: NDArray[np.float64]) -> _native.VolumeInstance:
    matrix: NDArray[Any] = volume.world_from_object.astype(np.float64)
    matrix[:3, 3] -= origin
    with np.errstate(over="ignore"):  # what does not fit becomes infinite: the scene drops it with a report
        return _native.VolumeInstance(
            name=volume.name,
            grid=grid,
            channel=volume.channel,
            medium=volume.medium,
            world_from_local=matrix.astype(np.float32, order="C"),
            density_scale=volume.density_scale,
        )
