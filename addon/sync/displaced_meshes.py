# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that their materials move, kept as long as neither changes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall import InvalidInput
from tyndall.displacement import DisplacedObject, displaced, displaced_key, displacements_of
from tyndall.fingerprints import fingerprint

from .random_numbers import as_unit_floats

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tyndall.scene_description import Displacement, Material, Mesh

    from .instances import Placement
    from .reports import Reports


class DisplacedMeshes:
    """A mesh is moved as the first object needs it that it is drawn as, and the others share it, as in Cycles."""

    def __init__(self) -> None:
        self._kept: dict[str, tuple[Mesh, list[str]]] = {}  #: With what there is to report, by key.
        self._of_frame: dict[tuple[str, bytes], Mesh] = {}

    @property
    def count(self) -> int:
        """How many are kept, those of a read that was interrupted among them."""
        return len(self._kept)

    def start_frame(self) -> None:
        self._of_frame.clear()

    def end_frame(self) -> None:
        """Forgets what this frame did not use."""
        used = {mesh.key for mesh in self._of_frame.values()}
        self._kept = {key: moved for key, moved in self._kept.items() if key in used}

    def moved(self, mesh: Mesh, materials: Sequence[Material], placement: Placement, reports: Reports) -> Mesh:
        """Itself where no material moves it."""
        displacements = displacements_of(materials)
        if not displacements:
            return mesh
        place = mesh.key, fingerprint(displacements)
        if place not in self._of_frame:
            shown = DisplacedObject(
                np.array(placement.matrices[0], np.float64),
                placement.color,
                float(placement.pass_index),
                float(as_unit_floats(placement.random_numbers[:1])[0]),
            )
            self._of_frame[place] = self._displaced(mesh, displacements, shown, reports)
        return self._of_frame[place]

    def _displaced(
        self, mesh: Mesh, displacements: Sequence[Displacement | None], shown: DisplacedObject, reports: Reports
    ) -> Mesh:
        key = displaced_key(mesh, displacements, shown)
        culprit = f'Mesh "{mesh.name}"'
        if key not in self._kept:
            lines: list[str] = []
            try:
                moved = displaced(mesh, displacements, shown, key, lines)
            except InvalidInput as error:
                reports.add(culprit, f"is not displaced: {error}")
                return mesh
            self._kept[key] = moved, lines  # at once: a viewport reads in slices, and the next one goes on from here
        moved, lines = self._kept[key]
        for line in lines:
            reports.add(culprit, line)
        return moved
