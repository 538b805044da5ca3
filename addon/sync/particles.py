# SPDX-License-Identifier: GPL-3.0-or-later
"""What Particle Info tells of the particles that instances are, for those whose materials ask.

Based on: blender v4.5.0, intern/cycles/blender/object.cpp, for which instances are particles, and what they tell.
Bound:    56 bytes per instance of an object with such a material, nothing for others; a system's particles are read at
          once, its instances one by one (1 us each).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .asking_materials import AskingMaterials
from .random_numbers import as_unit_floats, hashes_of_two

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from bpy.types import Depsgraph, DepsgraphObjectInstance, Material, Node, ParticleSystem
    from numpy.typing import NDArray


#: By output: where it lies among the numbers of a particle, how many they are, and what a particle calls it.
_COLUMNS = {
    "Index": (0, 1, ""),
    "Random": (1, 1, ""),
    "Age": (2, 1, "birth_time"),
    "Lifetime": (3, 1, "lifetime"),
    "Size": (4, 1, "size"),
    "Location": (5, 3, "location"),
    "Velocity": (8, 3, "velocity"),
    "Angular Velocity": (11, 3, "angular_velocity"),
}
_WIDTH = 14
NO_PARTICLE = -1


class ParticleReader:
    """Of one depsgraph, at its frame."""

    def __init__(self, depsgraph: Depsgraph) -> None:
        self._frame = depsgraph.scene_eval.frame_current_final
        self._materials = AskingMaterials(depsgraph, _asked_by_node)
        self._first_rows: dict[int, tuple[int, int]] = {}  #: By a system's address; and how many there are.
        self._systems: list[ParticleSystem] = []
        self._count = 0
        self._table: NDArray[np.float32] | None = None

    def is_asked_for(self, materials: Iterable[Material | None]) -> bool:
        """By what is drawn of them."""
        return bool(self._materials.asked(materials))

    def row_of(self, instance: DepsgraphObjectInstance) -> int:
        """A number for ``states``. Of what no particle made, and of children, which Cycles leaves out: NO_PARTICLE."""
        system = instance.particle_system
        if system is None:
            return NO_PARTICLE
        address = system.as_pointer()
        if address not in self._first_rows:
            self._first_rows[address] = self._count, len(system.particles)
            self._systems.append(system)
            self._count += len(system.particles)
        first, count = self._first_rows[address]
        index = instance.persistent_id[0]
        return first + index if index < count else NO_PARTICLE

    def states(self, rows: list[int]) -> NDArray[np.float32] | None:
        """(count, 14), see tyndall.scene_description.Instances; of NO_PARTICLE NaN. None: all are that.

        Call when all materials were asked: what none of them reads is 0, so that what it does changes nothing.
        """
        if not any(row != NO_PARTICLE for row in rows):
            return None
        if self._table is None:
            asked = self._materials.asked_so_far()
            nothing = np.full((1, _WIDTH), np.nan, np.float32)
            self._table = np.concatenate([*(_states(one, self._frame, asked) for one in self._systems), nothing])
        return self._table[rows]


def _states(system: ParticleSystem, frame: float, asked: set[str]) -> NDArray[np.float32]:
    particles = system.particles
    count = len(particles)
    states = np.zeros((count, _WIDTH), np.float32)
    for output in asked:
        column, width, name = _COLUMNS[output]
        if output == "Index":
            states[:, column] = np.arange(count)
        elif output == "Random":
            states[:, column] = as_unit_floats(hashes_of_two(count))
        else:
            numbers = np.empty(width * count, np.float32)
            particles.foreach_get(name, numbers)
            found = numbers.reshape(count, width)
            states[:, column : column + width] = np.float32(frame) - found if output == "Age" else found
    return states


def _asked_by_node(node: Node) -> Iterator[str]:
    """Which outputs of Particle Info."""
    if node.type == "PARTICLE_INFO":
        yield from (output.identifier for output in node.outputs if output.is_linked)
