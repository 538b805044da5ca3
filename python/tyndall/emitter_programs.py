# SPDX-License-Identifier: GPL-3.0-or-later
"""What area lights show where their node trees vary over them: drawn once, as fine as it needs.

Lamps are in lamp_programs.py.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np

from . import _native
from .fingerprints import fingerprint
from .native_materials import build_material
from .native_textures import build_texture
from .scene_description import Code, Image, Material
from .surface_inputs import PointInput
from .surface_operations import is_known_without_point

if TYPE_CHECKING:
    from numpy.typing import NDArray

_FEWEST, _MOST = 256, 1024  #: Texels along a side of a pattern: where it starts, and as fine as it gets.
_MOST_OF_IMAGES = 2048  #: The same of images, which show their own texels; 48 MiB.
_TOLERANCE = 2e-3  #: Mean error of the colours between texels, of their mean, at which a picture is fine enough.
#: What these read is the same wherever the light stands.
_OF_PLACES_ON_IT = {Code.TEXTURE, Code.TEXTURE_ALPHA, Code.UV, Code.IMAGE_AT, Code.IMAGE_ALPHA_AT, Code.ENVIRONMENT_AT}
_OF_OBJECTS = {PointInput.OBJECT_COLOR, PointInput.OBJECT_ALPHA, PointInput.OBJECT_INDEX, PointInput.OBJECT_RANDOM}


@dataclass(frozen=True, kw_only=True)
class EmitterObject:
    """What Object Info says of a light."""

    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    pass_index: float = 0.0
    random: float = 0.0

    @property
    def numbers(self) -> list[float]:
        """As the native side takes them."""
        return [*self.color, self.pass_index, self.random]

    def key(self, material: Material) -> str:
        """Equal for lights that the material tells not apart by it."""
        reads = any(op.code is Code.INPUT and op.option in _OF_OBJECTS for op in material.program)
        return repr(self.numbers) if reads else ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Emitter:
    """A rectangle in its object's XY plane, around the origin, or the ellipse in it, that shines along -Z."""

    world_from_object: NDArray[np.float64]  #: (4, 4)
    size: tuple[float, float]  #: In the object's space.
    is_ellipse: bool = False
    is_object: bool = True  #: Its nodes know its object and UV coordinates: not up to 3.x.
    object: EmitterObject = field(default_factory=EmitterObject)


@dataclass(frozen=True)
class EmitterPicture:
    """Rows of the image run along the object's Y."""

    image: Image | None  #: None: it shines in its mean all over.
    mean: tuple[float, float, float]  #: Over the light; without signs, where it is below 0 in places.


class EmitterView(Protocol):
    """A material's emission on a light."""

    @property
    def key(self) -> str:
        """Equal for lights that show the same."""

    def picture(self, key: str) -> EmitterPicture:
        """Raises InvalidInput, naming the material."""


@dataclass(frozen=True, eq=False)
class FlatView:
    """On an area light."""

    material: Material
    emitter: Emitter

    @property
    def key(self) -> str:
        """Equal for lights that show the same."""
        return _key(self.material, self.emitter)

    def picture(self, key: str) -> EmitterPicture:
        """Raises InvalidInput, naming the material."""
        return _picture(self.material, self.emitter, key)


class EmitterPictures:
    """Keeps the last ones: a light that did not change is drawn once."""

    _MOST_BYTES = 256 << 20

    def __init__(self) -> None:
        self._kept: dict[str, EmitterPicture] = {}

    def find(self, view: EmitterView) -> EmitterPicture:
        """Raises InvalidInput, naming the material."""
        key = view.key
        found = self._kept.pop(key, None) or view.picture(key)
        self._kept[key] = found
        while len(self._kept) > 1 and self._byte_count() > self._MOST_BYTES:
            del self._kept[next(iter(self._kept))]
        return found

    def _byte_count(self) -> int:
        return sum(one.image.byte_count for one in self._kept.values() if one.image is not None)


def _key(material: Material, emitter: Emitter) -> str:
    stands_anywhere = all(
        op.code in _OF_PLACES_ON_IT
        or is_known_without_point(op)
        or (op.code is Code.INPUT and op.option == PointInput.PARAMETRIC)
        for op in material.program
    )
    place = b"" if stands_anywhere else emitter.world_from_object.tobytes() + repr(emitter.size).encode()
    return f"light {fingerprint(material).hex()} {place.hex()} {emitter.is_ellipse} {emitter.is_object}" + (
        emitter.object.key(material)
    )


