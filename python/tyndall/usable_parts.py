# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights, media and worlds whose numbers are none are left out, each with a report that names it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

from . import _native
from .scene_description import Image, LightTexture, OccluderEdit

#: Radiances and coefficients beyond it would overflow where they are summed; Blender makes 3.4e38 of infinite ones.
_LARGEST_VALUE = 1e30
_Part = TypeVar("_Part")


def built(sources: Iterable[_Part], build: Callable[[_Part], Any], kind: str, reports: list[str]) -> list[Any | None]:
    """Each source's native part, or None and a report where it cannot be used."""
    result: list[Any | None] = []
    for source in sources:
        try:
            _require_finite(source)
            result.append(build(source))
        except _native.InvalidInput as error:
            reports.append(f'{kind} "{getattr(source, "name", "")}" is left out: {error}')
            result.append(None)
    return result


def usable(sources: Iterable[_Part], build: Callable[[_Part], Any], kind: str, reports: list[str]) -> list[Any]:
    """Those that can be used."""
    return [part for part in built(sources, build, kind, reports) if part is not None]


def _require_finite(part: object, path: str = "") -> None:
    """Raise InvalidInput that names the first field of a light, medium or world that is not finite."""
    if isinstance(part, Image | OccluderEdit | LightTexture):  # a broken one does not cost its light
        return
    if is_dataclass(part):
        for entry in fields(part):
            _require_finite(getattr(part, entry.name), f"{path}{entry.name}")
    elif isinstance(part, tuple) and part and is_dataclass(part[0]):
        for index, item in enumerate(part):
            _require_finite(item, f"{path}[{index}].")
    elif isinstance(part, float | tuple | np.ndarray) and not (np.abs(part) < _LARGEST_VALUE).all():
        raise _native.InvalidInput(f"{path} is not finite")
