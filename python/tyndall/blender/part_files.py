# SPDX-License-Identifier: GPL-3.0-or-later
"""Tiles of view layers in files, .npz: planes by view and pass, and what the render told; put together again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Planes = dict[str, NDArray[np.float32]]
_STATISTICS, _STAMPS = "statistics", "stamps"


def write_part(
    path: Path, films: Mapping[str, Planes], statistics: dict[str, Any], stamps: dict[str, str] | None = None
) -> None:
    """``films``: planes, (height, width, channels), by view; ``stamps``: what files say about them."""
    arrays: dict[str, Any] = {
        _STATISTICS: np.array(json.dumps(statistics)),
        _STAMPS: np.array(json.dumps(stamps or {})),
    }
    arrays |= {json.dumps([view, plane]): values for view, planes in films.items() for plane, values in planes.items()}
    with path.open("wb") as file:
        np.savez(file, **arrays)


def read_parts(
    tiles: Mapping[str, Sequence[Sequence[Path]]],
) -> tuple[dict[tuple[str, str], Planes], list[dict[str, Any]]]:
    """Planes by layer and view, of tiles by layer, row by row from below; and the statistics of all of them."""
    films: dict[tuple[str, str], Planes] = {}
    statistics = []
    for layer, rows in tiles.items():
        read = [[_read(path) for path in row] for row in rows]
        statistics += [told for row in read for _, told in row]
        for view, planes in read[0][0][0].items():
            films[layer, view] = {
                name: np.concatenate([np.concatenate([tile[view][name] for tile, _ in row], axis=1) for row in read])
                for name in planes
            }
    return films, statistics


def read_stamps(path: Path) -> dict[str, str]:
    """What files say about the picture: all tiles of a layer tell the same."""
    with np.load(path, allow_pickle=False) as file:
        stamps: dict[str, str] = json.loads(str(file[_STAMPS]))
        return stamps


def _read(path: Path) -> tuple[dict[str, Planes], dict[str, Any]]:
    """Planes by view, and the statistics."""
    films: dict[str, Planes] = {}
    with np.load(path, allow_pickle=False) as file:
        for key in file.files:
            if key not in (_STATISTICS, _STAMPS):
                view, plane = json.loads(key)
                films.setdefault(view, {})[plane] = file[key]
        return films, json.loads(str(file[_STATISTICS]))
