# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs whose points are directions, which node trees of worlds are: their radiance is the material's emission."""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from . import _native
from .fingerprints import fingerprint
from .native_materials import build_material
from .native_textures import build_texture
from .scene_description import Image, Material
from .surface_inputs import RayBit

if TYPE_CHECKING:
    from numpy.typing import NDArray

_CAMERA, _DIFFUSE = (bit.bit_length() - 1 for bit in (RayBit.CAMERA, RayBit.DIFFUSE))
_built: WeakKeyDictionary[Material, _native.DirectionProgram] = WeakKeyDictionary()


def build_direction_program(material: Material) -> _native.DirectionProgram:
    """The same description gives the same native program. Raises InvalidInput, naming it."""
    if material not in _built:
        textures = [build_texture(use, []) for use in material.textures]
        _built[material] = _native.DirectionProgram(build_material(material, textures))
    return _built[material]


def radiance_towards(material: Material, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """What lights surfaces from unit directions (n, 3): (n, 3)."""
    program = build_direction_program(material)
    points = np.ascontiguousarray(directions, np.float32)
    values: NDArray[np.float32] = program.radiance(points, _DIFFUSE, _native.Progress())
    return values.astype(np.float64)


def baked(material: Material, width: int, height: int) -> Image:
    """An equirectangular image of what lights surfaces; its key tells what it shows."""
    key = baked_key(material, width, height)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = build_direction_program(material).image(width, height, _DIFFUSE, _native.Progress())
    return Image(key=key, name=material.name, pixels=pixels, is_srgb=False)


def baked_key(material: Material, width: int, height: int) -> str:
    """The key that such an image has."""
    return f"world {fingerprint(material).hex()} {width} x {height}"
