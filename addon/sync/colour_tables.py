# SPDX-License-Identifier: GPL-3.0-or-later
"""Ramps, curves and spectra as tables of a surface program, at the steps at which Cycles samples them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.scene_description import Code

from .blackbody import COLDEST_K, HOTTEST_K, blackbody
from .cie_1931 import FIRST_NM, LAST_NM, spectral_colours

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .program import Program, Value

STEPS = 256 if bpy.app.version >= (4, 0, 0) else 255  #: Of ramps and curves in Cycles.
_OF_COLOURS = 4  #: Curves: of red, green, blue, and of all.
_BLACKBODY_STEPS = 2240  #: Of 5 K.
_IS_STEPPED, _GOES_ON = 1, 2  # CurveOptions of shading/op_colour.hpp
_COLOUR, _ALPHA, _EACH = 0, 1, 2  # CurveOf


@dataclass(frozen=True, eq=False)
class Table:
    """Colours with alpha, (steps, 4), at even steps from ``first`` to ``last``."""

    values: NDArray[np.float32]
    first: float = 0.0
    last: float = 1.0
    options: int = 0


def of_ramp(ramp: bpy.types.ColorRamp) -> Table:
    """A colour ramp."""
    values = np.array([tuple(ramp.evaluate(step / STEPS)) for step in range(STEPS + 1)], np.float32)
    return Table(values, options=_IS_STEPPED if ramp.interpolation == "CONSTANT" else 0)


def of_curves(mapping: bpy.types.CurveMapping) -> Table:
    """One to four curves; of four, the last comes before the three others."""
    mapping.update()  # its tables are made when they are first drawn
    curves = list(mapping.curves)
    first = min(curve.points[0].location[0] for curve in curves)
    last = max(curve.points[-1].location[0] for curve in curves)
    if not last > first:
        last = first + 1.0
    values = np.ones((STEPS + 1, 4), np.float32)
    for step in range(STEPS + 1):
        x = first + step / STEPS * (last - first)
        before = mapping.evaluate(curves[-1], x) if len(curves) == _OF_COLOURS else x
        for channel in range(3):
            values[step, channel] = mapping.evaluate(curves[channel % len(curves)], before)
    return Table(values, first, last, _GOES_ON if mapping.extend == "EXTRAPOLATED" else 0)


@cache
def of_blackbody() -> Table:
    """Over degrees Kelvin; colours outside the gamut are cut off, as nodes do."""
    kelvin = np.linspace(COLDEST_K, HOTTEST_K, _BLACKBODY_STEPS + 1)
    return Table(_opaque(np.array([blackbody(one) for one in kelvin])), COLDEST_K, HOTTEST_K)


def of_wavelengths() -> Table:
    """Over nanometres; beyond it goes on for as long as Cycles reads it."""
    return Table(_opaque(spectral_colours()), FIRST_NM, LAST_NM, _GOES_ON)


def colour_at(program: Program, table: Table, place: Value, *, alpha: bool = False) -> Value:
    """The table's colour at a number, or its alpha."""
    return program.operation(Code.CURVE, place, selector=_ALPHA if alpha else _COLOUR, **_fields(program, table))


def curved(program: Program, table: Table, value: Value, share: Value) -> Value:
    """Each channel by its own curve; ``share`` of the result with the rest of what was."""
    return program.operation(Code.CURVE, value, share, selector=_EACH, **_fields(program, table))


def _fields(program: Program, table: Table) -> dict[str, object]:
    return {
        "option": table.options,
        "table": program.table(table.values),
        "value": (table.first, table.last, 0.0),
    }


def _opaque(colours: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.column_stack([colours, np.ones(len(colours))]).astype(np.float32)
