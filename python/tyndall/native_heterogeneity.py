# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air, as the native side takes it; its noise and what is painted are kept from frame to frame."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from . import _native
from .heterogeneity import WEIGHTINGS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .heterogeneity import Heterogeneity, PaintedAir
    from .scene_description import FloatArray


class KeptAir:
    """The native noise volumes, and the last painted arrays, by key."""

    def __init__(self) -> None:
        self._noise = _native.AirNoiseCache()
        self._painted: tuple[str, _native.PaintedAir] | None = None

    def build(
        self, heterogeneity: Heterogeneity | None, origin_in_world: NDArray[np.float64], reports: list[str]
    ) -> _native.Heterogeneity | None:
        """Of a scene whose space begins at ``origin_in_world``, (3,). Raises ``InvalidInput``, which names the number.

        Painted air that cannot be used is left out with a report that names why; the rest stays.
        """
        if heterogeneity is None:
            return None
        if heterogeneity.weighting not in WEIGHTINGS:
            raise _native.InvalidInput(
                f'weighting of heterogeneity is "{heterogeneity.weighting}", not one of {", ".join(WEIGHTINGS)}'
            )
        unit_from_scene = np.identity(4, dtype=np.float32)
        painted = None
        if heterogeneity.painted is not None:
            try:
                unit_from_scene = _unit_from_scene(heterogeneity.painted, origin_in_world)
                painted = self._native_painted(heterogeneity.painted)
            except (_native.InvalidInput, TypeError) as error:
                reports.append(f"Painted air is left out: {error}")
        x, y, z = (float(moved - origin) for moved, origin in zip(heterogeneity.moved_m, origin_in_world, strict=True))
        return _native.Heterogeneity(
            **asdict(heterogeneity.noise),
            moved_m=(x, y, z),
            amount=heterogeneity.amount,
            level=heterogeneity.level,
            intensity=heterogeneity.intensity,
            weighting=WEIGHTINGS.index(heterogeneity.weighting),
            step_count=heterogeneity.step_count,
            upsampling=heterogeneity.upsampling,
            unit_from_scene=unit_from_scene,
            painted=painted,
            kept_noise=self._noise,
        )

    def _native_painted(self, painted: PaintedAir) -> _native.PaintedAir:
        if self._painted is None or self._painted[0] != painted.key:
            built = _native.PaintedAir(
                amount=_contiguous(painted.amount),
                level=_contiguous(painted.level),
                intensity=_contiguous(painted.intensity),
            )
            self._painted = (painted.key, built)
        return self._painted[1]


def _contiguous(values: FloatArray | None) -> FloatArray | None:
    return None if values is None else np.ascontiguousarray(values, np.float32)


def _unit_from_scene(painted: PaintedAir, origin_in_world: NDArray[np.float64]) -> NDArray[np.float32]:
    scene_from_unit = np.array(painted.world_from_unit, dtype=np.float64)
    if scene_from_unit.shape != (4, 4) or not np.isfinite(scene_from_unit).all():
        raise _native.InvalidInput("its matrix is not finite, or not 4 x 4")
    scene_from_unit[:3, 3] -= origin_in_world
    # The determinant relative to the lengths of the box's sides: 0 where they span no volume.
    volume = float(np.prod(np.linalg.norm(scene_from_unit[:3, :3], axis=0)))
    if not abs(np.linalg.det(scene_from_unit[:3, :3])) > 1e-6 * volume:
        raise _native.InvalidInput("its box is flat: the matrix is singular")
    return np.linalg.inv(scene_from_unit).astype(np.float32, order="C")
