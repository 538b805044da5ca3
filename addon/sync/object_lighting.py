# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups of objects and worlds, and what light linking says of objects, as Cycles reads them.

An instance whose object is in no group has that of its instancer. A name that the view layer does not list is no group.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tyndall.scene_description import LightLinks, ObjectLighting

from .light_linking import HAS_LINKING, LinkedSets, read_links

if TYPE_CHECKING:
    from bpy.types import Depsgraph, Object, ViewLayer

    from .reports import Reports

MOST_GROUPS = 255  #: That native lights tell apart.


@dataclass(frozen=True)
class LightingReader:
    """How light meets the objects of one depsgraph."""

    light_groups: tuple[str, ...]
    receivers: LinkedSets
    blockers: LinkedSets

    @classmethod
    def of_groups(cls, depsgraph: Depsgraph) -> LightingReader:
        """For objects that are not linked, at no look at all others."""
        return cls(light_groups(depsgraph.view_layer_eval), LinkedSets(), LinkedSets())

    @classmethod
    def of(cls, depsgraph: Depsgraph, reports: Reports | None = None) -> LightingReader:
        """Of the view layer that it evaluates. Looks at all that there is."""
        receivers, blockers = read_links(depsgraph, reports)
        return cls(light_groups(depsgraph.view_layer_eval), receivers, blockers)

    def concerns(self, thing: Object) -> bool:
        """Whether what the object instances may be lit, or light, otherwise than what others instance."""
        if self.light_groups and thing.lightgroup in self.light_groups:
            return True
        address = thing.as_pointer() if self.receivers.set_of or self.blockers.set_of else 0
        return address in self.receivers.set_of or address in self.blockers.set_of

    def read(self, source: Object, parent: Object | None) -> ObjectLighting | None:
        """Of an evaluated object, instanced by ``parent`` or standing for itself; None: as most objects."""
        group = ""
        if self.light_groups:
            name = source.lightgroup or (parent.lightgroup if parent is not None else "")
            group = name if name in self.light_groups else ""
        lighting = ObjectLighting(
            light_group=group,
            receiver_set=self.receivers.of_object(source, parent) if self.receivers.set_of else 0,
            blocker_set=self.blockers.of_object(source, parent) if self.blockers.set_of else 0,
            links=self._links(source),
        )
        return None if lighting == ObjectLighting() else lighting

    def _links(self, source: Object) -> LightLinks | None:
        if not HAS_LINKING or not (self.receivers.sets_of or self.blockers.sets_of):
            return None
        linking = source.light_linking
        links = LightLinks(
            receiver_sets=self.receivers.of_emitter(linking.receiver_collection),
            blocker_sets=self.blockers.of_emitter(linking.blocker_collection),
        )
        return None if links == LightLinks() else links


def light_groups(view_layer: ViewLayer) -> tuple[str, ...]:
    """Names of the view layer's groups that are kept apart."""
    return tuple(group.name for group in view_layer.lightgroups)[:MOST_GROUPS]


def report_left_out(view_layer: ViewLayer, reports: Reports) -> None:
    """What of light groups a picture will lack."""
    for group in view_layer.lightgroups[MOST_GROUPS:]:
        reports.add(f'Light group "{group.name}"', f"it stays black: {MOST_GROUPS} are the most")
