# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean of films of one frame that each have a part of its samples, as if one render had taken them all.

Based on: Haeberli and Akeley, The Accumulation Buffer, SIGGRAPH 1990.
Differs:  planes that are no light have a rule each: places and indices are one film's, as one sample has them
          elsewhere; shares of light are weighed by that light; mattes are merged rank by rank.
Bound:    one addition per value; mattes take a comparison per pair of ranks.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]
Planes = dict[str, FloatArray]

#: Of which there is no mean.
OF_ONE_FILM = frozenset({"Depth", "Position", "IndexOB", "IndexMA"})
#: What these are shares of; the film has it where it is asked for as a pass.
LIGHT_OF_SHARES = {"Shadow": "Unshadowed"}
_MATTES = ("CryptoObject", "CryptoMaterial", "CryptoAsset")


def passes_of_parts(passes: frozenset[str]) -> frozenset[str]:
    """What films need so that their mean has these passes."""
    return passes | {LIGHT_OF_SHARES[name] for name in passes if name in LIGHT_OF_SHARES}


class FilmMean:
    """Films are added one by one; the mean may be asked for at any time."""

    def __init__(self) -> None:
        self._sums: Planes = {}
        self._of_one_film: Planes = {}
        self._mattes: dict[str, _Mattes] = {}
        self._weight = 0.0

    @property
    def is_empty(self) -> bool:
        """Whether there is no film yet."""
        return self._weight == 0.0

    def add(self, planes: Mapping[str, FloatArray], weight: float, *, is_middle: bool) -> None:
        """``is_middle``: places and indices are this film's; those of the first one until then."""
        if is_middle or self.is_empty:
            self._of_one_film = {name: plane for name, plane in planes.items() if name in OF_ONE_FILM}
        for kind in _MATTES:
            if (ranked := _ranked(planes, kind)) is not None:
                self._mattes.setdefault(kind, _Mattes()).add(ranked, weight)
        for name, plane in planes.items():
            if name in OF_ONE_FILM or name.startswith(_MATTES):
                continue
            light = planes.get(LIGHT_OF_SHARES.get(name, ""))
            part = (plane if light is None else plane * light) * np.float32(weight)
            if name in self._sums:
                self._sums[name] += part
            else:
                self._sums[name] = part
        self._weight += weight

    def mean(self) -> Planes:
        """Raises ValueError without a film."""
        if self.is_empty:
            raise ValueError("there is no film to take a mean of")
        planes = dict(self._of_one_film)
        for name, summed in self._sums.items():
            light = self._sums.get(LIGHT_OF_SHARES.get(name, ""))
            if light is None:
                planes[name] = summed / np.float32(self._weight)
            else:
                planes[name] = np.divide(summed, light, out=np.zeros_like(summed), where=light > 0.0)
        for kind, mattes in self._mattes.items():
            planes |= mattes.planes(kind, self._weight)
        return planes

    def mean_with(self, planes: Mapping[str, FloatArray], weight: float) -> Planes:
        """As ``mean``, with one more film, which is not kept."""
        tried = FilmMean()
        tried._sums = {name: summed.copy() for name, summed in self._sums.items()}
        tried._of_one_film = self._of_one_film
        tried._mattes = {kind: mattes.copy() for kind, mattes in self._mattes.items()}
        tried._weight = self._weight
        tried.add(planes, weight, is_middle=False)
        return tried.mean()


class _Mattes:
    """Of each pixel, ids and the sums of their shares, (height, width, ranks)."""

    def __init__(self) -> None:
        self._ids: FloatArray | None = None
        self._shares: FloatArray | None = None

    def copy(self) -> _Mattes:
        result = _Mattes()
        if self._ids is not None and self._shares is not None:
            result._ids, result._shares = self._ids.copy(), self._shares.copy()
        return result

    def add(self, ranked: FloatArray, weight: float) -> None:
        """``ranked``: id and share by turns. What finds no rank counts for the last, as within a film."""
        ids, shares = ranked[..., 0::2], ranked[..., 1::2] * np.float32(weight)
        if self._ids is None or self._shares is None:
            self._ids, self._shares = ids.copy(), shares
            return
        for rank in range(ids.shape[2]):
            is_there = ids[..., rank] != 0.0
            if not is_there.any():
                continue
            ours = self._ids[is_there]
            fits = (ours == ids[..., rank][is_there][:, None]) | (ours == 0.0)
            fits[:, -1] = True
            to = (*(place for place in np.nonzero(is_there)), fits.argmax(axis=1))
            self._ids[to] = np.where(self._ids[to] == 0.0, ids[..., rank][is_there], self._ids[to])
            self._shares[to] += shares[..., rank][is_there]

    def planes(self, kind: str, weight: float) -> Planes:
        """Two ranks to a plane, the largest share first."""
        if self._ids is None or self._shares is None:
            return {}
        order = np.argsort(-self._shares, axis=2, kind="stable")
        pairs = np.stack(
            [
                np.take_along_axis(self._ids, order, axis=2),
                np.take_along_axis(self._shares, order, axis=2) / np.float32(weight),
            ],
            axis=3,
        )
        height, width, ranks, _ = pairs.shape
        values = pairs.reshape(height, width, 2 * ranks)
        return {f"{kind}{index:02d}": values[..., 4 * index : 4 * index + 4].copy() for index in range(ranks // 2)}


def _ranked(planes: Mapping[str, FloatArray], kind: str) -> FloatArray | None:
    names: Iterable[str] = sorted(name for name in planes if name.startswith(kind))
    found = [planes[name] for name in names]
    return np.concatenate(found, axis=2) if found else None
