# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that give what a point, its object or the asking ray has of itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.scene_description import hair_maps
from tyndall.surface_inputs import PointInput, RayBit

from . import coordinates
from .asked_properties import ATTRIBUTE, GENERATED, UV
from .coordinates import point_input
from .domains import MID_GREY, Domain, on_surfaces
from .hair_nodes import default_tangent, hair_number, hair_vector
from .math_nodes import math_operation, vector_operation
from .mesh_attributes import ISLAND, POINTINESS, tangent_of, told_of
from .point_nodes import point_position, point_radius, point_random
from .program import BLACK, WHITE, Value, grey

if TYPE_CHECKING:
    from .asked_properties import Rgba
    from .domains import Evaluate
    from .node_graph import Socket
    from .value_nodes import ValueReader

_GLOSSY = RayBit.GLOSSY | RayBit.MIRROR
#: Which rays a question of Light Path is true of; of depths, which have one bounce behind them.
_RAYS = {
    "Is Camera Ray": RayBit.CAMERA,
    "Is Shadow Ray": RayBit.SHADOW,
    "Is Diffuse Ray": RayBit.DIFFUSE,
    "Is Glossy Ray": _GLOSSY | RayBit.TRANSMISSION,  # whatever is not diffuse, in Cycles, too
    "Is Singular Ray": RayBit.MIRROR | RayBit.TRANSMISSION,
    "Is Reflection Ray": RayBit.DIFFUSE | _GLOSSY,
    "Is Transmission Ray": RayBit.TRANSMISSION,
    "Is Volume Scatter Ray": RayBit.SCATTER,
    "Ray Depth": RayBit.SHADOW | RayBit.DIFFUSE | _GLOSSY | RayBit.TRANSMISSION | RayBit.SCATTER,
    "Diffuse Depth": RayBit.DIFFUSE,
    "Glossy Depth": _GLOSSY,
    "Transmission Depth": RayBit.TRANSMISSION,
    "Portal Depth": 0,
}
_GEOMETRY = {
    "Position": PointInput.POSITION,
    "Normal": PointInput.NORMAL,
    "True Normal": PointInput.TRUE_NORMAL,
    "Incoming": PointInput.INCOMING,
    "Parametric": PointInput.PARAMETRIC,
}
_OBJECT = {
    "Location": PointInput.OBJECT_LOCATION,
    "Color": PointInput.OBJECT_COLOR,
    "Alpha": PointInput.OBJECT_ALPHA,
    "Object Index": PointInput.OBJECT_INDEX,
    "Random": PointInput.OBJECT_RANDOM,
}
_PARTICLE = {
    "Index": PointInput.PARTICLE_INDEX,
    "Random": PointInput.PARTICLE_RANDOM,
    "Age": PointInput.PARTICLE_AGE,
    "Lifetime": PointInput.PARTICLE_LIFETIME,
    "Location": PointInput.PARTICLE_LOCATION,
    "Size": PointInput.PARTICLE_SIZE,
    "Velocity": PointInput.PARTICLE_VELOCITY,
    "Angular Velocity": PointInput.PARTICLE_ANGULAR_VELOCITY,
}
#: From and to, for points, vectors and normals; camera space is joined to the world's.
_TO_WORLD = {
    "POINT": PointInput.POINT_TO_WORLD,
    "VECTOR": PointInput.DIRECTION_TO_WORLD,
    "NORMAL": PointInput.NORMAL_TO_WORLD,
}
_TO_OBJECT = {
    "POINT": PointInput.POINT_TO_OBJECT,
    "VECTOR": PointInput.DIRECTION_TO_OBJECT,
    "NORMAL": PointInput.NORMAL_TO_OBJECT,
}


