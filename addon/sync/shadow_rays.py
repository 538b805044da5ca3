# SPDX-License-Identifier: GPL-3.0-or-later
"""A material's switch "Transparent Shadows": without it no light passes where rays from the camera do, as in Cycles.

Materials with a volume let it pass all the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.surface_inputs import PointInput, RayBit

from .coordinates import point_input

if TYPE_CHECKING:
    import bpy

    from .program import Program, Value


def passable(program: Program, transparent: Value, material: bpy.types.Material, *, has_volume: bool) -> Value:
    """How much of each ray a surface lets through, ``transparent`` of those from the camera."""
    if has_volume or _lets_shadow_rays_pass(material):
        return transparent
    of_shadows = point_input(program, PointInput.IS_RAY, selector=int(RayBit.SHADOW))
    return program.multiply(transparent, program.complement(of_shadows))


def _lets_shadow_rays_pass(material: bpy.types.Material) -> bool:
    """From 4.2 on a property of Blender's own; before, of Cycles, where its add-on is on."""
    own = getattr(material, "use_transparent_shadow", None)
    return bool(getattr(getattr(material, "cycles", None), "use_transparent_shadow", True) if own is None else own)
