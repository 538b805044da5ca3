# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of area lights: their points lie on the light, and are seen from straight before it.

What Cycles' shader knows there was measured in 3.4.1, 4.5.15 and 5.0.1. Up to 3.x the light is no object to it: object
coordinates are the world's, and UV coordinates 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.emitter_programs import Emitter, EmitterObject, EmitterPicture, EmitterPictures, FlatView
from tyndall.scene_description import Code, Extension, LightProjection, LightTexture, TextureUse
from tyndall.surface_inputs import ImageProjection, PointInput

from .coordinates import point_input
from .emitter_nodes import IS_OBJECT, NODES, EmitterReader
from .light_nodes import NO_DISTANCE, Distance, emission_and_distance
from .light_textures import gobo_use
from .node_graph import output_input
from .program import BLACK, WHITE, Program, Term, Value, grey

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .emitter_nodes import Read
    from .images import ImageReader
    from .node_graph import Socket
    from .reports import Reports


def _by_direction(reader: EmitterReader, at: Socket) -> None:
    reader.note(f"{at.node.bl_label} {at.socket.name} is read as seen from straight before the light")


def _geometry(reader: EmitterReader, at: Socket) -> Value | None:
    if at.socket.identifier in {"Backfacing", "Tangent"}:
        return BLACK
    if at.socket.identifier == "Incoming":
        _by_direction(reader, at)
    return None


def _texture_coordinate(reader: EmitterReader, at: Socket) -> Value | None:
    if at.socket.identifier == "Generated":
        return reader.place()
    if at.socket.identifier == "Reflection":
        _by_direction(reader, at)
    return None


def _ies(reader: EmitterReader, at: Socket) -> None:
    vector = at.input("Vector")
    if vector is None or not vector.is_connected():
        reader.note(f"{at.node.bl_label} is read as seen from straight before the light")


_NODES: dict[str, Read] = {
    **NODES,
    **dict.fromkeys(("FRESNEL", "LAYER_WEIGHT"), _by_direction),
    "NEW_GEOMETRY": _geometry,
    "TEX_IES": _ies,
    "TEX_COORD": _texture_coordinate,
}


@dataclass(frozen=True)
class AreaEmission:
    """What an area light's nodes, and its gobo, multiply its strength by, over its surface."""

    name: str
    program: Program
    value: Value
    distance: Distance

    def on(self, emitter: Emitter, pictures: EmitterPictures) -> EmitterPicture:
        """One instance of it."""
        if not isinstance(self.value, Term):
            return EmitterPicture(None, self.value)
        return pictures.find(FlatView(self.program.material(self.name, (BLACK, BLACK, self.value)), emitter))


def read_area_emission(light: bpy.types.AreaLight, images: ImageReader, reports: Reports, culprit: str) -> AreaEmission:
    reader = EmitterReader(culprit, "an area light", _NODES, reports, images)
    tree = light.node_tree if light.use_nodes else None
    surface = output_input(tree, "Surface")
    value: Value = WHITE if tree is None else BLACK  # nodes without an output send nothing, as in Cycles
    distance = NO_DISTANCE
    if surface is not None:
        value, distance = emission_and_distance(reader, surface)
    gobo = gobo_use(light, images, reports, culprit)
    if gobo is not None:
        if isinstance(value, Term):
            reports.add(culprit, "its gobo takes the place of its nodes' pattern")
            value = WHITE
        value = reader.program.multiply(value, _gobo_value(reader.program, gobo, light.tyndall.gobo_strength))
    return AreaEmission(light.name, reader.program, value, distance)


def _gobo_value(program: Program, use: TextureUse, share: float) -> Value:
    place = point_input(program, PointInput.PARAMETRIC)  # which all versions have
    option = int(ImageProjection.FLAT)
    shown = program.operation(Code.IMAGE_AT, place, option=option, texture=program.texture_index(use))
    return program.mix(WHITE, shown, grey(share))


def emitter_of(
    world_from_light: NDArray[np.float64], size_m: tuple[float, float], seen_as: EmitterObject, *, is_ellipse: bool
) -> Emitter:
    return Emitter(
        world_from_object=world_from_light, size=size_m, is_ellipse=is_ellipse, is_object=IS_OBJECT, object=seen_as
    )


def emitter_texture(picture: EmitterPicture, world_from_light: NDArray[np.float64]) -> LightTexture | None:
    """Of mean 1: the light's strength has the picture's mean. None: it shines alike all over."""
    if picture.image is None:
        return None
    # Our axes are right-handed; those of a mirrored light are not.
    flips = float(np.linalg.det(world_from_light[:3, :3])) < 0.0
    return LightTexture(
        use=TextureUse(image=picture.image, extension=Extension.EXTEND),
        projection=LightProjection.EMITTER,
        uv_from_projected=np.array([[1, 0, 0], [0, -1, 1], [0, 0, 1]], np.float64) if flips else np.eye(3),
        gain=np.diag([1.0 / mean if mean else 0.0 for mean in picture.mean]),
    )
