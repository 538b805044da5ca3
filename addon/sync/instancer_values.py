# SPDX-License-Identifier: GPL-3.0-or-later
"""What instancers give to their instances, where materials ask: attributes, properties, UV and Generated coordinates.

Based on: Blender's BKE_object_dupli_find_rgba_attribute, which Cycles asks; intern/cycles/blender/object.cpp.
Bound:    16 bytes for each value and instance of an object with such a material, and some 10 us; nothing for others.
Limits:   attributes of geometry nodes' instances are told from Blender 4.5 on; see instance_attributes.py.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .asked_properties import ATTRIBUTE, GENERATED, MISSING, UV, first_numbers, numbers_of
from .asking_materials import AskingMaterials
from .domains import MID_GREY
from .instance_attributes import AttributeReader

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from bpy.types import Depsgraph, DepsgraphObjectInstance, Material, Node, Object, ParticleSettings, bpy_struct
    from numpy.typing import NDArray

    from .asked_properties import Asked, Rgba
    from .instances import Placement
    from .reports import Reports

MOST_ASKED = 256  #: Values of a scene: programs tell them by a byte.

_UNKNOWN: Rgba = (*MID_GREY, 1.0)


class Row(NamedTuple):
    """Of an instance; of what is none, without a parent."""

    parent: Object | None = None
    particles: ParticleSettings | None = None
    path: tuple[int, ...] = ()  #: As Blender has it, the innermost first.
    uv: tuple[float, ...] = (0.0, 0.0)
    generated: tuple[float, ...] = (0.0, 0.0, 0.0)


class InstancerReader:
    """Of one depsgraph."""

    def __init__(self, depsgraph: Depsgraph, reports: Reports) -> None:
        self._materials = AskingMaterials(depsgraph, _asked_by_node)
        self._attributes = AttributeReader(depsgraph)
        self._reports = reports
        self._asks_attributes = self._asks_coordinates = False
        self.numbers: dict[Asked, int] = {}  #: Of all that is asked for, in a row.

    def is_asked_for(self, materials: Iterable[Material | None]) -> bool:
        """By what is drawn of them."""
        asked = self._materials.asked(materials)
        for one in sorted(asked):
            if len(self.numbers) < MOST_ASKED:
                self.numbers.setdefault(one, len(self.numbers))
        kinds = {kind for kind, _ in self.numbers}
        self._asks_attributes, self._asks_coordinates = ATTRIBUTE in kinds, not kinds.isdisjoint({UV, GENERATED})
        return bool(asked)

    def row_of(self, instance: DepsgraphObjectInstance) -> Row:
        """For ``values``: while the depsgraph goes through its instances."""
        row = Row()
        if not instance.is_instance:
            return row
        if self._asks_coordinates:
            row = row._replace(uv=tuple(instance.uv), generated=tuple(0.5 * along - 0.5 for along in instance.orco))
        if self._asks_attributes:
            system = instance.particle_system
            particles = None if system is None else system.settings
            row = row._replace(parent=instance.parent, particles=particles, path=tuple(instance.persistent_id))
        return row

    def values(self, rows: list[Row], placement: Placement) -> NDArray[np.float32]:
        """(count, values, 4), see tyndall.scene_description.Instances. Call when all materials were asked.

        What its own do not ask for is 0.
        """
        values = np.zeros((len(rows), len(self.numbers), 4), np.float32)
        asked = self._materials.asked(placement.materials)
        for (kind, name), number in self.numbers.items():
            if (kind, name) not in asked:
                continue
            if kind == UV:
                values[:, number, :2] = [row.uv for row in rows]
            elif kind == GENERATED:
                values[:, number, :3] = [row.generated for row in rows]
            else:
                values[:, number] = self._attribute(name, rows, placement)
        return values

    def _attribute(self, name: str, rows: list[Row], placement: Placement) -> list[Rgba]:
        of_particles = cache(lambda settings: None if settings is None else numbers_of(settings, name))
        of_owners = cache(lambda parent: first_numbers(_owners(parent, placement), name))
        found = []
        for row in rows:
            value: Rgba | None = of_particles(row.particles)
            is_known = True
            if value is None and row.parent is not None:
                value, is_known = self._attributes.read(name, row.parent, placement.source, row.path)
            if value is None:
                value = of_owners(row.parent)
            if value is None and not is_known:
                note = f'attribute "{name}" of its instancer is not known here: mid grey'
                self._reports.add(f'Object "{placement.object_name}"', note)
                value = _UNKNOWN
            found.append(value or MISSING)
        return found


def _owners(parent: Object | None, placement: Placement) -> Iterator[bpy_struct[Any]]:
    """Of properties, the instancer first."""
    if parent is not None:
        yield parent
    yield placement.source
    if placement.data is not None:
        yield placement.data


def _asked_by_node(node: Node) -> Iterator[Asked]:
    if node.type == "ATTRIBUTE" and node.attribute_type == ATTRIBUTE:
        yield ATTRIBUTE, node.attribute_name
    elif node.type == "UVMAP" and node.from_instancer:
        yield UV, ""
    elif node.type == "TEX_COORD" and node.from_instancer:
        linked = {output.identifier for output in node.outputs if output.is_linked}
        yield from ((kind, "") for output, kind in (("UV", UV), ("Generated", GENERATED)) if output in linked)
