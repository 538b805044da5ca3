# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that their materials move, kept as long as neither changes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall import InvalidInput
from tyndall.displacement import DisplacedObject, displaced, displaced_key, displacements_of
from tyndall.fingerprints import fingerprint

from .mesh_attributes import VERTEX_NORMAL, made_maps
from .random_numbers import as_unit_floats

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tyndall.scene_description import Displacement, Material, Mesh

    from .instances import Placement
    from .reports import Reports


class DisplacedMeshes:
    """A mesh is moved as the first object needs it that it is drawn as, and the others share it, as in Cycles."""

    def __init__(self) -> None:
        self._kept: dict[str, Mesh] = {}
        self._of_frame: dict[tuple[str, bytes], Mesh] = {}

    def start_frame(self) -> None:
        self._of_frame.clear()

    def end_frame(self) -> None:
        """Forgets what this frame did not use."""
        self._kept = {mesh.key: mesh for mesh in self._of_frame.values()}

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
        if key in self._kept:
            return self._kept[key]
        culprit, lines = f'Mesh "{mesh.name}"', list[str]()
        try:
            moved = displaced(mesh, displacements, shown, key, made_maps(VERTEX_NORMAL), lines)
        except InvalidInput as error:
            reports.add(culprit, f"is not displaced: {error}")
            return mesh
        for line in lines:
            reports.add(culprit, line)
        return moved
