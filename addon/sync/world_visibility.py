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
    "glossy": RayBit.GLOSSY | RayBit.MIRROR,
    "transmission": RayBit.TRANSMISSION,
}


def _is_shown(world: bpy.types.World, rays: str) -> bool:
    of_cycles = getattr(world, "cycles_visibility", None)  # where its add-on is on
    return of_cycles is None or getattr(of_cycles, rays)


def lit_by(world: bpy.types.World) -> dict[str, bool]:
    """What its light falls on, as fields of a description of it and of its suns."""
    return {
        "lights_diffuse": _is_shown(world, "diffuse"),
        "lights_glossy": _is_shown(world, "glossy"),
        "lights_transmission": _is_shown(world, "transmission"),
        "scatters_in_media": _is_shown(world, "scatter"),
    }


def shown_to_rays(reader: ValueReader, world: bpy.types.World) -> Value:
    """What to multiply its light by where rays see it. What lights surfaces and air asks as diffuse rays do."""
    shown: Value = WHITE
    program = reader.program
    for name in (name for name in _RAYS if not _is_shown(world, name)):
        asked_by = point_input(program, PointInput.IS_RAY, selector=int(_RAYS[name]))
        shown = program.multiply(shown, program.complement(asked_by))
    return shown