def _attribute(reader: ValueReader, at: Socket) -> Value:
    """Of meshes all that corners, points or faces have, of voxels all that they carry."""
    node = at.node
    is_colour_node = node.type == "VERTEX_COLOR"
    if not (is_colour_node or node.attribute_type == "GEOMETRY"):
        return _property(reader, at)
    if reader.domain is not Domain.SURFACE:
        return _unknown_attribute(reader, at, "is not supported here:")
    name = node.layer_name if is_colour_node else node.attribute_name
    if not name and not is_colour_node:
        # No mesh has it, and all are opaque; the colour that is rendered goes by no name with Color Attribute alone.
        return WHITE if at.socket.identifier == "Alpha" else BLACK
    program, wanted = reader.program, at.socket.identifier
    value = program.attribute(name, alpha=wanted == "Alpha")
    if is_colour_node or wanted not in {"Alpha", "Fac"}:
        return value
    has, is_pair = program.is_attribute(told_of(name))
    if wanted == "Alpha":  # 1 without the attribute; of Color Attribute it is 0
        return program.mix(WHITE, value, has)
    first = program.multiply(value, (3.0, 0.0, 0.0))  # of which the average is the first number
    return program.average(program.mix(value, first, is_pair))


def _property(reader: ValueReader, at: Socket) -> Value:
    found = reader.property_of(at.node.attribute_type, at.node.attribute_name)
    if found is None:
        is_of_other = at.node.attribute_type == ATTRIBUTE
        return _unknown_attribute(reader, at, "of an instancer is" if is_of_other else "is not supported here:")
    if at.socket.identifier == "Alpha":
        is_own = isinstance(found, int)
        return point_input(reader.program, PointInput.INSTANCER_ALPHA, selector=found) if is_own else grey(found[3])
    value = _own_or_constant(reader, found)
    return reader.program.average(value) if at.socket.identifier == "Fac" else value


def _own_or_constant(reader: ValueReader, found: Rgba | int) -> Value:
    """An instance's own, by its number."""
    if isinstance(found, int):
        return point_input(reader.program, PointInput.INSTANCER_COLOR, selector=found)
    return found[:3]


def _unknown_attribute(reader: ValueReader, at: Socket, what: str) -> Value:
    reader.unsupported(at, f"{what} read as mid grey")
    return MID_GREY


def _uv_map(reader: ValueReader, at: Socket) -> Value:
    if at.node.from_instancer:
        return _of_instancer(reader, at, UV)
    return coordinates.uv(reader.program, at.node.uv_map)


def _of_instancer(reader: ValueReader, at: Socket, kind: str) -> Value:
    found = reader.property_of(kind, "")
    if found is None:
        reader.unsupported(at, "of the instancer is read as 0")
        return BLACK
    return _own_or_constant(reader, found)


def _texture_coordinate(reader: ValueReader, at: Socket) -> Value:
    output = at.socket.identifier
    if at.node.from_instancer and output in {"Generated", "UV"}:
        return _of_instancer(reader, at, UV if output == "UV" else GENERATED)
    return _COORDINATES[output](reader, at)


def _in_object(reader: ValueReader, at: Socket) -> Value:
    """In the object's space, or in that of the one chosen."""
    program = reader.program
    if at.node.object is None:
        return point_input(program, PointInput.OBJECT_POSITION)
    from_world = at.node.object.matrix_world.inverted_safe()
    return coordinates.transformed(program, point_input(program, PointInput.POSITION), from_world)


def _in_camera(reader: ValueReader, at: Socket) -> Value:
    camera = reader.camera()
    if camera is None:
        reader.unsupported(at, "has no camera: read as 0")
        return BLACK
    position = point_input(reader.program, PointInput.POSITION)
    return coordinates.transformed(reader.program, position, camera.from_world)


def _in_window(reader: ValueReader, at: Socket) -> Value:
    """From 0 to 1 over the picture."""
    program, camera = reader.program, reader.camera()
    seen = _in_camera(reader, at)
    if camera is None:
        return seen
    if camera.is_panorama:
        reader.unsupported(at, "is not known of a panorama: read as 0")
        return BLACK
    on_plane = seen
    if camera.is_perspective:
        depth = program.channel(seen, 2)
        on_plane = vector_operation(program, "DIVIDE", seen, depth)
    width, height = camera.right - camera.left, camera.top - camera.bottom
    scale = (1.0 / width, 1.0 / height, 0.0) if width and height else BLACK
    return program.multiply(program.subtract(on_plane, (camera.left, camera.bottom, 0.0)), scale)


