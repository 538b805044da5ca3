# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of which only lights have changed since it was read: they are read anew, thousands of instances are not.

Differs: nothing of Blender's is kept from read to read but names: after an undo, evaluated objects lie elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy

from .instances import Placement, shown_kinds

if TYPE_CHECKING:
    from bpy.types import ID, Depsgraph, SpaceView3D

    from tyndall.scene_description import Light, SceneDescription

    from .reports import Reports


@dataclass(frozen=True, kw_only=True)
class ReadScene:
    """The last read of a live depsgraph."""

    description: SceneDescription
    reports: Reports  #: About all but its lights.
    depsgraph: int  #: By address.
    shown_kinds: tuple[object, ...]  #: What the viewport was set to show.
    is_lit: bool
    drawn: frozenset[str]  #: Names of the objects with a mesh.
    lights: tuple[tuple[str, str | None], ...]  #: Names of their objects, and the libraries that these are from.
    sky_suns: tuple[Light, ...]  #: Of the world, which no object has.
    has_instanced_lights: bool

    def serves(self, depsgraph: Depsgraph, viewport: SpaceView3D | None, *, is_lit: bool) -> bool:
        """Whether a read of this would differ in lights alone, if nothing but lights was updated."""
        return (
            not self.has_instanced_lights
            and self.depsgraph == depsgraph.as_pointer()
            and self.shown_kinds == shown_kinds(viewport)
            and self.is_lit == is_lit
            and all(bpy.data.objects.get(light) is not None for light in self.lights)
        )

    def light_placements(self, depsgraph: Depsgraph) -> list[Placement]:
        """Where its lights are now."""
        placements = []
        for light in self.lights:
            original = bpy.data.objects[light]
            source = original.evaluated_get(depsgraph)
            placements.append(
                Placement(
                    object_name=original.name,
                    data=None,
                    materials=(),
                    source=source,
                    is_camera_visible=source.visible_camera,
                    casts_shadow=source.visible_shadow,
                    matrices=[source.matrix_world.copy()],
                )
            )
        return placements


def is_light(thing: ID) -> bool:
    """The object of a light, or its data. What depends on it has updates of its own."""
    return isinstance(thing, bpy.types.Light) or (isinstance(thing, bpy.types.Object) and thing.type == "LIGHT")


def light_names(placements: list[Placement]) -> tuple[tuple[str, str | None], ...]:
    """As ``bpy.data.objects`` takes them."""
    originals = [placement.source.original for placement in placements if placement.data is None]
    return tuple((thing.name, thing.library.filepath if thing.library else None) for thing in originals)
