# SPDX-License-Identifier: GPL-3.0-or-later
"""Image and environment textures, and the coordinates they are read at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from mathutils import Euler, Matrix

from tyndall.scene_description import Code, Extension, Interpolation, TextureUse
from tyndall.surface_inputs import IMAGE_HAS_TILES, EnvironmentProjection, ImageProjection, PointInput

from . import coordinates
from .domains import MID_GREY, Domain
from .images import MAGENTA, texel_of_missing
from .program import WHITE, Value
from .texture_mapping import mapped, own_matrix

if TYPE_CHECKING:
    from collections.abc import Callable

    import bpy

    from tyndall.scene_description import Image

    from .node_graph import Socket
    from .value_nodes import ValueReader

EXTENSIONS = {
    "REPEAT": Extension.REPEAT,
    "EXTEND": Extension.EXTEND,
    "CLIP": Extension.CLIP,
    "MIRROR": Extension.MIRROR,
}
#: Smart is cubic where a picture is not made smaller, which nothing here knows.
_INTERPOLATIONS = {"Closest": Interpolation.CLOSEST, "Linear": Interpolation.LINEAR}


def image_value(reader: ValueReader, at: Socket) -> Value:
    """Colour or alpha of an Image Texture node."""
    node, wants_alpha = at.node, at.socket.identifier == "Alpha"
    if node.image is not None and node.image.source == "TILED" and node.projection == "FLAT":
        return _tiles(reader, at)
    use = image_use(reader, at)
    if not isinstance(use, TextureUse):
        return WHITE if wants_alpha else use
    if wants_alpha and not use.image.has_alpha and node.extension != "CLIP":  # which is transparent outside
        return WHITE
    place = _flat_coordinates(reader, at)
    if place is None:
        return _image_anywhere(reader, at, use)
    # A texture reads (u, v, 1): of the 4x4 matrix the column of z, which is 0, drops out.
    uv_matrix = tuple(float(place.matrix[row][column]) for row in (0, 1, 3) for column in (0, 1, 3))
    return reader.program.texture(use, place.uv_map, uv_matrix, alpha=wants_alpha)


def _image_anywhere(reader: ValueReader, at: Socket, use: TextureUse) -> Value:
    """By its node's projection, at whatever vector."""
    node, program = at.node, reader.program
    projection = ImageProjection[node.projection]
    vector = _vector(reader, at)
    code = Code.IMAGE_ALPHA_AT if at.socket.identifier == "Alpha" else Code.IMAGE_AT
    blend = node.projection_blend if projection is ImageProjection.BOX else 0.0
    return program.operation(
        code, vector, option=int(projection), texture=program.texture_index(use), value=(blend, 0.0, 0.0)
    )


def _vector(reader: ValueReader, at: Socket) -> Value:
    """Where an image is read: the active UV map, where nothing is linked."""
    linked = at.input("Vector")
    return mapped(reader, at, reader.colour(linked) if linked.is_connected() else coordinates.uv(reader.program))


def _flat_coordinates(reader: ValueReader, at: Socket) -> _Coordinates | None:
    """Of an image that lies flat on a UV map, through constant mappings; None of any other."""
    own = own_matrix(at.node)
    if at.node.projection != "FLAT" or own is None:
        return None
    source = at.input("Vector").source()
    while source.socket.is_output and source.node.type == "MAPPING" and _is_affine(source):
        source = source.input("Vector").source()
    if not source.socket.is_output:
        is_linked = source.socket != at.input("Vector").socket
        return None if is_linked else _Coordinates("", own)
    return _coordinates(reader, at, own) if _is_uv_map(source) else None


def _is_affine(mapping: Socket) -> bool:
    """And known now."""
    inputs = (mapping.input(name) for name in ("Location", "Rotation", "Scale"))
    is_known = not any(one is not None and one.is_connected() for one in inputs)
    return is_known and mapping.node.vector_type != "NORMAL"


def _is_uv_map(source: Socket) -> bool:
    node, output = source.node, source.socket.identifier
    if node.type == "TEX_COORD":
        return output == "UV" and not node.from_instancer
    return bool(node.type == "UVMAP" and not node.from_instancer)


def image_use(reader: ValueReader, at: Socket) -> TextureUse | Value:
    """The image of a node, as the node reads it; magenta for one that cannot be had."""
    node = at.node
    # Cycles divides colours by alpha only for nodes whose Alpha output is in use.
    uses_alpha = any(socket.identifier == "Alpha" and socket.is_linked for socket in node.outputs)
    image = reader.images.read(
        node.image,
        reader.reports,
        reader.culprit,
        associated=not uses_alpha,
        user=node.image_user,
        stays_whole=reader.domain is not Domain.SURFACE,
    )
    if image is not None:
        return _use_of(image, node)
    is_seen_to_end = getattr(node, "extension", "") == "CLIP"
    return _use_of(texel_of_missing(node.image, associated=not uses_alpha), node) if is_seen_to_end else MAGENTA


