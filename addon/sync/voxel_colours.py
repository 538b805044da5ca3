# SPDX-License-Identifier: GPL-3.0-or-later
"""What voxels of a surface keep of its material: colour, gloss, metal and glow, as numbers or as pictures.

A material's pictures lie on the surface in one way: nodes between an image and a shader change its texels, exactly but
for what lies between them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tyndall.scene_description import Extension, Material

from .materials import COLOUR
from .program import BLACK, WHITE, Program
from .surface_values import (
    PICTURES,
    Parts,
    colour_per_weight,
    diffuse_radiance,
    number_per_weight,
    parts_of,
    reads_more,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tyndall.scene_description import SurfaceOp

    from .reports import Reports
    from .surface_values import Read

EMISSION, METALLIC = "emission", "metallic"
_SAME = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
_LUMINANCE = np.array((0.2126729, 0.7151522, 0.0721750))  #: Of Rec. 709.


class Glow(NamedTuple):
    """What voxels radiate whose emission is 1."""

    strength: float
    #: Its largest is 1; None: the colours of voxels that glow, which are then not those of their surface.
    hue: tuple[float, float, float] | None


DARK = Glow(0.0, (1.0, 1.0, 1.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Colouring:
    """How a material looks on voxels."""

    parts: Parts  #: Of the colour.
    channels: Mapping[str, Parts] = field(default_factory=dict)
    #: As MaterialReader.channels has them, where they vary in a way that neither texels nor corners have; all but
    #: emission.
    programs: Mapping[str, Material] = field(default_factory=dict)
    #: What it emits, (height, width, 3).
    glow: NDArray[np.floating[Any]] = field(default_factory=lambda: np.zeros((1, 1, 3)))
    extension: Extension = Extension.REPEAT
    uv_map: str = ""  #: "" is the active one.
    uv_matrix: tuple[float, ...] = _SAME  #: 3x3, row by row, applied to (u, v, 1).

    @property
    def texels(self) -> NDArray[np.float32]:
        """Of the colour, (height, width, 3)."""
        return self.parts.texels

    @property
    def is_picture(self) -> bool:
        return any(one.texels.shape[:2] != (1, 1) for one in (self.parts, *self.channels.values()))

    def placed(self, uvs: NDArray[np.float32]) -> NDArray[np.float32]:
        """Where pictures are read for these coordinates, (n, 3, 2)."""
        matrix = np.array(self.uv_matrix).reshape(3, 3)
        points = np.concatenate([uvs, np.ones((*uvs.shape[:2], 1))], axis=2) @ matrix.T
        placed: NDArray[np.float32] = (points[..., :2] / points[..., 2:]).astype(np.float32)
        return placed


def colouring_of(colour: Material, channels: Mapping[str, Material], reports: Reports) -> Colouring:
    """``colour`` and ``channels``: as MaterialReader.channels has them; of emission, luminance, however bright."""
    parts = parts_of(colour, colour_per_weight)
    of_channels = {
        name: parts_of(one, _luminance if name == EMISSION else number_per_weight) for name, one in channels.items()
    }
    programs = {COLOUR: colour, **channels}
    places = [_place(op, one) for one in programs.values() for op in one.program if op.code in PICTURES]
    are_simple = {
        name: found.is_exact and not reads_more(programs[name])
        for name, found in {COLOUR: parts, **of_channels}.items()
    }
    programs.pop(EMISSION, None)
    if not are_simple.pop(EMISSION, True):
        told = "its glow is, on voxels, pictures times colour attributes; what else its nodes read is half grey"
        reports.add(f'Material "{colour.name}"', told)
    varies = len(set(places)) > 1 or not all(are_simple.values())
    glow: NDArray[np.floating[Any]] = np.zeros((1, 1, 3))
    if EMISSION in channels:
        glow = parts_of(channels[EMISSION], diffuse_radiance).texels
    uv_map, uv_matrix, extension = places[0] if places else ("", _SAME, Extension.REPEAT)
    return Colouring(
        parts=parts,
        channels=of_channels,
        programs=programs if varies else {},
        glow=glow,
        extension=extension,
        uv_map=uv_map,
        uv_matrix=uv_matrix,
    )


def plain_colouring() -> Colouring:
    """Of a mesh without a material: its active colour attribute."""
    program = Program()
    material = program.material("no material", (program.attribute(""), WHITE, BLACK))
    return Colouring(parts=parts_of(material, colour_per_weight))


def may_be_above_zero(number: Material) -> bool:
    """As MaterialReader.channels has it."""
    return bool(number.program) or number.diffuse[0] > 0.0


def luminance(radiance: NDArray[Any]) -> NDArray[Any]:
    """(..., 1) of (..., 3)."""
    weighted: NDArray[Any] = (radiance @ _LUMINANCE)[..., None]
    return weighted


def _luminance(material: Material, read: Read) -> NDArray[Any]:
    return luminance(diffuse_radiance(material, read))


def _place(op: SurfaceOp, material: Material) -> tuple[str, tuple[float, ...], Extension]:
    return material.uv_maps[op.uv_map], op.uv_matrix, material.textures[op.texture].extension
