# SPDX-License-Identifier: GPL-3.0-or-later
"""Light linking and shadow linking (Blender 4.0 and later): which objects an emitter lights, and which block it.

Based on: Blender's own reading: an emitter's collection sorts objects into included and excluded ones. Where it
includes some, no others count; else all but the excluded ones do. Objects that the same collections name alike are one
set, of up to 63 beside that of all others.
Differs:  where media of several objects overlap, each is lit as its own object is; Cycles lights either both or none.
A volume is lit as its object is; it dims light wherever it lies, whatever blocks. Density grids are lit by all lights.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import bpy

from tyndall.scene_description import ALL_SETS, LightLinks, Medium

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bpy.types import Collection, Depsgraph, Object

    from .instances import Placement
    from .materials import MaterialReader
    from .reports import Reports

HAS_LINKING = bpy.app.version >= (4, 0, 0)
_MOST_SETS, _MOST_COLLECTIONS = 64, 64


@dataclass(frozen=True)
class LinkedSets:
    """Of receivers, or of blockers: what a depsgraph evaluated, by address."""

    set_of: dict[int, int] = field(default_factory=dict)  #: Of objects; those that are missing are in set 0.
    sets_of: dict[int, int] = field(default_factory=dict)  #: Of collections: a bit per set.

    def of_object(self, source: Object, parent: Object | None) -> int:
        """An instancer's set goes before that of what it instances, as in Cycles."""
        own = self.set_of.get(source.as_pointer(), 0)
        return own if parent is None else self.set_of.get(parent.as_pointer(), 0) or own

    def of_emitter(self, collection: Collection | None) -> int:
        return ALL_SETS if collection is None else self.sets_of.get(collection.as_pointer(), ALL_SETS)


def links_of(source: Object) -> tuple[str, str]:
    """Names of the collections of an emitter; empty: it lights all, and all block it."""
    if not HAS_LINKING:
        return "", ""
    linking = source.light_linking
    return tuple(
        "" if collection is None else collection.name_full
        for collection in (linking.receiver_collection, linking.blocker_collection)
    )


def read_links(depsgraph: Depsgraph, reports: Reports | None) -> tuple[LinkedSets, LinkedSets]:
    """Of receivers and of blockers."""
    if not HAS_LINKING:
        return LinkedSets(), LinkedSets()
    receivers: dict[int, Collection] = {}
    blockers: dict[int, Collection] = {}
    for thing in depsgraph.ids:
        if not isinstance(thing, bpy.types.Object):
            continue
        linking = thing.light_linking
        for collection, found in ((linking.receiver_collection, receivers), (linking.blocker_collection, blockers)):
            if collection is not None:
                found[collection.as_pointer()] = collection
    return _sets(receivers, "lit", reports), _sets(blockers, "blocking", reports)


def _sets(collections: dict[int, Collection], what: str, reports: Reports | None) -> LinkedSets:
    """The sets into which collections sort objects."""
    if not collections:
        return LinkedSets()
    counted = dict(list(collections.items())[:_MOST_COLLECTIONS])
    masks_of: dict[int, tuple[int, int]] = {}  # of objects: the collections that include it, and that exclude it
    for number, collection in enumerate(counted.values()):
        bit = 1 << number
        for is_included, thing in _named_by(collection):
            included, excluded = masks_of.get(thing, (0, 0))
            masks_of[thing] = (included | bit, excluded & ~bit) if is_included else (included & ~bit, excluded | bit)
    number_of: dict[tuple[int, int], int] = {}
    set_of: dict[int, int] = {}
    for thing, masks in masks_of.items():
        if masks not in number_of and len(number_of) < _MOST_SETS - 1:
            number_of[masks] = len(number_of) + 1
        set_of[thing] = number_of.get(masks, 0)
    if reports is not None and (len(collections) > len(counted) or 0 in set_of.values()):
        reports.add("Light linking", f"more than 64 collections or sets of {what} objects: others are not linked")
    sets_of = {}
    for number, address in enumerate(counted):
        bit = 1 << number
        included_sets = sum(1 << index for masks, index in number_of.items() if masks[0] & bit)
        excluded_sets = sum(1 << index for masks, index in number_of.items() if masks[1] & bit)
        sets_of[address] = (included_sets or ALL_SETS) & ~excluded_sets
    return LinkedSets(set_of, sets_of)


def _named_by(collection: Collection) -> Iterator[tuple[bool, int]]:
    """Whether it includes an object, and which; what a child collection says holds for all below it."""
    for child, of_child in zip(collection.children, collection.collection_children, strict=True):
        for thing in child.all_objects:
            yield of_child.light_linking.link_state == "INCLUDE", thing.as_pointer()
    for thing, entry in zip(collection.objects, collection.collection_objects, strict=True):
        yield entry.light_linking.link_state == "INCLUDE", thing.as_pointer()


class LinkedMedia:
    """The media of a frame by the sets of the objects that hold them: those of one material may be in several."""

    def __init__(self, materials: MaterialReader) -> None:
        self._materials = materials
        self._copies: dict[tuple[int, int], int] = {}
        self._set_of: dict[int, int] = {}
        self._dark: dict[int, int] = {}

    def material_in(self, index: int, receiver_set: int) -> int:
        """A material, or a copy with a medium of its own where its medium is in another set."""
        material = self._materials.materials[index]
        if receiver_set == 0 or material.medium < 0:
            return index
        if (index, receiver_set) not in self._copies:
            medium = self._materials.add_medium(
                replace(self._materials.media[material.medium], receiver_set=receiver_set)
            )
            self._set_of[medium] = receiver_set
            self._copies[index, receiver_set] = self._materials.add_copy(index, medium)
        return self._copies[index, receiver_set]

    def make_dark(self, links: LightLinks | None) -> None:
        """Before unlit_by: media that dim as much as those that an emitter does not light."""
        for medium in self._unlit(links):
            if medium not in self._dark:
                lit = self._materials.media[medium]
                sigma_t = tuple(
                    absorbed + sum(lobe.sigma_s_per_m[channel] for lobe in lit.lobes)
                    for channel, absorbed in enumerate(lit.sigma_a_per_m)
                )
                self._dark[medium] = self._materials.add_medium(Medium(name=lit.name, sigma_a_per_m=sigma_t))

    def unlit_by(self, links: LightLinks | None) -> tuple[tuple[int, int], ...]:
        """As Light.unlit_media."""
        return tuple((medium, self._dark[medium]) for medium in self._unlit(links))

    def _unlit(self, links: LightLinks | None) -> list[int]:
        if links is None or links.receiver_sets == ALL_SETS:
            return []
        lit = (medium for medium in range(len(self._materials.media)) if medium not in self._dark.values())
        return [medium for medium in lit if not links.receiver_sets >> self._set_of.get(medium, 0) & 1]


def make_dark_media(
    placements: list[Placement], volumes: list[Placement], media: LinkedMedia, reports: Reports
) -> None:
    """Those that lamps need which do not light all."""
    for lamp in placements:
        links = lamp.lighting.links if lamp.data is None and lamp.lighting is not None else None
        media.make_dark(links)
        if volumes and links is not None and links.receiver_sets != ALL_SETS:
            reports.add(f'Light "{lamp.object_name}"', "light linking does not reach density grids: it lights them all")
