# SPDX-License-Identifier: GPL-3.0-or-later
"""The world's volume where nodes vary it: fog in a box around all that is drawn.

Voxels have bounds, which the world has not: outside of the box the air is clear. Cycles, too, follows such fog only as
far as its steps reach, and what leads to nothing loses it there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall.program_points import PointPlace
from tyndall.scene_description import Mesh

from ..boxes import BOX_FACES, box_corners
from .field_media import Varying
from .mesh_attributes import GENERATED, made_maps

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bpy.types import Depsgraph, Object
    from numpy.typing import NDArray

    from .field_media import DensityField
    from .instances import Placement
    from .materials import MaterialReader
    from .reports import Reports

    Corners = NDArray[np.float64]

_MARGIN_SHARE = 0.05  #: Of the longest side, beyond what is drawn.
_LEAST_SIDE_M = 1.0
_STEPS = 8  #: Of a box's sides, to the power of two below the longest: what moves a little leaves box and voxels alone.


def world_fields(
    name: str,
    fields: tuple[DensityField, ...],
    drawn: list[Placement],
    depsgraph: Depsgraph,
    materials: MaterialReader,
    reports: Reports,
) -> tuple[Varying, ...]:
    """What varies in the world of this name, in a box that holds what is drawn, lamps, and the scene's camera.

    What lies farther from that camera than it sees does not count. The box is told, which keeps such a world from being
    retouched alone: one that does not vary says nothing.
    """
    if not fields:
        return ()
    lower, upper = _bounds(drawn, depsgraph.scene_eval.camera)
    width, depth, height = upper - lower
    culprit = f'World "{name}"'
    reports.add(
        culprit, f"its volume varies: it fills a box of {width:.3g} x {depth:.3g} x {height:.3g} m around what is drawn"
    )
    box = Mesh(
        key=f"the world from {lower.tolist()} to {upper.tolist()}",
        name=name,
        positions=np.array(box_corners(lower, upper), np.float32),
        triangles=np.array([(a, *pair) for a, b, c, d in BOX_FACES for pair in ((b, c), (c, d))], np.uint32),
    )
    place = PointPlace(
        world_from_object=np.eye(4),
        generated=(np.full(3, 0.5), np.full(3, 0.5)),  # generated coordinates are places, as in Cycles
        generated_maps=made_maps(GENERATED),
        color=(1.0, 1.0, 1.0, 1.0),
        pass_index=0.0,
        random=0.0,
    )
    media = [(field, materials.add_medium(field.medium)) for field in fields]
    return (Varying(culprit, name, box, media, lambda: (place,)),)


def _bounds(drawn: Iterable[Placement], camera: Object | None) -> tuple[Corners, Corners]:
    found = [_corners(placement) for placement in drawn]
    seat = np.zeros((0, 3)) if camera is None else np.array(camera.matrix_world.translation, np.float64)[np.newaxis]
    places = np.concatenate([np.zeros((0, 3)), *found])
    if camera is not None and camera.type == "CAMERA":
        places = np.clip(places, seat - camera.data.clip_end, seat + camera.data.clip_end)
    places = np.concatenate([places, seat])
    places = places[np.isfinite(places).all(axis=1)]
    if not len(places):
        places = np.zeros((1, 3))
    lower, upper = places.min(axis=0), places.max(axis=0)
    longest = max(float((upper - lower).max()), _LEAST_SIDE_M)
    margin, step = _MARGIN_SHARE * longest, 2.0 ** np.floor(np.log2(longest)) / _STEPS
    return step * np.floor((lower - margin) / step), step * np.ceil((upper + margin) / step)


def _corners(placement: Placement) -> Corners:
    """Of the boxes of all its instances; a sun's place does not matter."""
    matrices = placement.world_from_object()
    if placement.data is None:
        is_sun = getattr(placement.source.data, "type", "") == "SUN"
        return matrices[:0, :3, 3] if is_sun else matrices[:, :3, 3]
    box = np.ones((8, 4))
    box[:, :3] = placement.source.bound_box
    corners: Corners = np.einsum("nij,vj->nvi", matrices, box)[..., :3].reshape(-1, 3)
    return corners
