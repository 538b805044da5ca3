# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of a frame's images stays in memory; the rest goes to a file, of which a cache keeps the tiles in use.

While all images fit, they stay. As soon as they do not, half of the budget is the cache's: the largest images move to
the file until the others fit into the other half. Memory holds one image more than the budget at most, and the eighth
of it that images_ahead.py has read before.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import bpy

from tyndall._native import TileCache
from tyndall.native_textures import move_to_file

if TYPE_CHECKING:
    from tyndall.scene_description import Image

MIB = 1 << 20
_AUTOMATIC_SHARE = 0.5  #: Of the machine's memory.


def budget_bytes(scene: bpy.types.Scene) -> int:
    """Of a scene, as it is set or as the machine has it."""
    budget_mib: int = scene.tyndall.texture_budget_mib
    if budget_mib > 0:
        return budget_mib * MIB
    return int(_AUTOMATIC_SHARE * os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))


def folder() -> str:
    """For what memory has no room for."""
    return str(bpy.app.tempdir)


class TextureBudget:
    """Of one reader of images."""

    def __init__(self) -> None:
        self._budget_bytes = 0  # none: all images stay
        self._cache: TileCache | None = None
        self._whole_bytes = 0
        self._movable: dict[int, Image] = {}
        self._seen: dict[int, Image] = {}

    def start_frame(self, budget_bytes: int) -> bool:
        """Whether images that are kept still serve: not those in a file under another budget."""
        serves = self._cache is None or budget_bytes == self._budget_bytes
        if not serves or not any(image.tiles is not None for image in self._seen.values()):
            self._cache = None
        self._budget_bytes = budget_bytes
        self._whole_bytes = 0
        self._movable.clear()
        self._seen.clear()
        return serves

    def use(self, image: Image, *, stays_whole: bool) -> None:
        """The frame uses it. ``stays_whole``: by something that reads all of it."""
        if stays_whole:
            self._movable.pop(id(image), None)
        if id(image) in self._seen:
            return
        self._seen[id(image)] = image
        if self._budget_bytes <= 0 or image.tiles is not None:
            return
        self._whole_bytes += image.byte_count
        if not stays_whole:
            self._movable[id(image)] = image
        while self._movable and self._whole_bytes > self._most_whole_bytes():
            self._move(max(self._movable.values(), key=lambda one: one.byte_count))

    def _most_whole_bytes(self) -> int:
        return self._budget_bytes if self._cache is None else self._budget_bytes // 2

    def _move(self, image: Image) -> None:
        if self._cache is None:
            self._cache = TileCache(folder(), self._budget_bytes - self._budget_bytes // 2)
        del self._movable[id(image)]
        move_to_file(image, self._cache)
        self._whole_bytes -= image.byte_count
