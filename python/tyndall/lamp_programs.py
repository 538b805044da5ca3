# SPDX-License-Identifier: GPL-3.0-or-later
"""What point and spot lights show where their node trees vary: drawn once, by the direction in which light leaves.

Texels stand on the lines of a grid, borders included: half the distance keeps the texels that there were, the first and
the last column show one longitude, and the first and the last row the poles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from .emitter_programs import EmitterObject, EmitterPicture
from .fingerprints import fingerprint
from .native_materials import build_material
from .native_textures import build_texture
from .scene_description import Code, Extension, Image, LightProjection, LightTexture, TextureUse
from .surface_inputs import ImageProjection, PointInput
from .surface_operations import OPERANDS, operand_count

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .scene_description import Material, SurfaceOp

    FloatArray = NDArray[np.float64]

_WIDEST_SLIDE_RAD = 1.1  #: Half a cone that a plane before the lamp holds without wasting most of its texels.
#: Rows of a sphere, and of a plane before a spot: at first, at most, and at most where images show their own texels.
_ROWS_OF_SPHERE, _ROWS_OF_SLIDE = (181, 721, 1441), (257, 1025, 2049)
_FEWEST_ROWS = 3
_TOLERANCE = 1e-3  #: Mean error of the colours between texels, of their mean, at which a picture is fine enough.
#: Of half the width, or of a turn: texels stand so far beside the lines of the grid, where patterns like to have their
#: seams. An IES file has nothing at the end of its angles, which nobody sees but who asks exactly there.
_ASIDE = 3e-6
_FROM_POLES = 2e-4  #: Of half a turn: nearer, single precision takes a direction for the pole's.
_TURNED = {PointInput.NORMAL, PointInput.TRUE_NORMAL, PointInput.INCOMING}  #: Directions in the world.
_FROM_TURNED = {PointInput.NORMAL_TO_OBJECT, PointInput.DIRECTION_TO_OBJECT}  #: Make them the object's.
#: Inputs that say the same however the lamp stands in the world.
_OWN = {PointInput.OBJECT_NORMAL, PointInput.PARAMETRIC, *_FROM_TURNED}
_OF_PLACES = {  #: Inputs that change where it is moved.
    PointInput.POSITION, PointInput.OBJECT_LOCATION, PointInput.POINT_TO_WORLD, PointInput.POINT_TO_OBJECT,
}  # fmt: skip
#: Inputs that ask for nothing of its object.
_OF_WORLD = {*_TURNED, PointInput.POSITION, PointInput.REFLECTION}
_NORMALS = {PointInput.NORMAL, PointInput.TRUE_NORMAL, PointInput.OBJECT_NORMAL}
_PLACES = {PointInput.POSITION, PointInput.OBJECT_POSITION}
_OF_BOTH = {Code.FRESNEL, Code.LAYER_WEIGHT}
_IMAGES_AT_VECTORS = {Code.IMAGE_AT, Code.IMAGE_ALPHA_AT}


@dataclass(frozen=True, kw_only=True, eq=False)
class Lamp:
    """It shines along -Z of its object; ``spot_half_angle_rad``: only so far from there."""

    world_from_object: FloatArray  #: (4, 4)
    radius_m: float = 0.0  #: Of a ball whose points each have a normal; 0: of a point, or of a disc that faces all.
    spot_half_angle_rad: float | None = None
    #: Its nodes know its object, and its scale shapes its cone: not up to 3.x.
    is_object: bool = True
    object: EmitterObject = field(default_factory=EmitterObject)


@dataclass(frozen=True)
class Vectors:
    """Which of two vectors a program reads, that only differ on a ball."""

    has_normal: bool
    has_direction: bool
    has_place: bool  #: Where the point lies, which the normal tells.


def vectors_of(material: Material, lamp: Lamp) -> Vectors:
    """What the emission of a material asks of each point of a lamp."""
    inputs = _inputs(material)
    has_both = PointInput.REFLECTION in inputs or any(op.code in _OF_BOTH for op in material.program)
    has_box = any(op.code in _IMAGES_AT_VECTORS and op.option == ImageProjection.BOX for op in material.program)
    # A spot's places on UV maps are thrown by the direction, a point light's lie around its ball.
    uvs_are_normals = lamp.spot_half_angle_rad is None or not lamp.is_object
    reads_uvs, has_place = _reads_uvs(material), bool(inputs & _PLACES)
    return Vectors(
        has_normal=has_both
        or has_box
        or (has_place and lamp.radius_m > 0.0)
        or bool(inputs & _NORMALS)
        or (reads_uvs and uvs_are_normals),
        has_direction=has_both or PointInput.INCOMING in inputs or (reads_uvs and not uvs_are_normals),
        has_place=has_place,
    )


def colour_of_sun(material: Material, sun: Lamp) -> FloatArray:
    """Its shader stands one metre along its light, wherever it shines, and in the middle of all UV maps: (3,)."""
    matrix = np.array(sun.world_from_object, np.float64)
    direction = -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    point = np.concatenate([direction, np.full(2, 0.5 if sun.is_object else 0.0), [0.5, 0.0]])
    colours = _leaving(_program(material), replace(sun, radius_m=1.0), matrix, np.zeros(3), point[None, :])
    colour: FloatArray = colours[0].astype(np.float64)
    return colour


class LampView:
    """A material's emission on a lamp, and the axes in which it is drawn.

    What turns with the lamp is drawn as if the lamp stood upright, and is the same however it stands.
    """

    def __init__(self, material: Material, lamp: Lamp) -> None:
        self._material, self._lamp = material, lamp
        vectors = vectors_of(material, lamp)
        self._varies = vectors.has_direction or vectors.has_normal
        self._follows_normal = vectors.has_normal and not vectors.has_direction
        is_ball = self._follows_normal and lamp.radius_m > 0.0
        self._half_cone_rad = None if is_ball else lamp.spot_half_angle_rad  # its normals point everywhere
        matrix = np.array(lamp.world_from_object, np.float64)
        linear, shape = matrix[:3, :3], _shape(matrix[:3, :3])
        turn = linear @ np.linalg.inv(shape)
        is_cone_scaled = self._half_cone_rad is not None and lamp.is_object
        if _turns_with_lamp(material, lamp):
            self._scene_from_object, turn_left = shape, np.eye(3)
            axes_from_world = turn.T
        else:
            keeps_matrix = is_cone_scaled or _reads_uvs(material) or not _inputs(material) <= _OF_WORLD
            self._scene_from_object, turn_left = linear if keeps_matrix else np.eye(3), turn
            axes_from_world = np.eye(3)
        self._place = matrix[:3, 3] if _inputs(material) & _OF_PLACES else np.zeros(3)
        self._directions_from_axes = np.eye(3)
        if is_cone_scaled:
            self._directions_from_axes = self._scene_from_object
            axes_from_world = np.linalg.inv(linear)
        elif self._half_cone_rad is not None:
            self._directions_from_axes = turn_left
            axes_from_world = turn.T
        self._axes_from_world = axes_from_world

    @property
    def key(self) -> str:
        """Equal for lamps that show the same."""
        parts = (self._scene_from_object, self._place, self._directions_from_axes)
        place = b"".join(np.ascontiguousarray(part, np.float32).tobytes() for part in parts).hex()
        lamp = (self._lamp.radius_m, self._half_cone_rad, self._lamp.spot_half_angle_rad, self._lamp.is_object)
        shown = fingerprint(replace(self._material, name="")).hex()  # lamps of many names share a luminaire's picture
        return f"lamp {shown} {place} {lamp} {self._lamp.object.key(self._material)}"

    def picture(self, key: str) -> EmitterPicture:
        """Raises InvalidInput, naming the material."""
        pixels = self._drawn() if self._varies else self._at(_program(self._material), _FEWEST_ROWS)
        if (pixels == pixels[0, 0]).all():
            red, green, blue = pixels[0, 0].astype(np.float64)
            return EmitterPicture(None, (float(red), float(green), float(blue)))
        weights = self._weights(len(pixels))
        mean = (np.abs(pixels) * weights[..., None]).sum(axis=(0, 1), dtype=np.float64) / weights.sum()
        texels = np.ones((*pixels.shape[:2], 4), np.float32)
        texels[..., :3] = pixels
        image = Image(key=key, name=self._material.name, pixels=texels, is_srgb=False)
        return EmitterPicture(image, (float(mean[0]), float(mean[1]), float(mean[2])))

    def texture(self, picture: EmitterPicture) -> LightTexture | None:
        """Of mean 1: the lamp's strength has the picture's mean. None: it shines alike everywhere."""
        if picture.image is None:
            return None
        rows, columns = picture.image.pixels.shape[:2]
        place_from_axes = np.eye(3, 4)
        if self._is_slide:
            half_cotangent = 0.5 / math.tan(self._half_cone_rad or 0.0)
            place_from_axes = np.array([[half_cotangent, 0, -0.5, 0], [0, half_cotangent, -0.5, 0], [0, 0, -1, 0]])
        u, v = (columns - 1) / columns, (rows - 1) / rows / self._share_of_rows
        return LightTexture(
            use=TextureUse(image=picture.image, extension=Extension.EXTEND),
            projection=LightProjection.PERSPECTIVE if self._is_slide else LightProjection.DIRECTIONS,
            follows_normal=self._follows_normal,
            axes_from_world=self._axes_from_world,
            place_from_axes=place_from_axes,
            uv_from_projected=np.array([[u, 0, 0.5 / columns], [0, v, 0.5 / rows], [0, 0, 1]]),
            gain=np.diag([1.0 / mean if mean else 0.0 for mean in picture.mean]),
        )

    @property
    def _is_slide(self) -> bool:
        return self._half_cone_rad is not None and self._half_cone_rad <= _WIDEST_SLIDE_RAD

    @property
    def _share_of_rows(self) -> float:
        """How much of a sphere's latitudes is drawn, from the one pole on to which the lamp shines."""
        return 1.0 if self._half_cone_rad is None or self._is_slide else min(self._half_cone_rad / math.pi, 1.0)

    def _drawn(self) -> NDArray[np.float32]:
        """With twice the rows until these show nothing new: (rows, columns, 3)."""
        program = _program(self._material)
        first, most, most_of_images = _ROWS_OF_SLIDE if self._is_slide else _ROWS_OF_SPHERE
        of_images = max((max(use.image.shape[:2]) for use in self._material.textures), default=0)
        while first < min(of_images, most_of_images):
            first = 2 * first - 1
        pixels = self._at(program, first)
        while 2 * len(pixels) - 1 <= max(most, first) and not (pixels == pixels[0, 0]).all():
            coarse, pixels = pixels, self._at(program, 2 * len(pixels) - 1)
            weights = self._weights(len(pixels))[..., None]
            between = _with_middles(coarse)
            between -= pixels
            np.abs(between, out=between)
            apart = (between * weights).sum(dtype=np.float64)
            if not apart > _TOLERANCE * (np.abs(pixels) * weights).sum(dtype=np.float64):
                break
        return pixels

    def _at(self, program: _native.EmitterProgram, rows: int) -> NDArray[np.float32]:
        axes = self._axes(rows)
        directions = axes.reshape(-1, 3) @ self._directions_from_axes.T
        directions /= _lengths(directions)[:, None]
        points = np.zeros((len(directions), 7), np.float32)
        points[:, :3] = directions
        if _reads_uvs(self._material):
            points[:, 3:5], points[:, 5:] = self._places(directions)
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self._scene_from_object, self._place
        return _leaving(program, self._lamp, matrix, self._place, points).reshape(axes.shape)

    def _axes(self, rows: int) -> FloatArray:
        """Of each texel a vector along the axes: (rows, columns, 3)."""
        if self._is_slide:
            across = (np.linspace(-1.0, 1.0, rows) + _ASIDE) * math.tan(self._half_cone_rad or 0.0)
            x, y = np.meshgrid(across, across)
            return np.stack([x, y, np.full_like(x, -1.0)], axis=-1)
        longitude = (0.5 - _ASIDE - np.linspace(0.0, 1.0, 2 * rows - 1)) * 2.0 * math.pi
        latitude = self._latitudes(rows)[:, None]
        axes = np.empty((rows, 2 * rows - 1, 3))
        axes[..., 0], axes[..., 1] = np.cos(latitude) * np.sin(longitude), np.cos(latitude) * np.cos(longitude)
        axes[..., 2] = np.sin(latitude)
        return axes

    def _latitudes(self, rows: int) -> FloatArray:
        share = np.clip(np.linspace(0.0, self._share_of_rows, rows) + _ASIDE, _FROM_POLES, 1.0 - _FROM_POLES)
        return np.asarray((share - 0.5) * math.pi, np.float64)

    def _weights(self, rows: int) -> FloatArray:
        """The solid angle of each texel within the cone, times a constant: (rows, columns)."""
        if not self._is_slide:
            return np.broadcast_to(np.maximum(np.cos(self._latitudes(rows)), 0.0)[:, None], (rows, 2 * rows - 1))
        lengths = _lengths(self._axes(rows))
        is_inside = lengths * math.cos(self._half_cone_rad or 0.0) <= 1.0 + 1e-9
        weights: FloatArray = np.where(is_inside, lengths**-3.0, 0.0)
        return weights

    def _places(self, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """On UV maps, and as barycentrics, of which Geometry's Parametric is made: (n, 2) each."""
        if not self._lamp.is_object:
            return np.zeros((len(directions), 2)), _on_sphere(directions)
        local = directions @ np.linalg.inv(self._scene_from_object).T
        uv = _on_sphere(local)
        if self._lamp.spot_half_angle_rad is not None:
            with np.errstate(all="ignore"):
                cotangent = 1.0 / math.tan(self._lamp.spot_half_angle_rad)
                uv = np.nan_to_num(0.5 - 0.5 * cotangent * local[:, :2] / local[:, 2:], posinf=0.0, neginf=0.0)
        return uv, np.stack([uv[:, 1], 1.0 - uv[:, 0] - uv[:, 1]], axis=1)


def _program(material: Material) -> _native.EmitterProgram:
    return _native.EmitterProgram(build_material(material, [build_texture(use, []) for use in material.textures]))


def _leaving(
    program: _native.EmitterProgram, lamp: Lamp, matrix: FloatArray, middle: FloatArray, points: NDArray[Any]
) -> NDArray[np.float32]:
    """Colours at points of native/shading/emitter_program.hpp, (n, 7): (n, 3)."""
    place = matrix.astype(np.float32).ravel().tolist()
    colours: NDArray[np.float32] = program.leaving(
        place,
        tuple(middle),
        lamp.radius_m,
        lamp.object.numbers,
        np.ascontiguousarray(points, np.float32),
        _native.Progress(),
    )
    return np.nan_to_num(colours, nan=0.0, posinf=0.0, neginf=0.0)


def _inputs(material: Material) -> set[PointInput]:
    return {PointInput(op.option) for op in material.program if op.code is Code.INPUT}


def _reads_uvs(material: Material) -> bool:
    return PointInput.PARAMETRIC in _inputs(material) or bool(material.uv_maps)


def _turns_with_lamp(material: Material, lamp: Lamp) -> bool:
    """Whether it shows the same, along the lamp's axes, however the lamp is turned."""
    if _reads_uvs(material) and not lamp.is_object:
        return False
    in_world = set[int]()  # registers
    for op in material.program:
        option = PointInput(op.option) if op.code is Code.INPUT else None
        if option not in _FROM_TURNED and in_world.intersection(_read_by(op)):
            return False
        in_world.discard(op.out)
        if option in _TURNED:
            in_world.add(op.out)
        elif option is not None and option not in _OWN:
            return False
    return material.emission_register not in in_world


def _read_by(op: SurfaceOp) -> list[int]:
    return [getattr(op, operand) for operand in OPERANDS[: operand_count(op)]]


def _shape(linear: FloatArray) -> FloatArray:
    """The lower triangle that scales and shears as a matrix does, without its turn: its Z stays along Z.

    The same to the last bit for all turns, as far as single precision tells them apart.
    """
    lengths = _lengths(linear.T)
    units = 10.0 ** np.floor(np.log10(lengths))
    cosines = np.round((linear / lengths).T @ (linear / lengths), 6) + 0.0  # no negative zeros
    try:
        upside_down = np.linalg.cholesky(cosines[::-1, ::-1])
    except np.linalg.LinAlgError:  # sheared flat: it is drawn as it stands
        return linear
    shape: FloatArray = upside_down[::-1, ::-1].T * (np.round(lengths / units, 5) * units) + 0.0
    return shape


def _lengths(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=-1), np.float64)


def _on_sphere(vectors: FloatArray) -> FloatArray:
    """As Cycles' map_to_sphere: longitude and latitude, each from 0 to 1."""
    x, y, z = vectors.T
    return np.stack([0.5 - np.arctan2(x, y) / (2.0 * math.pi), 0.5 + np.arctan2(z, np.hypot(x, y)) / math.pi], axis=1)


def _with_middles(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """What a bilinear look-up has between rows and columns, too."""
    for axis in range(2):
        shape = list(pixels.shape)
        shape[axis] = 2 * shape[axis] - 1
        finer = np.empty(shape, np.float32)
        along = np.moveaxis(finer, axis, 0)
        known = np.moveaxis(pixels, axis, 0)
        along[::2], along[1::2] = known, 0.5 * (known[1:] + known[:-1])
        pixels = finer
    return pixels
