# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of area lights: their points lie on the light, and are seen from straight before it.

What Cycles' shader knows there was measured in 3.4.1, 4.5.15 and 5.0.1. Up to 3.x the light is no object to it: object
coordinates are the world's, and UV coordinates 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.emitter_programs import Emitter, EmitterPicture, EmitterPictures
from tyndall.scene_description import Code, Extension, LightProjection, LightTexture, TextureUse
from tyndall.surface_inputs import ImageProjection, PointInput

from .coordinates import point_input
from .domains import Domain
from .light_nodes import emission_value
from .light_textures import gobo_use
from .node_graph import output_input
from .program import BLACK, WHITE, Program, Term, Value, grey
from .value_nodes import ValueReader

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .images import ImageReader
    from .node_graph import Socket
    from .reports import Reports

_IS_OBJECT = bpy.app.version >= (4, 0, 0)


class AreaLightReader(ValueReader):
    """Evaluates them as a surface's; notes what changes with more than the place on the light."""

    def __init__(self, culprit: str, reports: Reports, images: ImageReader) -> None:
        super().__init__(culprit, reports, images, Domain.SURFACE)

    def vector(self, at: Socket | None, default: Value = BLACK) -> Value:
        if at is not None and at.socket.hide_value and at.source().socket == at.socket:
            return point_input(self.program, PointInput.OBJECT_POSITION)
        return self.colour(at, default)

    def _evaluated(self, at: Socket) -> Value:
        read = _NODES.get(at.node.type)
        value = None if read is None else read(self, at)
        return super()._evaluated(at) if value is None else value


# Each gives what its node is on an area light; None: the same as on surfaces.
def _of_meshes(reader: AreaLightReader, at: Socket) -> Value:
    """Lights have no attributes."""
    reader.unsupported(at, f"{at.socket.name} is read as 0 in an area light")
    return BLACK


def _object_info(reader: AreaLightReader, at: Socket) -> Value | None:
    return None if at.socket.identifier == "Location" else _of_meshes(reader, at)


def _bent_normal(reader: AreaLightReader, at: Socket) -> Value:
    reader.unsupported(at, "is read as the light's normal")
    return point_input(reader.program, PointInput.NORMAL)


def _by_direction(reader: AreaLightReader, at: Socket) -> None:
    reader.note(f"{at.node.bl_label} {at.socket.name} is read as seen from straight before the light")


def _light_path(reader: AreaLightReader, at: Socket) -> Value:
    """Of light that is looked for, Cycles answers no to all questions; one bounce lies behind it."""
    output = at.socket.identifier
    if output == "Ray Depth":
        return grey(1.0)
    if output != "Is Camera Ray":
        reader.unsupported(at, f"{at.socket.name} is read as 0: all rays see an area light alike")
    return BLACK


def _light_falloff(reader: AreaLightReader, at: Socket) -> Value:
    if at.socket.identifier != "Quadratic":
        reader.note(f"{at.socket.name} falloff is drawn as quadratic")
    return reader.number(at.input("Strength"), 1.0)


def _uv_map(_: AreaLightReader, at: Socket) -> Value | None:
    return BLACK if at.node.uv_map else None  # as in Cycles: it has no map of a name


def _geometry(reader: AreaLightReader, at: Socket) -> Value | None:
    if at.socket.identifier in {"Backfacing", "Tangent"}:
        return BLACK
    if at.socket.identifier == "Incoming":
        _by_direction(reader, at)
    return None


def _texture_coordinate(reader: AreaLightReader, at: Socket) -> Value | None:
    if at.socket.identifier == "Generated":
        return point_input(reader.program, PointInput.OBJECT_POSITION)
    if at.socket.identifier == "Reflection":
        _by_direction(reader, at)
    return None


_NODES: dict[str, Callable[[AreaLightReader, Socket], Value | None]] = {
    **dict.fromkeys(("ATTRIBUTE", "VERTEX_COLOR", "TANGENT", "HAIR_INFO", "WIREFRAME", "PARTICLE_INFO"), _of_meshes),
    **dict.fromkeys(("BUMP", "NORMAL_MAP"), _bent_normal),
    **dict.fromkeys(("FRESNEL", "LAYER_WEIGHT"), _by_direction),
    "OBJECT_INFO": _object_info,
    "LIGHT_PATH": _light_path,
    "LIGHT_FALLOFF": _light_falloff,
    "UVMAP": _uv_map,
    "NEW_GEOMETRY": _geometry,
    "TEX_COORD": _texture_coordinate,
}


@dataclass(frozen=True)
class AreaEmission:
    """What an area light's nodes, and its gobo, multiply its strength by, over its surface."""

    name: str
    program: Program
    value: Value

    def on(self, emitter: Emitter, pictures: EmitterPictures) -> EmitterPicture:
        """One instance of it."""
        if not isinstance(self.value, Term):
            return EmitterPicture(None, self.value)
        return pictures.find(self.program.material(self.name, (BLACK, BLACK, self.value)), emitter)


def read_area_emission(light: bpy.types.AreaLight, images: ImageReader, reports: Reports, culprit: str) -> AreaEmission:
    reader = AreaLightReader(culprit, reports, images)
    surface = output_input(light.node_tree if light.use_nodes else None, "Surface")
    value: Value = WHITE if surface is None else emission_value(reader, surface)
    gobo = gobo_use(light, images, reports, culprit)
    if gobo is not None:
        if isinstance(value, Term):
            reports.add(culprit, "its gobo takes the place of its nodes' pattern")
            value = WHITE
        value = reader.program.multiply(value, _gobo_value(reader.program, gobo, light.tyndall.gobo_strength))
    return AreaEmission(light.name, reader.program, value)


def _gobo_value(program: Program, use: TextureUse, share: float) -> Value:
    place = point_input(program, PointInput.PARAMETRIC)  # which all versions have
    option = int(ImageProjection.FLAT)
    shown = program.operation(Code.IMAGE_AT, place, option=option, texture=program.texture_index(use))
    return program.mix(WHITE, shown, grey(share))


def emitter_of(world_from_light: NDArray[np.float64], size_m: tuple[float, float], *, is_ellipse: bool) -> Emitter:
    return Emitter(world_from_object=world_from_light, size=size_m, is_ellipse=is_ellipse, is_object=_IS_OBJECT)


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
