# SPDX-License-Identifier: GPL-3.0-or-later
"""How far single pixels are off their formulas, by scale, distance, optical depth and size of lights.

scripts/python benchmarks/numerics_bench.py --context FILE --output FILE [--docs FOLDER]. All rendering is in 32 bits,
the formulas in 64. With --docs, writes numerics.md. The scenes are those of tests/python/test_numeric_stress.py.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from report import Row, argument_parser, row, write_page, write_report

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.numeric_stress import (
    Error,
    Place,
    area_lamp_error,
    grazing_sun_error,
    lamp_in_fog_error,
    shaft_error,
    sphere_lamp_error,
    wide_sun_error,
)

SCALES_M = (1e-4, 1e-2, 1.0, 1e2, 1e4, 1e7)
DISTANCES = (0.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6)
DEPTHS = (1e-6, 1e-3, 1e-1, 1.0, 4.0, 10.0, 40.0)
NEAREST = (1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
SIZES = (0.0, 1e-6, 1e-3, 0.1, 0.5, 0.9, 0.99)
WIDTHS = (1e-6, 1e-3, 0.1, 1.0, 10.0, 100.0)
ANGLES_RAD = (0.0, 1e-6, 1e-3, 0.1, 1.0, 1.5)


@dataclass(frozen=True)
class Curve:
    """One line of a table."""

    name: str
    measure: Callable[[float], Error]


@dataclass(frozen=True)
class Table:
    """Curves over the same values."""

    title: str
    values: Sequence[float]
    curves: Sequence[Curve]
    guard: str  #: What keeps the errors so small, and what it leaves.


def shafts_by(place: Callable[[float], Place], depth: Callable[[float], float] = lambda _: 1.0) -> list[Curve]:
    """Of each method."""
    return [
        Curve(f"shafts, {method}", lambda value, method=method: shaft_error(method, place(value), depth(value)))
        for method in ("EXACT", "EPIPOLAR", "SHADOW_MAP")
    ]


def surfaces_by(place: Callable[[float], Place]) -> list[Curve]:
    """A plane under low suns, and under a lamp with a size."""
    return [
        *(
            Curve(f"plane under a sun at {low:g} degrees", lambda value, low=low: grazing_sun_error(place(value), low))
            for low in (60.0, 5.0, 0.5)
        ),
        Curve("plane under a sphere", lambda value: sphere_lamp_error(place(value), 0.1)),
        Curve("plane under a square", lambda value: area_lamp_error(place(value), 0.1)),
    ]


TABLES = (
    Table(
        "Scale, metres",
        SCALES_M,
        [*shafts_by(Place), *surfaces_by(Place), Curve("fog past a lamp", lambda s: lamp_in_fog_error(Place(s), 0.1))],
        "No length stands in the code but those of the scene; planes, cuts and light columns are in 64 bits, and rays "
        "leave surfaces by the bound of their rounding (`spawn_offset.hpp`).",
    ),
    Table(
        "Distance of the scene from the origin, in its own sizes, the camera beside it",
        DISTANCES,
        [*shafts_by(lambda d: Place(from_origin=d)), *surfaces_by(lambda d: Place(from_origin=d))],
        "In 64 bits all is moved to the middle of its objects before it becomes 32.",
    ),
    Table(
        "Distance of the camera from the scene, in the scene's sizes",
        DISTANCES,
        [*shafts_by(lambda d: Place(seen_from=d)), *surfaces_by(lambda d: Place(seen_from=d))],
        "View rays are known to 1e-7 of the way to the camera: at 1e6 sizes a tenth of the scene. This is the worst of "
        "all cases, and nothing guards it but a camera that stands nearer.",
    ),
    Table(
        "Optical depth of the fog",
        DEPTHS,
        shafts_by(lambda _: Place(), lambda depth: depth),
        "Integrals by expm1, from the end of a piece that loses less; a piece whose ends were rounded keeps its depths "
        "there (`scatter_pieces.cpp`): where light ran along a face of the fog, pixels were 1e9 times too bright.",
    ),
    Table(
        "How near a view ray of length 10 passes a lamp in fog",
        NEAREST,
        [Curve("fog past a lamp", lambda nearest: lamp_in_fog_error(Place(), nearest))],
        "Substitution by the angle at the lamp. A lamp nearer than 1e-6 of its distance lies on the ray: it is moved "
        "off it by so much (`plane_cut.cpp`), which is the bound at the right.",
    ),
    Table(
        "Radius of a sphere over a plane, of its distance",
        SIZES,
        [Curve("plane under a sphere", lambda size: sphere_lamp_error(Place(), size))],
        "The cone of directions in closed form, without a difference of cosines; noise of 65,536 samples included.",
    ),
    Table(
        "Width of a square over a plane, of its distance",
        WIDTHS,
        [Curve("plane under a square", lambda width: area_lamp_error(Place(), width))],
        "Its solid angle is sampled; so is the noise.",
    ),
    Table(
        "Angular radius of a sun, radians",
        ANGLES_RAD,
        [Curve("plane under a sun", lambda angle: wide_sun_error(Place(), angle))],
        "As a sphere's cone.",
    ),
)

HEADER = """# Numbers
The worst pixel's error, relative to a formula in 64 bits, of pictures rendered in 32; `scripts/bench.sh numerics_bench`
makes this page anew. All scenes are turned by an odd rotation. Fog is a box with a plate's shadow in it, under a sun
along its walls.
"""


def main() -> None:
    """Measure all tables."""
    arguments = argument_parser(__doc__, has_page=True).parse_args()
    rows: list[Row] = []
    text = HEADER
    for table in TABLES:
        text += f"\n## {table.title}\n| | {' | '.join(f'{value:g}' for value in table.values)} |\n"
        text += "|---" * (len(table.values) + 1) + "|\n"
        for curve in table.curves:
            start = time.process_time()
            worst = [curve.measure(value).worst for value in table.values]
            name = f"{table.title}: {curve.name}"
            errors = {f"at_{value:g}": error for value, error in zip(table.values, worst, strict=True)}
            rows.append(row(name, time.process_time() - start, **errors))
            print(rows[-1], flush=True)
            text += f"| {curve.name} | {' | '.join(f'{error:.0e}' for error in worst)} |\n"
        text += f"\n{table.guard}\n"
    write_report(rows, arguments)
    write_page("numerics.md", text, arguments)


if __name__ == "__main__":
    main()
