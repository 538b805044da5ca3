# SPDX-License-Identifier: GPL-3.0-or-later
"""What a program gives at points in an object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import _native
from .native_materials import build_material
from .native_textures import build_texture, require_whole
from .scene_description import Code
from .surface_inputs import PointInput

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Protocol

    from numpy.typing import NDArray

    from .scene_description import Material

    FloatArray = NDArray[np.float32]

    class Values(Protocol):
        """What ``values_of`` gives."""

        def __call__(  # noqa: D102
            self,
            positions: NDArray[np.float64],
            uv_maps: Mapping[str, FloatArray],
            normals: tuple[FloatArray, FloatArray] | None = None,
            /,
        ) -> FloatArray: ...


@dataclass(frozen=True, kw_only=True, eq=False)
class PointPlace:
    """Where a program is asked, and what of its object it may read."""

    world_from_object: NDArray[np.float64]
    generated: tuple[
        NDArray[np.float64], NDArray[np.float64]
    ]  #: Centre and half sides of its texture space, in metres.
    generated_maps: tuple[str, str]  #: Names by which a program asks for coordinates in it: (x, y) and (z, 1).
    color: tuple[float, float, float, float]
    pass_index: float
    random: float

    def unit_m(self) -> float:
        """Side of a cube as large as one of the object's units."""
        return float(np.cbrt(abs(np.linalg.det(self.world_from_object[:3, :3]))))

    def read_by(self, program: Material) -> tuple[object, ...]:
        """What of it the values depend on."""
        of_instance = (self.world_from_object, self.color, self.pass_index, self.random)
        return (*self.generated, *(of_instance if asks_of_instances(program) else ()))


def asks_of_instances(program: Material) -> bool:
    """Whether it asks for more than places in the object, which are the same in all of its instances."""
    return any(step.code is Code.INPUT and step.option != PointInput.OBJECT_POSITION for step in program.program)


def values_of(program: Material, place: PointPlace, notes: list[str]) -> Values:
    """Takes positions (n, 3), metres in the object, and UV maps by name, (n, 2); gives (n, 3), nothing below 0.

    Of surfaces it takes normals, too, smooth and true ones, unit, (n, 3) each, in the object. It raises IoError of
    textures that lie in a file.
    """
    native = build_material(program, [build_texture(use, notes) for use in program.textures])
    location, size = place.generated
    per_metre = np.divide(0.5, size, out=np.zeros(3), where=size != 0.0)

    def values(
        positions: NDArray[np.float64],
        uv_maps: Mapping[str, FloatArray],
        normals: tuple[FloatArray, FloatArray] | None = None,
    ) -> FloatArray:
        uvs = np.zeros((len(positions), len(program.uv_maps), 2), np.float32)
        generated = (positions - location) * per_metre + 0.5
        for index, name in enumerate(program.uv_maps):
            if name == place.generated_maps[0]:
                uvs[:, index] = generated[:, :2]
            elif name == place.generated_maps[1]:
                uvs[:, index, 0], uvs[:, index, 1] = generated[:, 2], 1.0
            elif name in uv_maps:
                uvs[:, index] = uv_maps[name]
        found: FloatArray = _native.program_values(
            native,
            positions=positions.astype(np.float32),
            uvs=uvs,
            world_from_object=place.world_from_object.astype(np.float32).ravel().tolist(),
            color=place.color,
            pass_index=place.pass_index,
            random=place.random,
            normals=None if normals is None else normals[0],
            true_normals=None if normals is None else normals[1],
        )
        require_whole(program)
        return np.maximum(found, np.float32(0.0))

    return values
