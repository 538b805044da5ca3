# SPDX-License-Identifier: GPL-3.0-or-later
"""A world's ray visibility, which Cycles' add-on keeps: rays for which it is not there find it black."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.surface_inputs import PointInput, RayBit

from .coordinates import point_input
from .program import WHITE, Value

if TYPE_CHECKING:
    import bpy

    from .value_nodes import ValueReader

_RAYS = {
    "camera": RayBit.CAMERA,
    "diffuse": RayBit.DIFFUSE,
    "glossy": RayBit.GLOSSY | RayBit.MIRROR,
    "transmission": RayBit.TRANSMISSION,
    "scatter": RayBit.SCATTER,
}


def shown_to_rays(reader: ValueReader, world: bpy.types.World) -> Value:
    """What to multiply its light by. What lights surfaces and air asks as diffuse rays do, whatever scatters it."""
    of_cycles = getattr(world, "cycles_visibility", None)  # where its add-on is on
    hidden = {name for name in _RAYS if of_cycles is not None and not getattr(of_cycles, name)}
    if hidden - {"camera"} and len({name in hidden for name in ("diffuse", "glossy", "scatter")}) > 1:
        reader.note("its visibility to diffuse rays counts for gloss that is no mirror, and for air, too")
    shown: Value = WHITE
    program = reader.program
    for name in sorted(hidden):
        asked_by = point_input(program, PointInput.IS_RAY, selector=int(_RAYS[name]))
        shown = program.multiply(shown, program.complement(asked_by))
    return shown
