# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments as the native module takes them, or a refusal that names what is wrong with them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyndall import _native

from .config import Config

MOST_BYTES = 2**64 - 1
MOST_INDEX = 2**32 - 1
MOST_LEVEL = 17  #: Of the largest cube, 131072 voxels a side.
MOST_BYTE = 255


def budget(config: Config) -> int:
    """Bytes that may be used; without a budget, as many as can be counted."""
    if config.memory_budget_bytes is None:
        return MOST_BYTES
    return whole("memory_budget_bytes", config.memory_budget_bytes, MOST_BYTES)


def refuse(message: str) -> Exception:
    """What to raise where an argument cannot be used."""
    return _native.InvalidInput(f"voxel DAG: {message}")


def whole(name: str, value: object, most: int) -> int:
    """A whole number in [0, most]."""
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or not 0 <= value <= most:
        raise refuse(f"{name} is {value!r}, not a whole number in [0, {most}]")
    return int(value)


def doublings(level: int | None, resolution: int) -> int:
    """How often voxels are doubled to cubes of which 2 ** level lie along a side; None: not at all."""
    finest = resolution.bit_length() - 1
    return 0 if level is None else finest - whole("level", level, finest)


def named(kind: Any, name: str, value: str) -> Any:  # noqa: ANN401 - an enumeration of the native module
    """The member of an enumeration, by its name in lower case."""
    members = {key.lower(): member for key, member in kind.__members__.items()}
    if value not in members:
        raise refuse(f"{name} is {value!r}, not one of {', '.join(members)}")
    return members[value]


def rows_of_three(values: ArrayLike, name: str) -> NDArray[Any]:
    """An array (n, 3) of any type."""
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise refuse(f"{name}: {error}") from None
    if array.size == 0:
        return np.zeros((0, 3), np.uint32)
    if array.ndim != 2 or array.shape[1] != 3:  # noqa: PLR2004 - x, y and z
        raise refuse(f"{name} have the shape {array.shape}, not (n, 3)")
    return array


def points(values: ArrayLike, name: str) -> NDArray[np.float32] | NDArray[np.float64]:
    """Numbers (n, 3): float32 stays what it is, all else becomes float64."""
    array = rows_of_three(values, name)
    if array.dtype.kind not in "fiu":
        raise refuse(f"{name} are {array.dtype}, not numbers")
    return np.ascontiguousarray(array, array.dtype if array.dtype in (np.float32, np.float64) else np.float64)


def per_row(values: ArrayLike, count: int, name: str) -> NDArray[np.float64]:
    """A number for each of ``count`` rows, (count,), of as many or of one for all."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiu" or array.shape not in ((), (count,)):
        raise refuse(f"{name}: {array.dtype} of the shape {array.shape}, not one number or ({count},)")
    return np.ascontiguousarray(np.broadcast_to(array, (count,)), np.float64)


def indices(values: ArrayLike, name: str) -> NDArray[np.uint32]:
    """Whole numbers (n, 3) that 32 bits hold."""
    array = rows_of_three(values, name)
    if array.dtype.kind not in "iu":
        raise refuse(f"{name} are {array.dtype}, not whole numbers")
    if array.dtype != np.uint32 and array.size and not 0 <= array.min() <= array.max() <= MOST_INDEX:
        wrong = int(np.argmax(((array < 0) | (array > MOST_INDEX)).any(axis=1)))
        raise refuse(f"{name}: row {wrong} is {array[wrong].tolist()}, outside [0, {MOST_INDEX}]")
    return np.ascontiguousarray(array, np.uint32)


def listed(values: ArrayLike, rows: int, name: str) -> NDArray[Any]:
    """An array of as many rows."""
    array = np.asarray(values)
    if len(array) != rows if array.ndim else True:
        raise refuse(f"{name} have the shape {array.shape}, not {rows} rows")
    return array


def colors(values: ArrayLike | None, rows: int) -> NDArray[np.uint8] | None:
    """Bytes (rows, 3), of such or of numbers from 0 to 1."""
    if values is None:
        return None
    array = listed(rows_of_three(values, "colors"), rows, "colors")
    if array.dtype == np.uint8 or not rows:
        return np.ascontiguousarray(array, np.uint8)
    if array.dtype.kind != "f":
        raise refuse(f"colors are {array.dtype}, neither uint8 nor numbers from 0 to 1")
    is_wrong = ~((array >= 0) & (array <= 1)).all(axis=1)
    if is_wrong.any():
        wrong = int(np.argmax(is_wrong))
        raise refuse(f"colors: row {wrong} is {array[wrong].tolist()}, outside [0, 1]")
    return np.ascontiguousarray(np.rint(255 * array), np.uint8)


def normals(values: ArrayLike | None, rows: int) -> NDArray[np.float32] | None:
    """Directions (rows, 3)."""
    if values is None:
        return None
    return np.ascontiguousarray(listed(points(values, "normals"), rows, "normals"), np.float32)


def channels(values: Mapping[str, ArrayLike] | None, rows: int) -> list[tuple[str, NDArray[np.uint8]]]:
    """Names, and bytes (rows,) of each."""
    named_values = []
    for name, given in (values or {}).items():
        array = listed(given, rows, f"the values of channel {name!r}")
        if array.ndim != 1 or array.dtype.kind not in "iu":
            raise refuse(f"the values of channel {name!r} are {array.dtype} {array.shape}, not whole numbers (n,)")
        if array.size and not 0 <= array.min() <= array.max() <= MOST_BYTE:
            raise refuse(f"the values of channel {name!r} reach from {array.min()} to {array.max()}, beyond [0, 255]")
        named_values.append((name, np.ascontiguousarray(array, np.uint8)))
    return named_values


def attribute_config(config: Config) -> _native.VoxelAttributeConfig:
    """How attributes are stored."""
    if config.color_count == 0 or config.most_color_difference == 0:
        raise refuse("color_count or most_color_difference is 0: leave it out to keep all colors")
    return _native.VoxelAttributeConfig(
        color_count=whole("color_count", config.color_count or 0, MOST_INDEX),
        most_color_difference=float(config.most_color_difference or 0.0),
        normal_bits=whole("normal_bits", config.normal_bits, MOST_INDEX),
    )


def check_no_rows(config: Config) -> None:
    """Refuse attributes that are listed voxel by voxel."""
    if config.colors is not None or config.normals is not None or config.channels:
        raise refuse("config has colors, normals or channels, rows of a list of voxels: use from_coordinates")


def cube(bounds_m: ArrayLike | None) -> tuple[list[float], float] | None:
    """Lower corner and side."""
    if bounds_m is None:
        return None
    corners = np.asarray(rows_of_three(bounds_m, "bounds_m"), np.float64)
    if corners.shape != (2, 3) or not np.isfinite(corners).all():
        raise refuse(f"bounds_m are {np.asarray(bounds_m).tolist()}, not two corners")
    sides = corners[1] - corners[0]
    if not (sides > 0).all() or not np.allclose(sides, sides[0], rtol=1e-6, atol=0.0):
        raise refuse(f"bounds_m have the sides {sides.tolist()} m, not those of a cube")
    return corners[0].tolist(), float(sides.max())
