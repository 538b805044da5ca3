# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that stand for the voxels of a ``.tdag`` file, which are drawn in place of their own mesh.

``Object.tyndall_voxels.path`` names the file; ``//`` is the folder of the object's own .blend file. A file is read once
for all objects that name it, and again when its time or size has changed. The voxels lie in the object's space as their
bounds say.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tyndall import IoError
from tyndall.scene_description import VoxelObjects

from ..voxel_boxes import file_of, is_voxel_box
from .asking_materials import note_unread
from .mesh_attributes import what_is_missing
from .placed_objects import placed

if TYPE_CHECKING:
    from collections.abc import Callable

    from bpy.types import Object

    from tyndall.voxel_dag import VoxelDag

    from .instances import Placement
    from .materials import MaterialReader
    from .reports import Reports


def voxel_path(thing: Object) -> str:
    """The file whose voxels stand for the object, absolute; "": it is drawn by its mesh."""
    return str(file_of(thing)) if is_voxel_box(thing) else ""


def without_and_with_voxels(placements: list[Placement]) -> tuple[list[Placement], list[Placement]]:
    """Those that are drawn by their meshes, and those that have a voxel_path."""
    groups: tuple[list[Placement], list[Placement]] = [], []
    for placement in placements:
        groups[bool(voxel_path(placement.source))].append(placement)
    return groups


class VoxelReader:
    """Reads the voxel objects of frames one after another; keeps the files that the next frame may share."""

    def __init__(self) -> None:
        self._dags: dict[str, tuple[tuple[int, int], VoxelDag]] = {}  # by path, with time and size

    def read(
        self, placements: list[Placement], materials: MaterialReader, reports: Reports, poll: Callable[[], None]
    ) -> tuple[VoxelObjects, ...]:
        """Of placements that have a voxel_path. One whose file cannot be read is left out, with a report."""
        kept: dict[str, tuple[tuple[int, int], VoxelDag]] = {}
        groups = []
        for placement in placements:
            poll()
            note_unread(placement, reports)
            path = voxel_path(placement.source)
            try:
                if path not in kept:
                    kept[path] = self._load(path)
            except (OSError, IoError) as error:
                reports.add(f'Object "{placement.object_name}"', f"its voxels are left out: {error}")
                continue
            groups.append(_group(placement, kept[path][1], materials, reports))
        self._dags = kept
        return tuple(groups)

    def _load(self, path: str) -> tuple[tuple[int, int], VoxelDag]:
        from tyndall.voxel_dag import load

        status = Path(path).stat()
        version = status.st_mtime_ns, status.st_size
        before = self._dags.get(path)
        return before if before is not None and before[0] == version else (version, load(path))


def _group(placement: Placement, dag: VoxelDag, materials: MaterialReader, reports: Reports) -> VoxelObjects:
    material = materials.index(placement.materials[0], placement)
    if materials.materials[material].medium >= 0:
        reports.add(f'Object "{placement.object_name}"', "voxels bound no medium: its material's volume is left out")
    for what in what_is_missing(materials.materials[material].uv_maps, ()):
        reports.add(f'Object "{placement.object_name}"', f"voxels have no {what}, which its material reads")
    return VoxelObjects(
        dag=dag,
        material=material,
        **placed(placement),
    )
