# SPDX-License-Identifier: GPL-3.0-or-later
"""What a read takes from a scene and its view layer beside their datablocks, as values that can be compared.

Of a click that selects, a slider of the film, and an eye that closes, Blender says the same: the scene changed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .worlds import world_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bpy.types import Depsgraph, LayerCollection, Object, SpaceView3D

_PLAIN = {"BOOLEAN", "INT", "FLOAT", "ENUM"}


def scene_state(depsgraph: Depsgraph, viewport: SpaceView3D | None) -> tuple[object, ...]:
    """Of a depsgraph, and what a viewport shows of its objects."""
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    cycles = (getattr(scene, name, None) for name in ("cycles", "cycles_curves"))  # nothing where it is switched off
    plain = scene.tyndall.indirect, layer, *cycles
    worlds_and_looks = world_of(depsgraph), scene.world, layer.material_override
    return (
        layer.name,
        scene.tyndall.texture_budget_mib,
        tuple(_plain_values(settings) for settings in plain if settings is not None),
        tuple(thing and thing.name_full for thing in worlds_and_looks),
        tuple(group.name for group in layer.lightgroups),
        tuple(_collections(layer.layer_collection)),
        tuple(_shown(thing, depsgraph, viewport) for thing in depsgraph.objects),
    )


def _plain_values(settings: Any) -> tuple[object, ...]:  # noqa: ANN401  of any class of Blender
    values = []
    for entry in settings.bl_rna.properties:
        if entry.type in _PLAIN:
            value: Any = getattr(settings, entry.identifier)
            values.append(tuple(value) if getattr(entry, "is_array", False) else value)
    return tuple(values)


def _collections(collection: LayerCollection) -> Iterator[tuple[object, ...]]:
    yield collection.name, _plain_values(collection)
    for child in collection.children:
        yield from _collections(child)


def _shown(thing: Object, depsgraph: Depsgraph, viewport: SpaceView3D | None) -> tuple[object, ...]:
    shows = [thing.visible_get(view_layer=depsgraph.view_layer_eval)]
    if viewport is not None:
        shows.append(thing.visible_in_viewport_get(viewport))
        if viewport.local_view:
            shows.append(thing.local_view_get(viewport))
    return thing.name_full, *shows
