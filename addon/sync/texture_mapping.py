# SPDX-License-Identifier: GPL-3.0-or-later
"""The mapping that every texture node has of its own, in the editor's side bar: what old files placed textures with."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mathutils import Matrix, Vector

from tyndall.scene_description import Code

from .math_nodes import vector_operation

if TYPE_CHECKING:
    import bpy

    from .node_graph import Socket
    from .program import Value
    from .value_nodes import ValueReader

_SMALLEST = 1e-5  #: Scales that are inverted are no smaller, as in Cycles.


def mapped(reader: ValueReader, at: Socket, vector: Value) -> Value:
    """``vector`` as the node of ``at`` places it."""
    mapping = at.node.texture_mapping
    linear, offset = _affine(mapping)
    if mapping.vector_type != "NORMAL" and linear == Matrix.Identity(3) and offset == Vector((0.0, 0.0, 0.0)):
        return vector
    rows = tuple(number for row in linear for number in row)
    placed = reader.program.operation(Code.AFFINE, vector, uv_matrix=rows, value=tuple(offset))
    return vector_operation(reader.program, "NORMALIZE", placed) if mapping.vector_type == "NORMAL" else placed


def own_matrix(node: bpy.types.Node) -> Matrix | None:
    """4x4; None where the node makes a unit vector of what it reads, as a normal's."""
    if node.texture_mapping.vector_type == "NORMAL":
        return None
    linear, offset = _affine(node.texture_mapping)
    return Matrix.Translation(offset) @ linear.to_4x4()


def _affine(mapping: bpy.types.TexMapping) -> tuple[Matrix, Vector]:
    kind = mapping.vector_type
    scale = mapping.scale
    if kind in {"TEXTURE", "NORMAL"}:
        scale = Vector([_SMALLEST if abs(factor) < _SMALLEST else factor for factor in scale])
    linear = mapping.rotation.to_matrix() @ Matrix.Diagonal(scale)
    offset = Vector(mapping.translation) if kind in {"TEXTURE", "POINT"} else Vector((0.0, 0.0, 0.0))
    if kind == "TEXTURE":
        linear = linear.inverted()
        offset = -(linear @ offset)
    elif kind == "NORMAL":
        linear = linear.inverted().transposed()
    axes = Matrix(((0.0,) * 3,) * 3)
    for row, axis in enumerate((mapping.mapping_x, mapping.mapping_y, mapping.mapping_z)):
        if axis != "NONE":
            axes[row]["XYZ".index(axis)] = 1.0
    return linear @ axes, offset
