# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of patterns with random inputs at every socket, as set-ups of flat_nodes.py."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import bpy

from .flat_nodes import Inputs, Setup
from .small_scenes import Node

VERSION = bpy.app.version

Socket = bpy.types.NodeSocket
Range = tuple[float, float]
#: What sockets are linked to: random numbers in these ranges. Vectors are in VECTOR, colours in [0, 1].
RANGES: dict[str, Range] = {
    "W": (-3, 3), "Scale": (-2, 3), "Detail": (0, 3.5), "Roughness": (0, 1), "Lacunarity": (1, 2.5),
    "Offset": (-0.5, 1.5), "Gain": (0, 2), "Distortion": (-1.5, 1.5), "Dimension": (0, 2), "Randomness": (0, 1),
    "Smoothness": (0.01, 1), "Exponent": (0.3, 4), "Detail Scale": (-2, 2), "Detail Roughness": (0, 1),
    "Phase Offset": (-9, 9), "Mortar Size": (0, 0.125), "Mortar Smooth": (0, 1), "Bias": (-1, 1),
    "Brick Width": (0.1, 2), "Row Height": (0.1, 1), "Frequency": (0, 4), "Anisotropy": (-0.2, 1.2),
    "Orientation 2D": (-4, 4),
}  # fmt: skip
#: Results of these must stay where light can show them: above -16.
RANGES_OF_KIND: dict[tuple[str, str], Range] = {("Voronoi", "Scale"): (0.4, 3), ("Magic", "Distortion"): (0.3, 1.5)}
VECTOR: Range = (-3, 3)
COLOURS = ("Color1", "Color2", "Mortar")
FRACTALS = ("MULTIFRACTAL", "FBM", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN")
FEATURES = ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS")
METRICS = ("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI")


def in_range(inputs: Inputs, source: Socket, low: float, high: float, kind: str = "Math") -> Node:
    """A node whose output is at ``low`` for 0 and at ``high`` for 1."""
    node: Node = inputs.new(f"ShaderNode{kind}")
    node.operation = "MULTIPLY_ADD"
    is_vector = kind == "VectorMath"
    for socket, value in ((node.inputs[1], high - low), (node.inputs[2], low)):
        socket.default_value = (value,) * 3 if is_vector else value
    inputs.link(source, node.inputs[0])
    return node


def place(mapping: bpy.types.TexMapping, kind: str) -> None:
    """A mapping of a node's own; Cycles does not look at what limits it."""
    mapping.vector_type = kind
    mapping.use_min = mapping.use_max = True
    mapping.translation, mapping.rotation, mapping.scale = (0.3, -0.2, 0.5), (0.4, 0.9, -0.3), (0.7, -1.4, 2.0)
    mapping.mapping_x, mapping.mapping_y = "Z", "X"


def pattern(kind: str, output: str, *, whole: bool = False, **properties: object) -> Callable[[Inputs], Socket]:
    """The node with all its visible sockets linked; ``whole`` numbers have the same bits in both engines."""

    def linked(inputs: Inputs, node: Node, socket: Socket) -> None:
        if socket.identifier in COLOURS:
            inputs.link(inputs.colour(1 + COLOURS.index(socket.identifier)), socket)
            return
        is_vector = socket.type == "VECTOR"
        name = socket.identifier
        low, high = VECTOR if is_vector else RANGES_OF_KIND.get((kind, name), RANGES[name])
        if whole:
            low, high = -32, 32
        index = list(node.inputs).index(socket)
        source = inputs.vector(index % 4) if is_vector else inputs.number(index % 4)
        moved = in_range(inputs, source, low, high, "VectorMath" if is_vector else "Math")
        if whole:
            floor = inputs.new("ShaderNodeVectorMath" if is_vector else "ShaderNodeMath")
            floor.operation = "FLOOR"
            inputs.link(moved.outputs[0], floor.inputs[0])
            moved = floor
        inputs.link(moved.outputs[0], socket)

    def build(inputs: Inputs) -> Socket:
        node = inputs.new(f"ShaderNodeTex{kind}")
        for name, value in properties.items():
            if name == "mapping":
                place(node.texture_mapping, str(value))
            else:
                setattr(node, name, value)
        for socket in node.inputs:
            if not socket.is_unavailable:
                linked(inputs, node, socket)
        return next(socket for socket in node.outputs if socket.identifier == output)

    return build


Case = tuple[str, Callable[[Inputs], Socket], bool]  #: Name, node, and whether it has jumps.


def case(kind: str, output: str, *, torn: bool = False, whole: bool = False, **properties: object) -> Case:
    name = " ".join([kind, output, *(f"{name}={value}" for name, value in properties.items())])
    return name, pattern(kind, output, whole=whole, **properties), torn


def noises(dimensions: str, fractal: str, output: str, *, normalize: bool = True) -> Iterator[Case]:
    properties: dict[str, object] = {"noise_dimensions": dimensions}
    if VERSION >= (4, 0):
        properties["normalize"] = normalize
    if VERSION >= (4, 1):
        properties["noise_type"] = fractal
    elif fractal != "FBM":
        return
    yield case("Noise", output, **properties)


def voronois(dimensions: str, feature: str, metric: str, output: str, *, normalize: bool = False) -> Iterator[Case]:
    hidden = {"Position"} if dimensions == "1D" else {"W"} if dimensions in {"2D", "3D"} else set()
    if output in hidden or (dimensions == "1D" and metric != "EUCLIDEAN"):
        return
    properties: dict[str, object] = {"voronoi_dimensions": dimensions, "feature": feature, "distance": metric}
    if VERSION >= (4, 0):
        properties["normalize"] = normalize
    yield case("Voronoi", output, torn=output in {"Color", "Position", "W", "Radius"}, **properties)


def usual_cases() -> Iterator[Case]:
    yield case("Checker", "Color", torn=True)
    yield case("Checker", "Fac", torn=True)
    for dimensions in ("1D", "2D", "3D", "4D"):
        yield from noises(dimensions, "FBM", "Fac")
        yield case("WhiteNoise", "Color", whole=True, noise_dimensions=dimensions)
        for feature in FEATURES[:3]:
            yield from voronois(dimensions, feature, "EUCLIDEAN", "Distance")
        yield from voronois(dimensions, "DISTANCE_TO_EDGE", "EUCLIDEAN", "Distance", normalize=True)
        yield from voronois(dimensions, "F1", "EUCLIDEAN", "Color")
    yield case("WhiteNoise", "Value", whole=True, noise_dimensions="3D")
    yield from noises("3D", "FBM", "Color", normalize=False)
    for fractal in FRACTALS:
        yield from noises("3D", fractal, "Fac")
        if VERSION < (4, 1):
            yield case("Musgrave", "Fac", musgrave_dimensions="3D", musgrave_type=fractal)
    yield from voronois("3D", "F1", "EUCLIDEAN", "Position")
    yield from voronois("4D", "F2", "MINKOWSKI", "W")
    yield from voronois("3D", "N_SPHERE_RADIUS", "EUCLIDEAN", "Radius")
    for metric in METRICS[1:]:
        yield from voronois("3D", "F1", metric, "Distance", normalize=True)
    for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE"):
        yield case("Gradient", "Fac", gradient_type=kind)
    yield case("Gradient", "Color", gradient_type="RADIAL", torn=True)
    for output in ("Color", "Fac"):
        yield case("Brick", output, torn=True)
        yield case("Magic", output, turbulence_depth=3)
    yield case("Brick", "Color", torn=True, offset=0.3, offset_frequency=3, squash=1.7, squash_frequency=4)
    yield case("Wave", "Color", wave_type="BANDS", bands_direction="X")
    yield case("Wave", "Fac", wave_type="RINGS", rings_direction="Z", wave_profile="TRI")
    yield case("Wave", "Fac", wave_type="BANDS", bands_direction="DIAGONAL", wave_profile="SAW", torn=True)
    for placed in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):
        yield case("Noise", "Fac", mapping=placed)
    if VERSION >= (4, 3):
        yield case("Gabor", "Value", gabor_type="2D")
        yield case("Gabor", "Phase", gabor_type="3D", torn=True)


