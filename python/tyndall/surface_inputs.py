# SPDX-License-Identifier: GPL-3.0-or-later
"""What surface programs may read of a point: options of operations, as native/shading/op_*.hpp number them."""

from __future__ import annotations

from enum import IntEnum


class PointInput(IntEnum):
    """SurfaceOp.option of Code.INPUT; from DIRECTION_TO_WORLD on it reads an operand."""

    POSITION = 0
    NORMAL = 1
    TRUE_NORMAL = 2
    INCOMING = 3
    PARAMETRIC = 4
    OBJECT_POSITION = 5
    OBJECT_NORMAL = 6
    REFLECTION = 7
    OBJECT_LOCATION = 8
    OBJECT_COLOR = 9
    OBJECT_ALPHA = 10
    OBJECT_INDEX = 11
    OBJECT_RANDOM = 12
    RAY_LENGTH = 13
    IS_RAY = 14  #: By the bits of its selector, see RayBit.
    EDGE_DISTANCE = 15
    PIXEL_WIDTH = 16
    PARTICLE_INDEX = 17
    PARTICLE_RANDOM = 18
    PARTICLE_AGE = 19
    PARTICLE_LIFETIME = 20
    PARTICLE_SIZE = 21
    PARTICLE_LOCATION = 22
    PARTICLE_VELOCITY = 23
    PARTICLE_ANGULAR_VELOCITY = 24
    INSTANCER_COLOR = 25  #: Of the value whose number is its selector.
    INSTANCER_ALPHA = 26
    PASSED_COUNT = 27  #: Of transparent surfaces, on the ray's whole way.
    DIRECTION_TO_WORLD = 32
    DIRECTION_TO_OBJECT = 33
    POINT_TO_WORLD = 34
    POINT_TO_OBJECT = 35
    NORMAL_TO_WORLD = 36
    NORMAL_TO_OBJECT = 37
    TANGENT = 38


class RayBit(IntEnum):
    """Of the kinds of rays that ask."""

    CAMERA = 1
    SHADOW = 2
    DIFFUSE = 4
    GLOSSY = 8
    MIRROR = 16
    TRANSMISSION = 32
    SCATTER = 64


class NormalSpace(IntEnum):
    """SurfaceOp.option of Code.NORMAL_MAP."""

    TANGENT = 0
    OBJECT = 1
    WORLD = 2
    BLENDER_OBJECT = 3
    BLENDER_WORLD = 4
    UNIT = 5
    VALID_SPECULAR = 6


STRENGTH_MIXES_NORMALS = 1  #: SurfaceOp.selector of Code.NORMAL_MAP.
BUMP_IS_INVERTED, BUMP_IS_VALID_SPECULAR = 1, 2  #: SurfaceOp.selector of Code.BUMP.
OCCLUSION_IS_INSIDE, OCCLUSION_IS_ONLY_LOCAL = 1, 2  #: SurfaceOp.option of Code.AMBIENT_OCCLUSION.


class ImageProjection(IntEnum):
    """SurfaceOp.option of Code.IMAGE_AT and Code.IMAGE_ALPHA_AT."""

    FLAT = 0
    BOX = 1
    SPHERE = 2
    TUBE = 3


class EnvironmentProjection(IntEnum):
    """SurfaceOp.option of Code.ENVIRONMENT_AT."""

    EQUIRECTANGULAR = 0
    MIRROR_BALL = 1


IMAGE_HAS_TILES = 1  #: SurfaceOp.selector of Code.IMAGE_AT and Code.IMAGE_ALPHA_AT.
