# SPDX-License-Identifier: GPL-3.0-or-later
"""IES Texture: what a luminaire was measured to send in a direction."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.photometry import DamagedFileError, Ends, read_luminaire
from tyndall.scene_description import Code
from tyndall.surface_inputs import PointInput

from .coordinates import point_input
from .domains import on_surfaces
from .program import BLACK, Value, grey

if TYPE_CHECKING:
    from .domains import Evaluate
    from .node_graph import Socket
    from .value_nodes import ValueReader

_VERSION = bpy.app.version
_ENDS = Ends.BLENDER_3 if _VERSION < (4, 0, 0) else Ends.BLENDER_4 if _VERSION < (5, 0, 0) else Ends.BLENDER_5
_OF_NO_FILE = grey(100.0)  #: In Cycles.


def _ies(reader: ValueReader, at: Socket) -> Value:
    program, strength = reader.program, reader.number(at.input("Strength"), 1.0)
    table = _table(reader, at)
    if table is None:
        return program.multiply(strength, _OF_NO_FILE)
    if table.size == 0:
        return BLACK
    place = at.input("Vector")
    vector = reader.colour(place) if place is not None and place.is_connected() else _own_vector(reader)
    value = program.operation(Code.PHOTOMETRY, vector, table=program.table(table))
    return program.multiply(strength, value)


def _own_vector(reader: ValueReader) -> Value:
    """Along the object's axes: back along the ray; up to 3.x the normal."""
    if _ENDS is Ends.BLENDER_3:
        return point_input(reader.program, PointInput.OBJECT_NORMAL)
    return point_input(reader.program, PointInput.NORMAL_TO_OBJECT, point_input(reader.program, PointInput.INCOMING))


def _table(reader: ValueReader, at: Socket) -> np.ndarray | None:
    """None where there is nothing to read, which is said; empty: it is dark."""
    try:
        named = _named_text(at.node)
    except OSError as error:
        reader.note(f'{at.node.bl_label} sends 100 everywhere: its file "{error.filename}" cannot be read')
        return None
    if named is None:
        reader.unsupported(at, "without a file sends 100 everywhere")
        return None
    name, text = named
    try:
        luminaire = read_luminaire(text, _ENDS)
    except DamagedFileError as reason:
        reader.note(f'{at.node.bl_label} sends 100 everywhere: "{name}": {reason}')
        return None
    if luminaire.is_dark:
        reader.note(f'{at.node.bl_label} is dark: the angles of "{name}" do not rise')
        return np.empty(0, np.float32)
    return luminaire.table(_ENDS)


def _named_text(node: bpy.types.Node) -> tuple[str, str] | None:
    """Raises OSError."""
    if node.mode == "INTERNAL":
        return None if node.ies is None else (node.ies.name, node.ies.as_string() + "\n")
    path = bpy.path.abspath(node.filepath, library=node.id_data.library)
    if not path:
        return None
    return Path(path).name, Path(path).read_bytes().decode("latin-1")


NODES: dict[str, Evaluate] = {"TEX_IES": on_surfaces(_ies)}
