# SPDX-License-Identifier: GPL-3.0-or-later
"""The edits of lights' occluders that have a say, in the order in which they are made.

An edit that cannot be made as it is meant is left out, with a report that names it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.scene_description import EditKind, HoleNoise, KernelShape, LightMask, OccluderEdit

from ..item_lists import having_a_say
from .images import without_pixels
from .instances import instanced_names
from .names import name_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import bpy

    from ..properties.occluder_edits import TyndallOccluderEdit
    from .images import ImageReader
    from .light_masks import MaskReader
    from .names import Name
    from .reports import Reports

_INSTANCING_MODIFIERS = frozenset({"NODES", "PARTICLE_SYSTEM"})


class _CannotBeMade(Exception):  # noqa: N818  said to the artist, not raised to a caller
    pass


class OccluderEditReader:
    """Reads the edits of one frame's lights."""

    def __init__(
        self,
        depsgraph: bpy.types.Depsgraph,
        drawn: frozenset[str],
        images: ImageReader,
        masks: MaskReader,
        reports: Reports,
        poll: Callable[[], None],
    ) -> None:
        """``drawn``: names of all objects whose meshes are drawn."""
        self._depsgraph = depsgraph
        self._drawn = drawn
        self._images = images
        self._masks = masks
        self._reports = reports
        self._poll = poll
        self._instanced: dict[Name, set[str]] | None = None

    def read(self, light: bpy.types.Light, light_name: str) -> tuple[OccluderEdit, ...]:
        """``light`` is evaluated: what is animated or driven has its value at this frame.

        Its pointers are not read: they may outlive what they point to; those of the original are cleared at once.
        """
        originals = light.original.tyndall.occluder_edits
        edits = []
        for edit in having_a_say(light.tyndall.occluder_edits):
            if edit.name not in originals:  # a script has removed it, and tagged nothing
                continue
            culprit = f'Light "{light_name}", edit "{edit.name}"'
            try:
                edits.append(self._read_edit(edit, originals[edit.name], culprit))
            except _CannotBeMade as reason:
                self._reports.add(culprit, f"left out: {reason}")
        return tuple(edits)

    def _read_edit(self, edit: TyndallOccluderEdit, original: TyndallOccluderEdit, culprit: str) -> OccluderEdit:
        noise = edit.noise
        return OccluderEdit(
            name=edit.name,
            kind=EditKind[edit.kind],
            shape=KernelShape[edit.shape],
            size_m=edit.size_m,
            distance_m=edit.distance_m,
            noise=HoleNoise(
                scale_m=noise.scale_m,
                octaves=noise.octaves,
                persistence=noise.persistence,
                probability=noise.probability,
                sway=noise.sway,
                turn_rad=noise.turn_rad,
                seed=noise.seed,
            ),
            affects_surfaces=edit.affects_surfaces,
            objects=self._objects(original),
            mask=self._mask(original, edit.mask_size_m, culprit),
        )

    def _objects(self, original: TyndallOccluderEdit) -> tuple[str, ...] | None:
        """Names as placements have them: of an instance, its source's."""
        if original.target == "ALL":
            return None
        target = original.target_object if original.target == "OBJECT" else original.target_collection
        kind = original.target.lower()
        if target is None:
            raise _CannotBeMade(f"its {kind} is not set, or deleted")
        what = f'its {kind} "{target.name}"'
        if original.target == "OBJECT":
            things = [target]
        else:
            things = list(target.all_objects)
            if not things:
                raise _CannotBeMade(f"{what} is empty")
        seen: set[int] = set()
        names = self._drawn.intersection(name for thing in things for name in self._names(thing, seen))
        if not names:  # an object that was deleted from its scene lives on in our pointer
            raise _CannotBeMade(f"nothing of {what} is drawn")
        return tuple(sorted(names))

    def _names(self, thing: bpy.types.Object, seen: set[int]) -> Iterator[str]:
        """Of all that may stand in the light's way for an object: itself, and what it instances."""
        if thing.as_pointer() in seen:
            return
        seen.add(thing.as_pointer())
        yield thing.name
        if thing.instance_type == "COLLECTION" and thing.instance_collection is not None:
            for instanced in thing.instance_collection.all_objects:
                yield from self._names(instanced, seen)
        elif thing.instance_type != "NONE" or any(one.type in _INSTANCING_MODIFIERS for one in thing.modifiers):
            if self._instanced is None:
                self._instanced = instanced_names(self._depsgraph, self._poll)
            yield from self._instanced.get(name_of(thing), ())

    def _mask(self, original: TyndallOccluderEdit, size_m: float, culprit: str) -> LightMask | None:
        if original.mask_image is None:
            return None
        image = original.mask_image
        if (reason := without_pixels(image)) is not None:
            raise _CannotBeMade(f"its mask, {reason}")
        pixels = self._images.read(image, self._reports, culprit)
        values = self._masks.read(pixels, original.mask_channel)
        return LightMask(name=image.name, values=values, size_m=size_m)