def _camera_data(reader: ValueReader, at: Socket) -> Value:
    program, seen = reader.program, _in_camera(reader, at)
    if at.socket.identifier == "View Z Depth":
        return program.channel(seen, 2)
    operation = "NORMALIZE" if at.socket.identifier == "View Vector" else "LENGTH"
    return vector_operation(program, operation, seen)


def _geometry(reader: ValueReader, at: Socket) -> Value:
    program, output = reader.program, at.socket.identifier
    if reader.domain is not Domain.SURFACE:
        reader.unsupported(at, f"{at.socket.name} is read as 0")
        return BLACK
    if output == "Backfacing":
        return program.backfacing()
    if output == "Normal" and reader.displaced_normal is not None:
        return reader.displaced_normal
    if output in _GEOMETRY:
        return point_input(program, _GEOMETRY[output])
    if output == "Tangent":
        return default_tangent(program)
    return coordinates.made(program, POINTINESS if output == "Pointiness" else ISLAND)


def _tangent(reader: ValueReader, at: Socket) -> Value:
    program, node = reader.program, at.node
    if node.direction_type == "RADIAL":
        return coordinates.radial_tangent(program, node.axis)
    return point_input(program, PointInput.TANGENT, coordinates.made(program, tangent_of(node.uv_map)))


def _object_info(reader: ValueReader, at: Socket) -> Value:
    output = at.socket.identifier
    if output == "Material Index":
        return grey(float(reader.material_index))
    return point_input(reader.program, _OBJECT[output])


def _light_path(reader: ValueReader, at: Socket) -> Value:
    output, program = at.socket.identifier, reader.program
    if output == "Ray Length":
        return point_input(program, PointInput.RAY_LENGTH)
    if output == "Transparent Depth":
        return point_input(program, PointInput.PASSED_COUNT)
    rays = int(_RAYS.get(output, 0))
    return point_input(program, PointInput.IS_RAY, selector=rays) if rays else BLACK


def _light_falloff(reader: ValueReader, at: Socket) -> Value:
    """By how far the ray that asks has come."""
    program, way = reader.program, point_input(reader.program, PointInput.RAY_LENGTH)
    squared = program.multiply(way, way)
    value, smooth = reader.number(at.input("Strength"), 1.0), reader.number(at.input("Smooth"))
    smoothed = vector_operation(program, "DIVIDE", squared, program.add(squared, smooth))
    value = program.multiply(value, smoothed)
    by_output = {"Quadratic": WHITE, "Linear": way, "Constant": squared}
    return program.multiply(value, by_output[at.socket.identifier])


def _light_path_elsewhere(reader: ValueReader, at: Socket) -> Value:
    """What the camera sees counts: its rays answer 1, all other questions 0."""
    if reader.domain is Domain.SURFACE:
        return _light_path(reader, at)
    reader.unsupported(at, "answers for camera rays only")
    return WHITE if at.socket.identifier == "Is Camera Ray" else BLACK


def _vector_transform(reader: ValueReader, at: Socket) -> Value:
    program, node, vector = reader.program, at.node, reader.colour(at.input("Vector"))
    kind, source, target = node.vector_type, node.convert_from, node.convert_to
    if source == target:
        return vector
    if kind == "NORMAL" and bpy.app.version < (4, 0, 0):  # up to 3.x normals are turned as vectors are
        return vector_operation(program, "NORMALIZE", _moved_between(reader, at, vector, "VECTOR"))
    return _moved_between(reader, at, vector, kind)


def _moved_between(reader: ValueReader, at: Socket, vector: Value, kind: str) -> Value:
    program, source, target = reader.program, at.node.convert_from, at.node.convert_to
    if source == "OBJECT":
        vector = point_input(program, _TO_WORLD[kind], vector)
    elif source == "CAMERA":
        vector = _through_camera(reader, at, vector, kind, is_into=False)
    if target == "OBJECT":
        return point_input(program, _TO_OBJECT[kind], vector)
    return _through_camera(reader, at, vector, kind, is_into=True) if target == "CAMERA" else vector


