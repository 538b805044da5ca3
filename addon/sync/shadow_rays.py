# SPDX-License-Identifier: GPL-3.0-or-later
"""A material's switch "Transparent Shadows": without it shadow rays pass nowhere, as in Cycles.

Materials with a volume let them pass all the same. What is transparent in place of glass then lets no rays pass that
gather light: in Cycles those that surfaces scatter pass what is transparent, and no glass.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.surface_inputs import PointInput, RayBit

from .coordinates import point_input

if TYPE_CHECKING:
    import bpy

    from .program import Program, Value
    from .surface_nodes import Shares


def passable(program: Program, shares: Shares, material: bpy.types.Material, *, has_volume: bool) -> Value:
    """How much of each ray a surface lets through: of those from the camera what is transparent."""
    if has_volume or _lets_shadow_rays_pass(material):
        return shares.transparent
    kinds = RayBit.SHADOW | RayBit.DIFFUSE | RayBit.GLOSSY if shares.has_glass else RayBit.SHADOW
    of_light = point_input(program, PointInput.IS_RAY, selector=int(kinds))
    return program.multiply(shares.transparent, program.complement(of_light))


def _lets_shadow_rays_pass(material: bpy.types.Material) -> bool:
    """From 4.2 on a property of Blender's own; before, of Cycles, where its add-on is on."""
    own = getattr(material, "use_transparent_shadow", None)
    return bool(getattr(getattr(material, "cycles", None), "use_transparent_shadow", True) if own is None else own)
