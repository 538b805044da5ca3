# SPDX-License-Identifier: GPL-3.0-or-later
"""What the nodes of materials ask of each instance, found before instances are read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, TypeVar

from ..shader_nodes import nodes_within, shader_tree

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from bpy.types import Depsgraph, Material, Node

    from .instances import Placement
    from .reports import Reports

_Asked = TypeVar("_Asked")


class AskingMaterials(Generic[_Asked]):
    """Of one depsgraph: of what its view layer draws in place of materials."""

    def __init__(self, depsgraph: Depsgraph, asked_by: Callable[[Node], Iterable[_Asked]]) -> None:
        self._override: Material | None = depsgraph.view_layer_eval.material_override
        self._asked_by = asked_by
        self._by_material: dict[Material | None, set[_Asked]] = {}

    def asked(self, materials: Iterable[Material | None]) -> set[_Asked]:
        """By any of them."""
        found: set[_Asked] = set()
        for material in materials:
            found |= self._asked(self._override or material)
        return found

    def asked_so_far(self) -> set[_Asked]:
        """By all that were looked at."""
        return set().union(*self._by_material.values())

    def _asked(self, material: Material | None) -> set[_Asked]:
        if material not in self._by_material:
            tree = None if material is None else shader_tree(material)
            self._by_material[material] = {one for node in nodes_within(tree) for one in self._asked_by(node)}
        return self._by_material[material]


def note_unread(placement: Placement, reports: Reports) -> None:
    """Of what is not drawn as a mesh: its programs do not know their instance."""
    if "particles" in placement.told:
        reports.add(f'Object "{placement.object_name}"', "is no mesh: Particle Info is read as 0 on its particles")
    if "instancer_values" in placement.told:
        reports.add(f'Object "{placement.object_name}"', "is no mesh: what its instancer gives it is read as 0")
