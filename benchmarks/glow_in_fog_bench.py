# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise of fog that meshes light at equal time: ours and Cycles' with its light tree.

scripts/python benchmarks/glow_in_fog_bench.py --context FILE --output FILE. What the figures are: glow_noise.py.
"""

from __future__ import annotations

import sys
from pathlib import Path

from glow_noise import rows_of

import tyndall.blender
from report import Row, argument_parser, write_report

sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.glow_scenes import SCENES, build

SIZE_PX = 96, 54
SAMPLES = {"cycles": 128, "tyndall": 16}


def run() -> list[Row]:
    """Measure both engines in all scenes."""
    rows = []
    for name in SCENES:
        scene = build(name)
        scene.render.resolution_x, scene.render.resolution_y = SIZE_PX
        rows += rows_of(name, scene, SAMPLES)
    return rows


if __name__ == "__main__":
    arguments = argument_parser(__doc__).parse_args()
    tyndall.blender.enable()
    write_report(run(), arguments)
