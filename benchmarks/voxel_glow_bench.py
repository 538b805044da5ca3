# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise of a street that its voxels light at equal time: ours, of voxels, and Cycles', of a mesh of their boxes.

scripts/python benchmarks/voxel_glow_bench.py --context FILE --output FILE. What the figures are: glow_noise.py.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
from glow_noise import rows_of

import tyndall.blender
from report import Row, argument_parser, write_report

sys.path.append(str(Path(__file__).parents[1] / "examples"))
from guide_street import show_street

SIZE_PX = 160, 90
SAMPLES = {"cycles": 64, "tyndall": 16}


def run() -> list[Row]:
    """Measure both engines with fog and without."""
    rows = []
    for name in ("street", "street in fog"):
        show_street()
        scene = bpy.context.scene
        scene.render.resolution_x, scene.render.resolution_y = SIZE_PX
        scene.tyndall.noise_threshold, scene.tyndall.indirect.has_bounce = 0.0, False
        if name == "street":
            bpy.data.objects.remove(bpy.data.objects["Fog"])
        voxels = bpy.data.objects["Street"]
        bpy.context.view_layer.objects.active = voxels
        bpy.ops.tyndall.voxels_to_mesh()
        boxes = bpy.context.object

        def show(engine: str, boxes: bpy.types.Object = boxes, voxels: bpy.types.Object = voxels) -> None:
            boxes.hide_render, voxels.hide_render = engine != "cycles", engine == "cycles"

        rows += rows_of(name, scene, SAMPLES, show)
    return rows


if __name__ == "__main__":
    arguments = argument_parser(__doc__).parse_args()
    tyndall.blender.enable()
    write_report(run(), arguments)
