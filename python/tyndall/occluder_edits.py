# SPDX-License-Identifier: GPL-3.0-or-later
"""Occluder edits of a light, as the native side takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from . import _native

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .scene_description import HoleNoise, Light, LightMask, OccluderEdit


def build_occluder_edits(light: Light, object_names: Sequence[str], reports: list[str]) -> list[_native.OccluderEdit]:
    """Those that can be used; one that cannot is left out with a report, and the light keeps the others."""
    edits = []
    for edit in light.occluder_edits:
        try:
            edits.append(_build_edit(edit, object_names))
        except _native.InvalidInput as error:
            reports.append(f'Light "{light.name}": its edit "{edit.name}" is left out: {error}')
    return edits


def _build_edit(edit: OccluderEdit, object_names: Sequence[str]) -> _native.OccluderEdit:
    meant = None
    if edit.objects is not None:
        names = frozenset(edit.objects)
        meant = np.array([index for index, name in enumerate(object_names) if name in names], dtype=np.uint32)
    return _native.OccluderEdit(
        name=edit.name,
        kind=int(edit.kind),
        shape=int(edit.shape),
        size_m=edit.size_m,
        distance_m=edit.distance_m,
        noise=_build_noise(edit.noise),
        affects_surfaces=edit.affects_surfaces,
        objects=meant,
        mask=None if edit.mask is None else _build_mask(edit.mask),
    )


def _build_noise(noise: HoleNoise) -> _native.HoleNoise:
    return _native.HoleNoise(
        scale_m=noise.scale_m,
        octaves=noise.octaves,
        persistence=noise.persistence,
        probability=noise.probability,
        sway=noise.sway,
        turn_rad=noise.turn_rad,
        seed=noise.seed,
    )


def _build_mask(mask: LightMask) -> _native.LightMask:
    values = np.nan_to_num(mask.values, nan=0.0, posinf=1.0, neginf=0.0)
    return _native.LightMask(name=mask.name, values=np.ascontiguousarray(values, np.float32), size_m=mask.size_m)
