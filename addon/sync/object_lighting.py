# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups of objects and worlds, as Cycles reads them.

An instance whose object is in no group has that of its instancer. A name that the view layer does not list is no group.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tyndall.scene_description import ObjectLighting

if TYPE_CHECKING:
    from bpy.types import Depsgraph, Object, ViewLayer

    from .reports import Reports

MOST_GROUPS = 255  #: That native lights tell apart.


@dataclass(frozen=True)
class LightingReader:
    """How light meets the objects of one depsgraph."""

    light_groups: tuple[str, ...]

    @classmethod
    def of(cls, depsgraph: Depsgraph) -> LightingReader:
        """Of the view layer that it evaluates."""
        return cls(light_groups=light_groups(depsgraph.view_layer_eval))

    def concerns(self, thing: Object) -> bool:
        """Whether what the object instances may be lit, or light, otherwise than what others instance."""
        return bool(self.light_groups) and thing.lightgroup in self.light_groups

    def read(self, source: Object, parent: Object | None) -> ObjectLighting | None:
        """Of an evaluated object, instanced by ``parent`` or standing for itself; None: as most objects."""
        lighting = ObjectLighting()
        if self.light_groups:
            name = source.lightgroup or (parent.lightgroup if parent is not None else "")
            lighting = replace(lighting, light_group=name if name in self.light_groups else "")
        return None if lighting == ObjectLighting() else lighting


def light_groups(view_layer: ViewLayer) -> tuple[str, ...]:
    """Names of the view layer's groups that are kept apart."""
    return tuple(group.name for group in view_layer.lightgroups)[:MOST_GROUPS]


def report_left_out(view_layer: ViewLayer, reports: Reports) -> None:
    """What of light groups a picture will lack."""
    for group in view_layer.lightgroups[MOST_GROUPS:]:
        reports.add(f'Light group "{group.name}"', f"it stays black: {MOST_GROUPS} are the most")
