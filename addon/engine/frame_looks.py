# SPDX-License-Identifier: GPL-3.0-or-later
"""All that a picture of one moment is made from, read of Blender's scene, and whether two moments look the same."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tyndall.fingerprints import fingerprint
from tyndall.lens_points import has_lens_points
from tyndall.moved_instances import is_same, sharing

from ..sync.cameras import read_camera
from ..sync.heterogeneity import read_heterogeneity
from ..sync.reports import Reports
from ..sync.transfer_functions import read_transfer_functions

if TYPE_CHECKING:
    from collections.abc import Callable

    from bpy.types import Depsgraph, Object, RenderEngine, Scene

    from tyndall.heterogeneity import Heterogeneity
    from tyndall.scene_description import Camera, SceneDescription
    from tyndall.transfer_functions import WeightedFunction

    from .sessions import KeptFrame


@dataclass(frozen=True, kw_only=True, eq=False)
class Look:
    """Nothing of Blender's is in it: it lasts while other moments are evaluated."""

    description: SceneDescription
    camera: Camera
    functions: tuple[WeightedFunction, ...]
    heterogeneity: Heterogeneity | None

    def is_same(self, other: Look) -> bool:
        """Whether pictures of both are the same, up to what reports say."""
        return _of_view(self) == _of_view(other) and is_same(self.description, other.description)


def _of_view(look: Look) -> bytes:
    return fingerprint((look.camera, look.functions, look.heterogeneity))


@dataclass(kw_only=True, eq=False)
class LookReader:
    """Of one render: the frame, and after that the moments of a shutter, which share what does not change."""

    engine: RenderEngine
    depsgraph: Depsgraph
    settings: Scene  #: Evaluated; another one than the depsgraph's where that renders for it.
    size_px: tuple[int, int]
    kept: KeptFrame
    poll: Callable[[], None]
    camera: Object  #: Evaluated: a shutter that is open over a cut sees the frame's camera alone.
    is_lit: bool = True

    def read(self, reports: Reports, *, begins_moments: bool) -> Look:
        """The present frame; ``begins_moments``: others follow."""
        self.kept.reader.begin_moments(is_live=begins_moments)
        return self._read(reports, None, is_live=begins_moments)

    def read_moment(self, before: Look) -> Look:
        """The moment that Blender has evaluated now: ``before`` itself, where it looks the same."""
        if not self.depsgraph.updates:
            look = self._read(Reports(), before.description, is_live=True)
        else:
            self.kept.reader.note_updates(self.depsgraph)
            look = self._read(Reports(), None, is_live=True)
            look = replace(look, description=sharing(before.description, look.description))
        return before if look.is_same(before) else look

    def _read(self, reports: Reports, description: SceneDescription | None, *, is_live: bool) -> Look:
        camera = self._camera(reports)
        functions = read_transfer_functions(self.settings, self.depsgraph, self.kept.function_images, reports)
        heterogeneity = read_heterogeneity(self.depsgraph, reports, self.settings)
        if description is None:
            description = self.kept.reader.read(self.depsgraph, reports, self.poll, is_live=is_live, is_lit=self.is_lit)
            if camera.lens is not None and not has_lens_points(camera) and description.media:
                note = "its depth of field blurs surfaces; light shafts stay sharp, but for perspective cameras"
                reports.add(f'Camera "{self.camera.name}"', note)
            if reports.lines() != description.reports:
                description = replace(description, reports=reports.lines())
        return Look(description=description, camera=camera, functions=functions, heterogeneity=heterogeneity)

    def _camera(self, reports: Reports) -> Camera:
        return read_camera(
            self.camera,
            self.settings.render,
            self.size_px,
            reports,
            world_from_camera=np.array(self.engine.camera_model_matrix(self.camera)),
            # Of other objects Blender reads it where a camera would have it.
            shift_x=self.engine.camera_shift_x(self.camera) if self.camera.type == "CAMERA" else None,
        )
