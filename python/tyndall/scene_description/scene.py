# SPDX-License-Identifier: GPL-3.0-or-later
"""All that a picture shows, but for who sees it."""

from __future__ import annotations

from dataclasses import dataclass, field

from .geometry import Instances, StrandObjects, VoxelObjects
from .lights import Light, World
from .materials import Material
from .media import Medium, Volume


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneDescription:
    """Everything but the camera. Equal keys of meshes and images mean equal content."""

    instances: tuple[Instances, ...] = ()
    voxel_objects: tuple[VoxelObjects, ...] = ()
    strand_objects: tuple[StrandObjects, ...] = ()
    materials: tuple[Material, ...] = ()
    media: tuple[Medium, ...] = ()
    volumes: tuple[Volume, ...] = ()
    lights: tuple[Light, ...] = ()
    world: World = field(default_factory=World)
    light_groups: tuple[str, ...] = ()  #: Names, each once: what pictures may hold apart.
    reports: tuple[str, ...] = ()  #: What the exporter replaced or left out, one line each, naming the culprit.
