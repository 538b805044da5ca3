# SPDX-License-Identifier: GPL-3.0-or-later
"""4 GB of textures within a budget of memory: 64 images of 4096 x 4096 on as many squares, each with its own noise.

The images are uncompressed TIFFs in a temporary folder, and so is the .blend that shows them; each row is a render in
a process of its own, which opens that file. Nearly every pixel looks at a tile of its own: the worst case.

Rows: IMAGES x SIDE/budget:MIB (0: as many as half of the machine's memory holds): seconds and processor seconds of the
render, reading the images included; peak_mib, how much more memory the process took at its peak than with the file
just opened; blender_mib, what it had then; what the statistics say of tiles. A smaller set is rendered with and
without a budget, and is_equal says whether the two pictures are, bit for bit. With scripts/python:

  benchmarks/texture_budget_bench.py --context build/logs/bench-context.json --output texture_budget.json
"""

from __future__ import annotations

import argparse
import json
import os
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray
from process_memory import forget_most_memory, memory_bytes, most_memory_bytes

import tyndall.blender
from report import Row, argument_parser, row, write_report
from tyndall import _image_io

SIZE_PX = 512
LARGE, SMALL = (64, 4096), (9, 1024)  #: Images, and pixels of a side.
BUDGET_MIB, SMALL_BUDGET_MIB = 384, 2
MIB = 1024.0 * 1024.0


def _write_tiff(path: Path, side: int, seed: int) -> None:
    """RGBA bytes, uncompressed, opaque; a band of rows at a time."""
    random = np.random.default_rng(seed)
    band = np.full((64, side, 4), 255, np.uint8)
    entries = [
        (256, 4, 1, side),  # width
        (257, 4, 1, side),  # height
        (258, 3, 4, 8 + 2 + 12 * 11 + 4),  # bits, at the end of this table
        (259, 3, 1, 1),  # no compression
        (262, 3, 1, 2),  # RGB
        (273, 4, 1, 256),  # where the pixels begin
        (277, 3, 1, 4),  # channels
        (278, 4, 1, side),  # rows
        (279, 4, 1, 4 * side * side),
        (284, 3, 1, 1),
        (338, 3, 1, 2),  # alpha that nothing is multiplied with
    ]
    header = struct.pack("<2sHI", b"II", 42, 8) + struct.pack("<H", len(entries))
    header += b"".join(struct.pack("<HHII", *entry) for entry in entries) + struct.pack("<I", 0)
    header += struct.pack("<4H", 8, 8, 8, 8)
    with path.open("wb") as file:
        file.write(header.ljust(256, b"\0"))
        for _ in range(side // len(band)):
            band[..., :3] = random.integers(0, 256, (*band.shape[:2], 3), np.uint8)
            file.write(band.tobytes())


def _write_scene(folder: Path, count: int, side: int) -> Path:
    """Squares that glow in the colours of the images, side by side before an orthographic camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x = scene.render.resolution_y = SIZE_PX
    scene.tyndall.pixel_samples = 1
    columns = int(np.ceil(np.sqrt(count)))
    for index in range(count):
        path = folder / f"{index:03}.tif"
        _write_tiff(path, side, index)
        material = bpy.data.materials.new(path.stem)
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        texture, glow = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
        texture.image = bpy.data.images.load(str(path))
        tree.links.new(texture.outputs["Color"], glow.inputs["Color"])
        tree.links.new(glow.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
        x, y = index % columns, index // columns
        mesh = bpy.data.meshes.new(path.stem)
        mesh.from_pydata([(x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0)], [], [(0, 1, 2, 3)])
        mesh.uv_layers.new().data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
        mesh.materials.append(material)
        scene.collection.objects.link(bpy.data.objects.new(path.stem, mesh))
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", columns
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (columns / 2, columns / 2, 1)
    scene.collection.objects.link(scene.camera)
    blend = folder / "textures.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    return blend


def _render(blend: Path, budget_mib: int, picture: Path) -> dict[str, float]:
    """What one render takes, in this process, which has not rendered before."""
    from tyndall.blender.addon import last_render  # noqa: PLC0415  there once it is enabled

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    scene.tyndall.texture_budget_mib = budget_mib
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR", "32", "NONE"
    scene.render.filepath = str(picture)
    forget_most_memory()
    before, began, began_cpu = memory_bytes(), time.perf_counter(), time.process_time()
    bpy.ops.render.render(write_still=True)
    found = {
        "seconds": time.perf_counter() - began,
        "cpu_seconds": time.process_time() - began_cpu,
        "peak_mib": (most_memory_bytes() - before) / MIB,
        "blender_mib": before / MIB,
    }
    counts = (last_render.statistics_of(scene.name) or {})["counts"]
    return found | {name: count for name, count in counts.items() if "tiles" in name or "images in" in name}


def _rendered(blend: Path, budget_mib: int, picture: Path) -> dict[str, float]:
    """The same, in a process of its own."""
    command = [sys.executable, __file__, "--render", str(blend), str(budget_mib), str(picture)]
    done = subprocess.run(command, env=os.environ, check=True, capture_output=True, text=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def _pixels(picture: Path) -> NDArray[np.float32]:
    pixels: NDArray[np.float32] = _image_io.read(picture)[0]
    return pixels


def _row(count: int, side: int, budget_mib: int, found: dict[str, float], **more: bool) -> Row:
    seconds = found.pop("seconds")
    return row(f"{count} x {side}/budget:{budget_mib}", seconds, **found, **more)


def main() -> None:
    """Write the rows; or, in a process that was asked for a render, print what it took."""
    if sys.argv[1:2] == ["--render"]:
        blend, budget, picture = sys.argv[2:]
        tyndall.blender.enable()
        print(json.dumps(_render(Path(blend), int(budget), Path(picture))))
        return
    parser = argument_parser(__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    arguments = parser.parse_args()
    tyndall.blender.enable()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        blend = _write_scene(folder, *SMALL)
        pictures = [folder / "whole.exr", folder / "tiles.exr"]
        rows.append(_row(*SMALL, 0, _rendered(blend, 0, pictures[0])))
        found = _rendered(blend, SMALL_BUDGET_MIB, pictures[1])
        is_equal = np.array_equal(*(_pixels(picture) for picture in pictures))
        rows.append(_row(*SMALL, SMALL_BUDGET_MIB, found, is_equal=is_equal))
        blend = _write_scene(folder, *LARGE)
        rows.append(_row(*LARGE, BUDGET_MIB, _rendered(blend, BUDGET_MIB, folder / "large.exr")))
    write_report(rows, arguments)


if __name__ == "__main__":
    main()
