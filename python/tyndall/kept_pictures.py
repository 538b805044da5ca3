# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that are kept without their transfer functions: where only layers of those change, no ray is needed."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace
from typing import TYPE_CHECKING

from .fingerprints import fingerprint

if TYPE_CHECKING:
    from . import _native
    from .render_config import RenderConfig
    from .scene_description import Camera


class UnstyledPictures:
    """The last few of one scene, by everything that they depend on."""

    def __init__(self, capacity: int) -> None:
        self.capacity = capacity
        self._pictures: OrderedDict[bytes, _native.UnstyledFilm] = OrderedDict()

    def clear(self) -> None:
        """The scene has changed."""
        self._pictures.clear()

    def find(self, camera: Camera, config: RenderConfig) -> _native.UnstyledFilm | None:
        """The picture of this view, if the functions have the axes and the followed points that it had."""
        return self._pictures.get(_key(camera, config)) if self._pictures else None

    def keep(self, camera: Camera, config: RenderConfig, picture: _native.UnstyledFilm) -> None:
        """Keep it, and forget the oldest beyond the capacity."""
        self._pictures[_key(camera, config)] = picture
        while len(self._pictures) > self.capacity:
            self._pictures.popitem(last=False)


def _key(camera: Camera, config: RenderConfig) -> bytes:
    functions = tuple(weighted.function for weighted in config.transfer_functions)
    axes = tuple((function.x, function.y) for function in functions)
    points = tuple(
        constraint.point
        for function in functions
        for layer in function.layers
        for constraint in layer.constraints
        if constraint.point is not None
    )
    passes = tuple(sorted(config.passes))
    return fingerprint((camera, replace(config, transfer_functions=(), passes=frozenset()), passes, axes, points))
