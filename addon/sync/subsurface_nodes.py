# SPDX-License-Identifier: GPL-3.0-or-later
"""What scatters light below the surface: the Subsurface Scattering node, and what a Principled BSDF has of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.scene_description import SubsurfaceMethod

from .program import BLACK, WHITE, Value, grey

if TYPE_CHECKING:
    from .node_graph import Socket
    from .value_nodes import ValueReader

_GREY, _RADIUS = grey(0.8), (1.0, 0.2, 0.1)
_IS_OLD = bpy.app.version < (4, 0, 0)  #: Then walks begin by the cosine, and what is skin since was the plain walk.
_METHODS = {
    "BURLEY": SubsurfaceMethod.PROFILE,
    "RANDOM_WALK_FIXED_RADIUS": SubsurfaceMethod.COSINE_WALK,
    "RANDOM_WALK": SubsurfaceMethod.COSINE_SKIN_WALK if _IS_OLD else SubsurfaceMethod.REFRACTED_WALK,
    "RANDOM_WALK_SKIN": SubsurfaceMethod.SKIN_WALK,
}


def method_of(at: Socket) -> SubsurfaceMethod:
    return _METHODS[getattr(at.node, "falloff", None) or at.node.subsurface_method]


def _radius(reader: ValueReader, at: Socket, prefix: str) -> Value:
    """In metres, whatever scale the object has, as in Cycles; of the Principled BSDF up to 3.x a share of it."""
    radius = reader.vector(at.input(f"{prefix}Radius"), _RADIUS)
    scale = at.input(f"{prefix}Scale")
    return radius if scale is None else reader.program.multiply(radius, reader.number(scale))


def scattering_inputs(reader: ValueReader, at: Socket) -> tuple[Value, ...]:
    """Of the Subsurface Scattering node, for LobeModel.SUBSURFACE: all but its share of the surface."""
    return (
        reader.colour(at.input("Color"), _GREY),
        _radius(reader, at, ""),
        reader.number(at.input("Roughness"), 1.0),
        reader.number(at.input("IOR"), 1.4),
        reader.number(at.input("Anisotropy")),
    )


def principled_inputs(reader: ValueReader, at: Socket, base: Value, share: Value) -> tuple[Value, ...]:
    """Of a Principled BSDF, for the last inputs of LobeModel.PRINCIPLED_SUBSURFACE, or PRINCIPLED_3_SUBSURFACE."""
    index = reader.number(at.input("Subsurface IOR"), 1.4)
    inputs = share, _radius(reader, at, "Subsurface "), index, reader.number(at.input("Subsurface Anisotropy"))
    if not _IS_OLD:
        return inputs
    return *inputs, reader.program.mix(base, reader.colour(at.input("Subsurface Color"), WHITE), share)


def principled_share(reader: ValueReader, at: Socket) -> Value:
    """Of what a Principled BSDF scatters diffusely, that which goes below the surface."""
    share = reader.program.clamp(reader.number(at.input("Subsurface Weight") or at.input("Subsurface")))
    scale = at.input("Subsurface Scale")
    return BLACK if scale is not None and reader.number(scale) == BLACK else share