def all_cases() -> Iterator[Case]:
    for dimensions, fractal, output, normalize in product(("1D", "2D", "3D", "4D"), FRACTALS, ("Fac", "Color"), (0, 1)):
        yield from noises(dimensions, fractal, output, normalize=bool(normalize))
        if VERSION < (4, 1) and output == "Fac" and normalize:
            yield case("Musgrave", "Fac", musgrave_dimensions=dimensions, musgrave_type=fractal)
    for dimensions, feature, metric, output in product(
        ("1D", "2D", "3D", "4D"), FEATURES[:3], METRICS, ("Distance", "Color", "Position", "W")
    ):
        yield from voronois(dimensions, feature, metric, output, normalize=output == "Color")
    for dimensions, normalize in product(("1D", "2D", "3D", "4D"), (False, True)):
        yield from voronois(dimensions, "DISTANCE_TO_EDGE", "EUCLIDEAN", "Distance", normalize=normalize)
        yield from voronois(dimensions, "N_SPHERE_RADIUS", "EUCLIDEAN", "Radius")
    for kind, direction, profile in product((0, 1), range(4), ("SIN", "SAW", "TRI")):
        wave_type = ("BANDS", "RINGS")[kind]
        property_name = ("bands_direction", "rings_direction")[kind]
        axis = ("X", "Y", "Z", ("DIAGONAL", "SPHERICAL")[kind])[direction]
        properties = {"wave_type": wave_type, property_name: axis, "wave_profile": profile}
        yield case("Wave", "Fac", torn=profile == "SAW", **properties)
    for depth in range(11):
        yield case("Magic", "Color", turbulence_depth=depth)
    if VERSION >= (4, 3):
        for dimensions, output in product(("2D", "3D"), ("Value", "Phase", "Intensity")):
            yield case("Gabor", output, gabor_type=dimensions, torn=output == "Phase")


def setups_of(cases: Iterator[Case]) -> dict[str, tuple[Setup, bool]]:
    """By name: what is rendered, and whether it has jumps."""
    return {name: (Setup(name, build, 0.0, 1.0, is_special=False), torn) for name, build, torn in cases}
