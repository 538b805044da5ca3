# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of suns, point and spot lights: one image, where it enters linearly, or a picture of all they show.

What a lamp's shader sees was measured in 3.4.1, 4.5.15 and 5.0.1: it stands where the lamp does, or on its ball; its
normal and the ray that asks both point to where the light goes. Up to 3.x the lamp is an object to normals alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.lamp_programs import Lamp, LampView, colour_of_sun, vectors_of
from tyndall.scene_description import Code, LightProjection, LightTexture
from tyndall.surface_inputs import PointInput

from .affine_colours import AffineColour, affine_colour
from .coordinates import point_input
from .emitter_nodes import IS_OBJECT, NODES, EmitterReader
from .light_nodes import NO_DISTANCE, Distance, at_distances, emission_and_distance
from .light_textures import LightValueReader
from .light_vectors import CannotBeRead
from .node_graph import output_input
from .program import BLACK, WHITE, Program, Term, Value
from .reports import Reports

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tyndall.emitter_programs import EmitterObject, EmitterPictures

    from .emitter_nodes import Read
    from .images import ImageReader
    from .node_graph import Socket


class _LampReader(EmitterReader):
    def place(self) -> Value:
        """Up to 3.x no space but the world's."""
        return point_input(self.program, PointInput.OBJECT_POSITION if IS_OBJECT else PointInput.POSITION)


def _geometry(_: EmitterReader, at: Socket) -> Value | None:
    return BLACK if at.socket.identifier in {"Backfacing", "Tangent", "Pointiness", "Random Per Island"} else None


def _texture_coordinate(reader: EmitterReader, at: Socket) -> Value | None:
    output = at.socket.identifier
    if output == "Generated" or (output == "Object" and at.node.object is None):
        return reader.place()
    return None


def _vector_transform(reader: EmitterReader, at: Socket) -> Value | None:
    """Up to 3.x the object's space is the world's."""
    spaces = {at.node.convert_from, at.node.convert_to}
    return reader.colour(at.input("Vector")) if not IS_OBJECT and "CAMERA" not in spaces else None


_NODES: dict[str, Read] = {
    **NODES,
    "NEW_GEOMETRY": _geometry,
    "TEX_COORD": _texture_coordinate,
    "VECT_TRANSFORM": _vector_transform,
}


@dataclass(frozen=True)
class LampEmission:
    """What a lamp's nodes multiply its strength by."""

    light: bpy.types.Light
    culprit: str
    reports: Reports
    #: One image, read where its reader knows; None: the program.
    image: tuple[AffineColour, LightValueReader] | None = None
    program: Program | None = None
    value: Value = BLACK
    distance: Distance = NO_DISTANCE

    @property
    def is_constant(self) -> bool:
        return self.image[0].texture is None if self.image is not None else not isinstance(self.value, Term)

    def on(
        self, world_from_light: NDArray[np.float64], seen_as: EmitterObject, pictures: EmitterPictures
    ) -> tuple[NDArray[np.float64], LightTexture | None]:
        """Of one instance: a colour, and what varies around it."""
        if self.image is not None:
            colour, reader = self.image
            texture = reader.texture(colour, world_from_light)
            return colour.offset if texture is None else np.ones(3), texture
        if self.program is None or not isinstance(self.value, Term):
            return np.array(self.value, np.float64), None
        if not (np.isfinite(world_from_light).all() and abs(np.linalg.det(world_from_light[:3, :3])) > 0.0):
            return np.ones(3), None  # a lamp of no scale, which is refused
        value, factor = _without_factors(self.program, self.value)
        material = self.program.material(self.light.name, (BLACK, BLACK, value))
        lamp = self._lamp(world_from_light, seen_as)
        if self.light.type == "SUN":
            if material.textures:
                self.reports.add(
                    self.culprit, "its nodes see no position on a sun: an image shows one place, its gobo all"
                )
            return factor * colour_of_sun(material, lamp), None
        vectors = vectors_of(material, lamp)
        if lamp.radius_m > 0.0 and vectors.has_normal and vectors.has_direction:
            self.reports.add(self.culprit, "its nodes read its normal and the direction of its light: both are that")
        if self.light.shadow_soft_size > 0.0 and lamp.radius_m == 0.0 and vectors.has_place:
            self.reports.add(self.culprit, "its nodes see it at its middle alone")
        view = LampView(material, lamp)
        picture = pictures.find(view)
        return factor * picture.mean, view.texture(picture)

    def _lamp(self, world_from_light: NDArray[np.float64], seen_as: EmitterObject) -> Lamp:
        light = self.light
        is_ball = IS_OBJECT and light.type != "SUN" and not getattr(light, "use_soft_falloff", False)
        return Lamp(
            world_from_object=world_from_light,
            radius_m=light.shadow_soft_size if is_ball else 0.0,
            spot_half_angle_rad=light.spot_size / 2 if light.type == "SPOT" else None,
            is_object=IS_OBJECT,
            object=seen_as,
        )


def _without_factors(program: Program, value: Term) -> tuple[Term, NDArray[np.float64]]:
    """What is to be drawn, and a colour that multiplies it: strengths and tints change no picture."""
    factor = np.ones(3)
    op = program.ops[value.place]
    while op.code is Code.MULTIPLY:
        first, second = program.ops[op.a], program.ops[op.b]
        constant, place = (first, op.b) if first.code is Code.CONSTANT else (second, op.a)
        if constant.code is not Code.CONSTANT or not min(constant.value) > 0.0:
            break
        factor, value = factor * constant.value, Term(place)
        op = program.ops[place]
    return value, factor


def read_lamp_emission(light: bpy.types.Light, images: ImageReader, reports: Reports, culprit: str) -> LampEmission:
    tree = light.node_tree if light.use_nodes else None
    surface = output_input(tree, "Surface")
    if surface is None:  # nodes without an output send nothing, as in Cycles
        return LampEmission(light, culprit, reports, program=Program(), value=WHITE if tree is None else BLACK)
    said = Reports()
    linear = LightValueReader(light, culprit, said, images)
    try:
        value, distance = emission_and_distance(linear, surface)
        colour = affine_colour(linear.program, value)
    except CannotBeRead:
        colour = None
    if colour is not None:
        reports.include(said)
        return LampEmission(light, culprit, reports, image=(colour, linear), distance=distance)
    reader = _LampReader(culprit, "a lamp", _NODES, reports, images)
    value, distance = emission_and_distance(reader, surface)
    return LampEmission(light, culprit, reports, program=reader.program, value=value, distance=distance)


def lamp_at_distances(texture: LightTexture | None, lamp: LampEmission) -> LightTexture | None:
    """Of a lamp or a sun, which does not fall off."""
    if lamp.light.type != "SUN":
        return at_distances(texture, lamp.distance, LightProjection.DIRECTIONS)
    if lamp.distance != NO_DISTANCE and not IS_OBJECT:  # later versions leave it as it is
        lamp.reports.add(lamp.culprit, "its falloff, which is without bounds in Cycles 3.x, is left out")
    return texture