def _through_camera(reader: ValueReader, at: Socket, vector: Value, kind: str, *, is_into: bool) -> Value:
    program, camera = reader.program, reader.camera()
    if camera is None:
        reader.unsupported(at, "has no camera: its vector is passed on")
        return vector
    matrix = camera.from_world if is_into else camera.from_world.inverted()
    moved = coordinates.transformed(program, vector, matrix, is_direction=kind != "POINT")  # it has no scale
    return vector_operation(program, "NORMALIZE", moved) if kind == "NORMAL" else moved


def _particle_info(reader: ValueReader, at: Socket) -> Value:
    if not reader.tells_particles:
        reader.unsupported(at, "is read as 0 here: particles are not told apart")
        return BLACK
    return point_input(reader.program, _PARTICLE[at.socket.identifier])


def _wireframe(reader: ValueReader, at: Socket) -> Value:
    """1 within half its size of an edge of a triangle."""
    program = reader.program
    reach = program.multiply(reader.number(at.input("Size")), grey(0.5))
    if at.node.use_pixel_size:
        reach = program.multiply(reach, point_input(program, PointInput.PIXEL_WIDTH))
    distance = point_input(program, PointInput.EDGE_DISTANCE)
    return math_operation(program, "LESS_THAN", distance, math_operation(program, "ABSOLUTE", reach))


_HAIR = {
    "Is Strand": ("is", 0),
    "Intercept": ("il", 0),
    "Length": ("il", 1),
    "Random": ("rt", 0),
    "Thickness": ("rt", 1),
}


def _hair_info(reader: ValueReader, at: Socket) -> Value:
    """Of strands; elsewhere all is 0."""
    program, maps = reader.program, hair_maps()
    output = at.socket.identifier
    if output == "Tangent Normal":
        return hair_vector(program, maps["xy"], maps["z"])
    return hair_number(program, *_HAIR[output])


_POINT = {"Position": point_position, "Radius": point_radius, "Random": point_random}


def _point_info(reader: ValueReader, at: Socket) -> Value:
    """Of point clouds; elsewhere all is 0."""
    return _POINT[at.socket.identifier](reader.program)


def _generated(reader: ValueReader, _: Socket) -> Value:
    return coordinates.generated(reader.program)


def _active_uv(reader: ValueReader, _: Socket) -> Value:
    return coordinates.uv(reader.program)


def _by_shading_normal(reader: ValueReader, at: Socket) -> Value:
    program, normal, is_normal = reader.program, reader.displaced_normal, at.socket.identifier == "Normal"
    if normal is None:
        return point_input(program, PointInput.OBJECT_NORMAL if is_normal else PointInput.REFLECTION)
    if is_normal:
        return point_input(program, PointInput.NORMAL_TO_OBJECT, normal)
    outgoing = program.subtract(BLACK, point_input(program, PointInput.INCOMING))
    return vector_operation(program, "REFLECT", outgoing, normal)


_COORDINATES: dict[str, Evaluate] = {
    "Generated": _generated,
    "Normal": _by_shading_normal,
    "UV": _active_uv,
    "Object": _in_object,
    "Camera": _in_camera,
    "Window": _in_window,
    "Reflection": _by_shading_normal,
}

NODES: dict[str, Evaluate] = {
    "VERTEX_COLOR": _attribute,
    "ATTRIBUTE": _attribute,
    "UVMAP": on_surfaces(_uv_map),
    "TEX_COORD": on_surfaces(_texture_coordinate),
    "CAMERA": on_surfaces(_camera_data),
    "NEW_GEOMETRY": _geometry,
    "TANGENT": on_surfaces(_tangent),
    "OBJECT_INFO": on_surfaces(_object_info),
    "LIGHT_FALLOFF": on_surfaces(_light_falloff),
    "LIGHT_PATH": _light_path_elsewhere,
    "VECT_TRANSFORM": on_surfaces(_vector_transform),
    "PARTICLE_INFO": _particle_info,
    "HAIR_INFO": on_surfaces(_hair_info),
    "POINT_INFO": on_surfaces(_point_info),
    "WIREFRAME": on_surfaces(_wireframe),
}
