# SPDX-License-Identifier: GPL-3.0-or-later
"""What Particle Info tells of the particles that instances are, for those whose materials ask.

Based on: blender v4.5.0, intern/cycles/blender/object.cpp, for which instances are particles, and what they tell.
Bound:    56 bytes per instance of an object with such a material, nothing for others; a system's particles are read at
          once, its instances one by one (1 us each).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..shader_nodes import nodes_within, shader_tree
from .random_numbers import as_unit_floats, hashes_of_two

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bpy.types import Depsgraph, DepsgraphObjectInstance, Material, ParticleSystem
    from numpy.typing import NDArray

    from .instances import Placement
    from .reports import Reports

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
        self._override: Material | None = depsgraph.view_layer_eval.material_override
        self._asked: dict[Material | None, set[str]] = {}
        self._first_rows: dict[int, tuple[int, int]] = {}  #: By a system's address; and how many there are.
        self._systems: list[ParticleSystem] = []
        self._count = 0
        self._table: NDArray[np.float32] | None = None

    def is_asked_for(self, materials: Iterable[Material | None]) -> bool:
        """By what is drawn of them."""
        asked = [self._asked_by(self._override or material) for material in materials]
        return any(asked)

    def _asked_by(self, material: Material | None) -> set[str]:
        if material not in self._asked:
            tree = None if material is None else shader_tree(material)
            self._asked[material] = {
                output.identifier
                for node in nodes_within(tree)
                if node.type == "PARTICLE_INFO"
                for output in node.outputs
                if output.is_linked
            }
        return self._asked[material]

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
            asked = set().union(*self._asked.values())
            nothing = np.full((1, _WIDTH), np.nan, np.float32)
            self._table = np.concatenate([*(_states(one, self._frame, asked) for one in self._systems), nothing])
        return self._table[rows]


def note_unread(placement: Placement, reports: Reports) -> None:
    """Of what is not drawn as a mesh: its programs do not know their instance."""
    if "particles" in placement.told:
        reports.add(f'Object "{placement.object_name}"', "is no mesh: Particle Info is read as 0 on its particles")


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
