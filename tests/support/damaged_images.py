# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of images that are cut off, of another type than their ending says, of absurd shapes, or there twice."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from support.damaged_nodes import on_soup
from support.damages import Random, Scene, damage, textured


def saved(name: str, size: tuple[int, int], random: Random, file_format: str = "PNG") -> Path:
    """A file of random bytes as pixels, in Blender's folder for this run."""
    width, height = size
    image = bpy.data.images.new("to save", width, height)
    image.pixels.foreach_set(random.random(width * height * 4).astype(np.float32))
    path = Path(bpy.app.tempdir) / name
    image.filepath_raw, image.file_format = str(path), file_format
    image.save()
    bpy.data.images.remove(image)
    return path


def of_file(path: Path, name: str) -> bpy.types.Image:
    """As a file has it: nothing was read of it yet."""
    image = bpy.data.images.new(name, 8, 8)
    image.source, image.filepath = "FILE", str(path)
    return image


def worn(image: bpy.types.Image, random: Random, name: str) -> None:
    on_soup(textured(image), random, name)


@damage("files of images that are cut off, or empty", ("cut.png", "empty.png", "empty.jpg", "head.jpg"))
def _(_scene: Scene, random: Random) -> None:
    whole = saved("whole.png", (64, 64), random)
    folder, contents = whole.parent, whole.read_bytes()
    photograph = saved("whole.jpg", (64, 64), random, "JPEG").read_bytes()
    parts = {
        "cut.png": contents[: len(contents) // 2], "empty.png": b"", "empty.jpg": b"", "head.jpg": photograph[:40],
    }  # fmt: skip
    for name, part in parts.items():
        (folder / name).write_bytes(part)
        worn(of_file(folder / name, name), random, f"Cut {name}")


@damage("a photograph whose last rows are cut off", None)
def _(_scene: Scene, random: Random) -> None:
    path = saved("short.jpg", (64, 64), random, "JPEG")
    contents = path.read_bytes()
    path.write_bytes(contents[: int(random.integers(len(contents) // 2, len(contents)))])
    worn(of_file(path, "short.jpg"), random, "Short")


@damage("files of images of another type than their ending says", None)
def _(_scene: Scene, random: Random) -> None:
    for index, (file_format, ending) in enumerate(
        (("PNG", "jpg"), ("JPEG", "png"), ("PNG", "exr"), ("TARGA", "png"), ("BMP", "tif"), ("PNG", ""))
    ):
        path = saved(f"other {index}.{ending}", (16, 8), random, file_format)
        worn(of_file(path, f"Other {index}"), random, f"Other {index}")


@damage("images of one row, of one column, and of one pixel", None)
def _(_scene: Scene, random: Random) -> None:
    for index, size in enumerate(((1, 65536), (65536, 1), (1, 1), (3, 16384))):
        image = of_file(saved(f"long {index}.png", size, random), f"Long {index}")
        worn(image, random, f"Long {index}")
        if index % 2:
            image.pack()


@damage("one file, packed and beside the scene, whole and damaged", ("Twin damaged",))
def _(_scene: Scene, random: Random) -> None:
    path = saved("twin.png", (16, 16), random)
    packed = of_file(path, "Twin packed")
    packed.pack()
    worn(packed, random, "Twin packed")
    saved("twin.png", (8, 4), random)
    again = of_file(path, "Twin again")
    again.pack()
    worn(again, random, "Twin again")
    path.write_bytes(path.read_bytes()[:60])
    worn(of_file(path, "Twin damaged"), random, "Twin damaged")


@damage("packed images of which nothing, or something else, is packed", ("Packed empty", "Packed text"))
def _(_scene: Scene, random: Random) -> None:
    for name, data in (("Packed empty", b""), ("Packed text", b"no image " * 9)):
        image = bpy.data.images.new(name, 8, 8)
        image.source, image.filepath = "FILE", "//no file.png"
        image.pack(data=data, data_len=len(data))
        worn(image, random, name)