def _use_of(image: Image, node: bpy.types.Node) -> TextureUse:
    return TextureUse(
        image=image,
        extension=EXTENSIONS[node.extension] if hasattr(node, "extension") else Extension.REPEAT,
        interpolation=_INTERPOLATIONS.get(node.interpolation, Interpolation.CUBIC),
    )


def _tiles(reader: ValueReader, at: Socket) -> Value:
    """Each square of the UV map has an image of its own; where it has none it is magenta."""
    node, program, wants_alpha = at.node, reader.program, at.socket.identifier == "Alpha"
    uses_alpha = any(socket.identifier == "Alpha" and socket.is_linked for socket in node.outputs)
    tiles = reader.images.read_tiles(node.image, reader.reports, reader.culprit, associated=not uses_alpha)
    if not tiles:
        return WHITE if wants_alpha else MAGENTA
    rows = [(*place, program.texture_index(_use_of(tile, node)), 0) for place, tile in tiles.items()]
    return program.operation(
        Code.IMAGE_ALPHA_AT if wants_alpha else Code.IMAGE_AT,
        _vector(reader, at),
        option=int(ImageProjection.FLAT),
        selector=IMAGE_HAS_TILES,
        texture=int(rows[0][2]),
        table=program.table(np.array(rows, np.float32)),
    )


def _environment_on_surface(reader: ValueReader, at: Socket) -> Value:
    use = image_use(reader, at)
    if not isinstance(use, TextureUse):
        return use
    vector = at.input("Vector")
    place = PointInput.POSITION
    direction = reader.colour(vector) if vector.is_connected() else coordinates.point_input(reader.program, place)
    projection = EnvironmentProjection[at.node.projection]
    return reader.program.operation(
        Code.ENVIRONMENT_AT,
        mapped(reader, at, direction),
        option=int(projection),
        texture=reader.program.texture_index(use),
    )


@dataclass(frozen=True)
class _Coordinates:
    uv_map: str  #: "": the active one.
    matrix: Matrix  #: 4x4, from (u, v, 0), or from a direction, to the texture.


def _coordinates(reader: ValueReader, at: Socket, matrix: Matrix) -> _Coordinates:
    """Follows the Vector input to where it starts; Mapping nodes on the way multiply."""
    source = at.input("Vector").source()
    while source.socket.is_output and source.node.type == "MAPPING":
        mapping = mapping_matrix(reader, source)
        matrix = matrix @ mapping
        source = source.input("Vector").source()
    if not source.socket.is_output:
        return _Coordinates("", matrix)
    return _Coordinates(_origin(reader, source), matrix)


def _origin(reader: ValueReader, source: Socket) -> str:
    """The UV map that a vector starts from."""
    node, output = source.node, source.socket.identifier
    if node.type == "UVMAP":
        return str(node.uv_map)
    if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY" and output == "Vector":
        return str(node.attribute_name)
    if node.type == "TEX_COORD" and output == "UV":
        return ""
    label = node.bl_label if node.type != "TEX_COORD" else f"{source.socket.name} coordinates"
    reader.note(f"{label}: the active UV map is used instead")
    return ""


def mapping_matrix(reader: ValueReader, at: Socket) -> Matrix:
    node = at.node
    read = {name: reader.constant_colour(at.input(name)) for name in ("Rotation", "Scale")}
    location = reader.constant_colour(at.input("Location")) if at.input("Location") else (0.0, 0.0, 0.0)
    rotation = Euler(read["Rotation"], "XYZ").to_matrix().to_4x4()
    scale = Matrix.Diagonal((*read["Scale"], 1.0))
    if node.vector_type == "POINT":
        return Matrix.Translation(location) @ rotation @ scale
    if node.vector_type == "VECTOR":
        return rotation @ scale
    inverse_scale = Matrix.Diagonal((*(1.0 / value if value else 0.0 for value in read["Scale"]), 1.0))
    if node.vector_type == "TEXTURE":
        return inverse_scale @ rotation.transposed() @ Matrix.Translation([-value for value in location])
    return rotation @ inverse_scale  # a normal; Cycles makes it a unit vector, which directions are read as anyway


def _image(reader: ValueReader, at: Socket) -> Value:
    return image_value(reader, at) if reader.domain is Domain.SURFACE else reader.image(at)


def _environment(reader: ValueReader, at: Socket) -> Value:
    if reader.domain is Domain.LIGHT:
        return reader.image(at)
    if reader.domain is Domain.SURFACE:
        return _environment_on_surface(reader, at)
    reader.unsupported(at, "is read as mid grey: it works on surfaces and in worlds only")
    return MID_GREY


NODES: dict[str, Callable[[ValueReader, Socket], Value]] = {
    "TEX_IMAGE": _image,
    "TEX_ENVIRONMENT": _environment,
}