def _picture(material: Material, emitter: Emitter, key: str) -> EmitterPicture:
    pixels = _drawn(material, emitter)
    if (pixels == pixels[0, 0]).all():
        red, green, blue = pixels[0, 0].astype(np.float64)
        return EmitterPicture(None, (float(red), float(green), float(blue)))
    mean = _mean(pixels, emitter)
    if emitter.is_ellipse:
        _fill_corners(pixels)
    texels = np.ones((*pixels.shape[:2], 4), np.float32)
    texels[..., :3] = pixels
    return EmitterPicture(Image(key=key, name=material.name, pixels=texels, is_srgb=False), mean)


def _drawn(material: Material, emitter: Emitter) -> NDArray[np.float32]:
    """Twice as fine until that shows nothing new: (height, width, 3)."""
    textures = [build_texture(use, []) for use in material.textures]
    program = _native.EmitterProgram(build_material(material, textures))
    place = emitter.world_from_object.astype(np.float32).ravel().tolist()

    def at(width: int, height: int) -> NDArray[np.float32]:
        pixels = program.image(
            place, emitter.size, emitter.is_object, emitter.object.numbers, width, height, _native.Progress()
        )
        return np.nan_to_num(pixels, nan=0.0, posinf=0.0, neginf=0.0)

    width, height, halvings = _first_size(material)
    pixels = at(width << halvings, height << halvings)
    for _ in range(halvings):
        pixels = 0.25 * (pixels[::2, ::2] + pixels[1::2, ::2] + pixels[::2, 1::2] + pixels[1::2, 1::2])
    while 2 * max(width, height) <= _MOST:
        width, height = 2 * width, 2 * height
        finer = at(width, height)
        apart = np.abs(_twice_as_fine(pixels) - finer)[1:-1, 1:-1]  # images that repeat jump at their borders
        if not apart.mean(dtype=np.float64) > _TOLERANCE * np.abs(finer).mean(dtype=np.float64):
            break
        pixels = finer
    return pixels


def _first_size(material: Material) -> tuple[int, int, int]:
    """Width and height that show the largest image's texels, and how often twice that must be halved to have them."""
    sizes = [use.image.shape[1::-1] for use in material.textures]
    width, height = max(sizes, key=max, default=(_FEWEST, _FEWEST))
    halvings = 0
    while max(width, height) > _MOST_OF_IMAGES:
        width, height, halvings = max(1, width // 2), max(1, height // 2), min(halvings + 1, 2)
    while max(width, height) < _FEWEST:
        width, height = 2 * width, 2 * height
    return int(width), int(height), halvings


def _twice_as_fine(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """As a bilinear look-up has it."""
    for axis in range(2):
        beside = np.pad(pixels, [(1, 1) if one == axis else (0, 0) for one in range(3)], mode="edge")
        count = pixels.shape[axis]
        before, after = (np.take(beside, range(first, first + count), axis=axis) for first in (0, 2))
        pairs = np.stack([0.75 * pixels + 0.25 * before, 0.75 * pixels + 0.25 * after], axis=axis + 1)
        shape = list(pixels.shape)
        shape[axis] *= 2
        pixels = pairs.reshape(shape)
    return pixels


def _distance_from_middle(shape: tuple[int, ...]) -> NDArray[np.float64]:
    """1 on the border of the ellipse that fills the picture."""
    y, x = ((np.arange(count) + 0.5) / count * 2.0 - 1.0 for count in shape[:2])
    return np.hypot(x[None, :], y[:, None])


def _mean(pixels: NDArray[np.float32], emitter: Emitter) -> tuple[float, float, float]:
    values = np.abs(pixels[_distance_from_middle(pixels.shape) <= 1.0] if emitter.is_ellipse else pixels)
    red, green, blue = values.reshape(-1, 3).mean(axis=0, dtype=np.float64)
    return float(red), float(green), float(blue)


def _fill_corners(pixels: NDArray[np.float32]) -> None:
    """What lies outside the ellipse makes the picture's mean that of the ellipse; not the texels on its border."""
    distance = _distance_from_middle(pixels.shape)
    inside, corners = distance <= 1.0, distance > 1.0 + 4.0 / min(pixels.shape[:2])
    if not corners.any():
        return
    whole = pixels[inside].mean(axis=0, dtype=np.float64) * distance.size
    missing = whole - pixels[~corners].sum(axis=0, dtype=np.float64)
    pixels[corners] = np.clip(missing / np.count_nonzero(corners), pixels.min(axis=(0, 1)), pixels.max(axis=(0, 1)))
