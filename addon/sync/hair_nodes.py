# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of hair shaders, which are drawn as diffuse.

Based on: Chiang et al., A Practical and Controllable Hair and Fur Model for Production Path Tracing, 2016 (colour of
many hairs by their absorption, equation 9, and its inverse); d'Eon et al., An Energy-Conserving Hair Reflectance Model,
2011 (absorption of melanin); Cycles (how much melanin a share of it is).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .program import WHITE, Value

if TYPE_CHECKING:
    from .node_graph import Socket
    from .value_nodes import ValueReader

_EUMELANIN, _PHEOMELANIN = np.array((0.506, 0.841, 1.653)), np.array((0.343, 0.733, 1.924))
_ROUGHNESS = (0.245, 5.574, -10.73, 2.532, -0.215, 5.969)  #: Of a fit, its highest power first.


def principled_hair_colour(reader: ValueReader, at: Socket) -> Value:
    """Of many hairs together: what Direct Coloring asks for, and what follows from melanin or an absorption."""
    kind = at.node.parametrization
    if kind == "COLOR":
        return reader.colour(at.input("Color"))
    fit = float(np.polyval(_ROUGHNESS, reader.constant(at.input("Radial Roughness"), 0.3)))
    if kind == "ABSORPTION":
        absorption = np.array(reader.constant_colour(at.input("Absorption Coefficient")))
    else:
        melanin = -math.log(max(1.0 - reader.constant(at.input("Melanin")), 1e-4))
        redness = reader.constant(at.input("Melanin Redness"))
        tint = np.maximum(reader.constant_colour(at.input("Tint"), WHITE), 1e-6)
        absorption = melanin * ((1.0 - redness) * _EUMELANIN + redness * _PHEOMELANIN) + (np.log(tint) / fit) ** 2
    red, green, blue = np.exp(-np.sqrt(np.maximum(absorption, 0.0)) * fit)
    return float(red), float(green), float(blue)
