# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes that geometry nodes give to instances, level by level: the innermost that has one counts.

Based on: Blender's geometry_set_instances duplis: how instances are numbered on each level, and named by ids.
Limits:   Blender tells them from 4.5 on. Unknown, too: of instances that share an id, and of those of geometry nodes
          within collections that others instance.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

if TYPE_CHECKING:
    from bpy.types import Depsgraph, Object
    from numpy.typing import NDArray

    from .asked_properties import Rgba

_IS_TOLD = hasattr(bpy.types.Object, "evaluated_geometry")
_NO_LEVEL = 2**31 - 1  #: In Blender's path to an instance.
#: By data type: what a point calls it, how many numbers it has, and of which kind.
_NUMBERS = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, np.bool_),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
}


class AttributeReader:
    """Of one depsgraph."""

    def __init__(self, depsgraph: Depsgraph) -> None:
        self._depsgraph = depsgraph
        self._of_object: dict[Object, _Level | None] = {}
        self._instances_nodes: dict[tuple[Object, Object], bool] = {}

    def read(self, name: str, parent: Object, source: Object, path: tuple[int, ...]) -> tuple[Rgba | None, bool]:
        """Of an instance of ``source``; and whether all of its levels are known."""
        ids = [number for number in path if number != _NO_LEVEL]
        level = self._level_of(parent)
        if level is None:
            is_of_nodes = self._has_nodes(parent, source) and not (_IS_TOLD and len(ids) == 1)
            if not is_of_nodes:
                return None, True
            level = self._level_of(source)  # one of those that it instances
            ids.pop()
            if level is None:
                return None, False
        value: Rgba | None = None
        while level is not None and ids:
            index = level.index_of(ids.pop())
            if index is None:
                return value, False
            value = level.value(name, index) or value
            below = level.reference(index)
            if isinstance(below, bpy.types.Collection):
                return value, len(ids) <= 1
            level = self._level_of(below) if isinstance(below, bpy.types.Object) else below
        return value, True

    def _level_of(self, thing: Object) -> _Level | None:
        if thing not in self._of_object:
            may_have = _IS_TOLD and _has_nodes(thing)
            evaluated = thing.evaluated_get(self._depsgraph) if may_have else None
            self._of_object[thing] = None if evaluated is None else _Level.of(evaluated.evaluated_geometry())
        return self._of_object[thing]

    def _has_nodes(self, parent: Object, source: Object) -> bool:
        """What the one instances, or itself."""
        if (parent, source) not in self._instances_nodes:
            collection = parent.instance_collection if parent.instance_type == "COLLECTION" else None
            within = () if collection is None else collection.all_objects
            self._instances_nodes[parent, source] = any(map(_has_nodes, (parent, source, *within)))
        return self._instances_nodes[parent, source]


def _has_nodes(thing: Object) -> bool:
    return any(modifier.type == "NODES" for modifier in thing.modifiers)


class _Level:
    """The instances of one geometry."""

    def __init__(self, geometry: bpy.types.GeometrySet, points: bpy.types.PointCloud) -> None:
        self._geometry = geometry  # whose the points are
        self._points = points
        self._values: dict[str, NDArray[np.float32] | None] = {}
        self._below: dict[int, bpy.types.Object | bpy.types.Collection | _Level | None] = {}

    @classmethod
    def of(cls, geometry: bpy.types.GeometrySet) -> _Level | None:
        points = geometry.instances_pointcloud()
        return None if points is None else cls(geometry, points)

    def index_of(self, number: int) -> int | None:
        """Of the instance that Blender calls so: by its id, where instances have some."""
        if self._indices is None:
            return number
        return self._indices.get(number)

    def value(self, name: str, index: int) -> Rgba | None:
        if name not in self._values:
            self._values[name] = self._read(name)
        values = self._values[name]
        if values is None:
            return None
        red, green, blue, alpha = values[index].tolist()
        return red, green, blue, alpha

    def reference(self, index: int) -> bpy.types.Object | bpy.types.Collection | _Level | None:
        number = int(self._reference_numbers[index])
        if number not in self._below:
            found = self._references[number] if 0 <= number < len(self._references) else None
            self._below[number] = _Level.of(found) if isinstance(found, bpy.types.GeometrySet) else found
        return self._below[number]

    @cached_property
    def _indices(self) -> dict[int, int] | None:
        if "id" not in self._points.attributes:
            return None
        ids = self._numbers("id").astype(int).ravel().tolist()
        return {number: index for index, number in reversed(list(enumerate(ids)))}

    @cached_property
    def _reference_numbers(self) -> NDArray[Any]:
        return self._numbers(".reference_index").ravel()

    @cached_property
    def _references(self) -> list[bpy.types.Object | bpy.types.Collection | bpy.types.GeometrySet | None]:
        return list(self._geometry.instance_references())

    def _numbers(self, name: str) -> NDArray[Any]:
        """(count, numbers)."""
        attribute = self._points.attributes[name]
        called, width, kind = _NUMBERS[attribute.data_type]
        numbers: NDArray[Any] = np.empty(width * len(attribute.data), kind)
        attribute.data.foreach_get(called, numbers)
        return numbers.reshape(-1, width)

    def _read(self, name: str) -> NDArray[np.float32] | None:
        """(count, 4), as colours; None where there is none that is one."""
        attribute = self._points.attributes.get(name)
        if attribute is None or attribute.data_type not in _NUMBERS:
            return None
        found = self._numbers(name)
        count, width = found.shape
        colours = np.zeros((count, 4), np.float32)
        colours[:, 3] = 1.0
        colours[:, : 3 if width == 1 else width] = found
        return colours
