# SPDX-License-Identifier: GPL-3.0-or-later
"""What of the shafts moves over time: keyed and driven properties of the scene, its lights, functions and media."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any

import bpy

from .animation_paths import animated_paths
from .scene_media import media_materials
from .shader_nodes import shader_tree

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bpy.types import ID, Scene

#: Of the scene and of lights, what is ours; of a light's own, what its shafts show.
_OURS = "tyndall."
_LIGHT_PATHS = frozenset({"energy", "color", "exposure", "temperature", "angle", "shadow_soft_size", "spot_size"})
_SAME_FRAME = 0.5  #: Frames: keys that are nearer than this are one in the timeline.


@dataclass(frozen=True, kw_only=True)
class AnimatedProperty:
    """One property of a datablock, all of its channels."""

    owner: ID
    path: str
    is_driven: bool
    key_frames: tuple[float, ...]  #: In time, without doubles.

    @property
    def identifier(self) -> str:
        """Names it among all of the file."""
        return f"{self.owner!r}.{self.path}"

    @property
    def holder(self) -> Any:  # noqa: ANN401  of any type
        """What has the property: a datablock, or a group or a node in one."""
        return self.owner.path_resolve(self.path.rpartition(".")[0]) if "." in self.path else self.owner

    @property
    def name(self) -> str:
        return self.path.rpartition(".")[2]

    @property
    def is_array(self) -> bool:
        """Whether it has several channels: a colour, a vector."""
        return bool(getattr(self.holder.bl_rna.properties[self.name], "is_array", False))

    @property
    def label(self) -> str:
        """What an artist calls it: who has it, and the property."""
        holder = self.holder
        what = holder.name if isinstance(holder, bpy.types.NodeSocket) else holder.bl_rna.properties[self.name].name
        return f"{self._within()}: {what}"

    def _within(self) -> str:
        """Name of the innermost item or node that has it; of none, the scene's part or the datablock."""
        for match in reversed(list(re.finditer(r"\]", self.path))):
            item = self.owner.path_resolve(self.path[: match.end()])
            if not isinstance(item, bpy.types.NodeSocket) and getattr(item, "name", ""):
                return str(item.name)
        if isinstance(self.owner, bpy.types.Scene):
            return "Air" if self.path.startswith("tyndall.heterogeneity.") else "Shafts"
        return str(self.owner.name)

    def keys_at(self, frame: float) -> list[float]:
        """Times of its keys that the timeline shows at a frame."""
        return [key for key in self.key_frames if abs(key - frame) < _SAME_FRAME]


def animated_properties(scene: Scene) -> list[AnimatedProperty]:
    """Of the scene first, then of lights, functions and media. Paths that lead nowhere any more are left out."""
    return [found for owner in _owners(scene) for found in _animated(owner)]


def next_key(scene: Scene, frame: float, *, is_forward: bool) -> float | None:
    """The nearest key of any of them after a frame, or before it."""
    keys = {key for found in animated_properties(scene) for key in found.key_frames}
    if is_forward:
        return min((key for key in keys if key > frame + 1e-3), default=None)
    return max((key for key in keys if key < frame - 1e-3), default=None)


def _owners(scene: Scene) -> Iterator[ID]:
    yield scene
    yield from (light for light in bpy.data.lights if light.users)
    seen = set()
    for state in scene.tyndall.shafts.transfer_states:
        if state.function is not None and state.function not in seen:
            seen.add(state.function)
            yield state.function
    media = chain(media_materials(), (scene.world,))
    yield from (tree for owner in media if (tree := shader_tree(owner)) is not None)


def _animated(owner: ID) -> Iterator[AnimatedProperty]:
    keyed, driven = animated_paths(owner)
    for path in sorted(path for path in {*keyed, *driven} if _is_of_shafts(owner, path)):
        found = AnimatedProperty(
            owner=owner,
            path=path,
            is_driven=path in driven,
            key_frames=tuple(sorted({key.co.x for curve in keyed.get(path, ()) for key in curve.keyframe_points})),
        )
        if _exists(found):
            yield found


def _is_of_shafts(owner: ID, path: str) -> bool:
    if isinstance(owner, bpy.types.NodeTree):
        return True
    return path.startswith(_OURS) or (isinstance(owner, bpy.types.Light) and path in _LIGHT_PATHS)


def _exists(found: AnimatedProperty) -> bool:
    try:
        return found.name in found.holder.bl_rna.properties
    except ValueError:  # the item was removed by a script, and its keys stayed
        return False
