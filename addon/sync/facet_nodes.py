# SPDX-License-Identifier: GPL-3.0-or-later
"""How the facets of gloss lie: their distribution, and along what they are wider than across, as Cycles takes them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy

from tyndall.scene_description import FacetDistribution
from tyndall.surface_inputs import PointInput

from . import coordinates
from .hair_nodes import default_tangent
from .lobe_values import Facets
from .math_nodes import math_operation, turned, vector_operation
from .program import BLACK, WHITE, Term, Value, grey

if TYPE_CHECKING:
    from .node_graph import Socket
    from .value_nodes import ValueReader

_DISTRIBUTIONS = {
    "BECKMANN": FacetDistribution.BECKMANN,
    "ASHIKHMIN_SHIRLEY": FacetDistribution.ASHIKHMIN_SHIRLEY,
}
_HARDLY = 1e-4  #: Anisotropy of Glossy that is none.
_MOST = 0.99


def facets_of_glass(at: Socket) -> Facets:
    """They are as wide along as across."""
    return Facets(distribution=_distribution(at))


def facets_of_glossy(reader: ValueReader, at: Socket) -> Facets:
    """Of Glossy, and of Anisotropic up to 3.x: narrower along the tangent where anisotropy is above 0."""
    program, anisotropy = reader.program, reader.number(at.input("Anisotropy"))
    if not isinstance(anisotropy, Term) and abs(anisotropy[0]) <= _HARDLY:
        return Facets(distribution=_distribution(at))
    anisotropy = math_operation(program, "CLAMP_MINMAX", anisotropy, grey(-_MOST), grey(_MOST))
    along = program.complement(math_operation(program, "MAXIMUM", anisotropy, BLACK))
    across = program.add(WHITE, math_operation(program, "MINIMUM", anisotropy, BLACK))
    wider = math_operation(program, "DIVIDE", along, across)
    normal = reader.normal(at.input("Normal"), is_specular=True)
    return Facets(_distribution(at), _tangent(reader, at, wider, at.input("Rotation"), normal))


def facets_of_metal(reader: ValueReader, at: Socket) -> Facets:
    """Of Metallic, and of Principled: wider along the tangent."""
    program = reader.program
    anisotropy = reader.number(at.input("Anisotropy") or at.input("Anisotropic"))
    if bpy.app.version >= (4, 0, 0):
        anisotropy = program.clamp(anisotropy)
    distribution = _distribution(at)
    if anisotropy == BLACK:
        return Facets(distribution=distribution)
    rest = program.complement(program.multiply(anisotropy, grey(0.9)))
    rest = math_operation(program, "MAXIMUM", rest, grey(1e-4))
    wider = math_operation(program, "INVERSE_SQRT", rest)
    rotation = at.input("Rotation") or at.input("Anisotropic Rotation")
    return Facets(distribution, _tangent(reader, at, wider, rotation, reader.normal(at.input("Normal"))))


def _distribution(at: Socket) -> FacetDistribution:
    return _DISTRIBUTIONS.get(getattr(at.node, "distribution", ""), FacetDistribution.GGX)


def _tangent(reader: ValueReader, at: Socket, wider: Value, rotation: Socket | None, normal: Value | None) -> Term:
    """As long as facets are ``wider`` along it. ``rotation``: whole turns about ``normal``, None: the point's own."""
    program, given = reader.program, at.input("Tangent")
    is_given = given is not None and given.is_connected()
    tangent = reader.vector(given) if is_given else default_tangent(program)
    turns = reader.number(rotation)
    if turns != BLACK:
        axis = coordinates.point_input(program, PointInput.NORMAL) if normal is None else normal
        tangent = turned(program, tangent, axis, program.multiply(turns, grey(2.0 * math.pi)))
    return program.term(program.multiply(vector_operation(program, "NORMALIZE", tangent), wider))
