# SPDX-License-Identifier: GPL-3.0-or-later
"""A world's ray visibility, which Cycles' add-on keeps: rays for which it is not there find it black."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.scene_description import LitKinds
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


def is_shown(world: bpy.types.World, rays: str) -> bool:
    """``rays``: as Cycles' switches are called."""
    of_cycles = getattr(world, "cycles_visibility", None)  # where its add-on is on
    return of_cycles is None or getattr(of_cycles, rays)


def lit_surfaces(world: bpy.types.World) -> LitKinds:
    """What its light, and that of its suns, falls on."""
    return LitKinds(*(is_shown(world, rays) for rays in ("diffuse", "glossy", "transmission")))


def shown_to_rays(reader: ValueReader, world: bpy.types.World) -> Value:
    """What to multiply its light by where rays see it. What lights surfaces and air asks as diffuse rays do."""
    shown: Value = WHITE
    program = reader.program
    for rays, bits in _RAYS.items():
        if not is_shown(world, rays):
            asked_by = point_input(program, PointInput.IS_RAY, selector=int(bits))
            shown = program.multiply(shown, program.complement(asked_by))
    return shown
