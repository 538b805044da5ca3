# SPDX-License-Identifier: GPL-3.0-or-later
"""Where programs are asked within objects: one place for each instance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.program_points import PointPlace

from .mesh_attributes import GENERATED, made_maps
from .random_numbers import as_unit_floats

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np
    from numpy.typing import NDArray

    from .instances import Placement

#: Centre and half sides of what generated coordinates go through, in metres of the object.
TextureSpace = tuple["NDArray[np.float64]", "NDArray[np.float64]"]


def places_of(placement: Placement, texture_space: TextureSpace) -> Iterator[PointPlace]:
    randoms = as_unit_floats(placement.random_numbers)
    for matrix, random in zip(placement.world_from_object(), randoms, strict=True):
        yield PointPlace(
            world_from_object=matrix,
            generated=texture_space,
            generated_maps=made_maps(GENERATED),
            color=placement.color,
            pass_index=float(placement.pass_index),
            random=float(random),
        )
