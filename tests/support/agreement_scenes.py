# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes for the comparison with Cycles: one choice each of light, medium, camera and occluder.

A floor, a back wall, an occluder in the middle, a light beyond it: about 8 m across. Surfaces are Diffuse nodes, which
are Lambert's law in every version of Cycles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import radians

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

from support.agreement_shapes import OCCLUDERS, _link, _mesh, _output, _plane, diffuse
from support.new_file import new_file

LIGHT_AT = Vector((-2.4, 1.4, 4.6))
TARGET = Vector((0.0, 0.6, 1.0))


@dataclass(frozen=True)
class Arrangement:
    """Names of builders below."""

    light: str = "sun"
    medium: str = "camera inside"
    camera: str = "perspective"
    occluder: str = "grid"

    def __str__(self) -> str:
        """Test id: what differs from the plainest scene."""
        return f"{self.light}, {self.medium}, {self.camera}, {self.occluder}"


# --- lights ----------------------------------------------------------------------------------------------------------
def _light(kind: str, **settings: float | str) -> bpy.types.Object:
    data = bpy.data.lights.new(kind.title(), kind)
    data.color = (1.0, 0.8, 0.5)
    for name, value in settings.items():
        setattr(data, name, value)
    turn = (LIGHT_AT - TARGET).to_track_quat("Z", "Y").to_matrix().to_4x4()
    return _link(data.name, data, Matrix.Translation(LIGHT_AT) @ turn)


def _area(scale: tuple[float, float, float] = (1, 1, 1), **settings: float | str) -> None:
    """Shapes with sides that are told apart, turned around its beam, and unseen by cameras: in ours lights are."""
    thing = _light("AREA", **settings)
    thing.matrix_world = thing.matrix_world @ Matrix.Rotation(0.5, 4, "Z") @ Matrix.Diagonal((*scale, 1.0))
    thing.visible_camera = False


def _world_image() -> None:
    """A smooth sky with a bright, coloured patch, turned about all axes: a wrong mapping cannot hide."""
    height, width = 32, 64
    v, u = np.mgrid[0:height, 0:width].astype(np.float32)
    pixels = np.ones((height, width, 4), np.float32)
    glow = np.exp(-(((u - 20) / 6) ** 2) - ((v - 24) / 4) ** 2)
    pixels[..., 0] = 0.10 + 9.0 * glow
    pixels[..., 1] = 0.15 + 5.0 * glow
    pixels[..., 2] = 0.30 + 0.2 * v / height + 2.0 * glow
    image = bpy.data.images.new("Sky", width, height, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    tree = bpy.context.scene.world.node_tree
    texture, mapping = (
        tree.nodes.new("ShaderNodeTexEnvironment"),
        tree.nodes.new("ShaderNodeMapping"),
    )
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    texture.image = image
    mapping.inputs["Rotation"].default_value = (0.3, -0.2, 1.1)
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = 1.5


def _world_constant() -> None:
    background = bpy.context.scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.5, 0.7, 1.0, 1)
    background.inputs["Strength"].default_value = 1.2


def _lamp_in_a_can() -> None:
    """Inside the lamp: a tube that is narrower than the spot's radius."""
    _light("SPOT", energy=700.0, spot_size=radians(100), spot_blend=0.2, shadow_soft_size=0.1)
    can = _mesh(
        "Can",
        lambda shape: bmesh.ops.create_cone(shape, segments=24, radius1=0.08, radius2=0.08, depth=0.16, cap_ends=False),
        diffuse((0.5, 0.5, 0.5)),
    )
    _link("Can", can, bpy.data.objects["Spot"].matrix_world)


def _lamp_in_a_shelf() -> None:
    """Inside the lamp: two boards, half of its radius away."""
    _light("POINT", energy=500.0, shadow_soft_size=0.2)
    for height in (-0.1, 0.12):
        _plane("Board", Matrix.Translation(LIGHT_AT + Vector((0, 0, height))), diffuse((0.5, 0.5, 0.5)))


def _many() -> None:
    _light("SUN", energy=3.0, angle=0.0)
    _light(
        "SPOT",
        energy=400.0,
        spot_size=radians(40),
        spot_blend=0.3,
        shadow_soft_size=0.0,
    )
    _light("POINT", energy=200.0, shadow_soft_size=0.05)


LIGHTS: dict[str, Callable[[], None]] = {
    "sun": lambda: _light("SUN", energy=4.0, angle=0.0),
    "sun 2 degrees": lambda: _light("SUN", energy=4.0, angle=radians(2)),
    "sun 20 degrees": lambda: _light("SUN", energy=4.0, angle=radians(20)),
    "point": lambda: _light("POINT", energy=500.0, shadow_soft_size=0.0),
    "point 0.2 m": lambda: _light("POINT", energy=500.0, shadow_soft_size=0.2),
    "spot": lambda: _light(
        "SPOT",
        energy=700.0,
        spot_size=radians(50),
        spot_blend=0.0,
        shadow_soft_size=0.0,
    ),
    "spot blend 0.5": lambda: _light(
        "SPOT",
        energy=700.0,
        spot_size=radians(60),
        spot_blend=0.5,
        shadow_soft_size=0.0,
    ),
    "spot 0.1 m": lambda: _light(
        "SPOT",
        energy=700.0,
        spot_size=radians(50),
        spot_blend=0.2,
        shadow_soft_size=0.1,
    ),
    "spot 120 degrees": lambda: _light(
        "SPOT",
        energy=700.0,
        spot_size=radians(120),
        spot_blend=0.1,
        shadow_soft_size=0.0,
    ),
    "spot 180 degrees": lambda: _light(
        "SPOT",
        energy=700.0,
        spot_size=radians(180),
        spot_blend=0.0,
        shadow_soft_size=0.0,
    ),
    "area": lambda: _area(energy=500.0, shape="RECTANGLE", size=1.2, size_y=0.5),
    # Of a disk, Cycles 3.4 samples what sends nothing, too: its noise has tails that no sigma tells.
    "area disk 50 degrees": lambda: _area(
        energy=300.0, shape="DISK" if bpy.app.version >= (4, 0, 0) else "SQUARE", size=0.8, spread=radians(50)
    ),
    "area ellipse, scaled": lambda: _area(
        (1.5, -0.5, 2.0), energy=500.0, shape="ELLIPSE", size=0.6, size_y=1.0, spread=radians(120)
    ),
    "spot in a can": _lamp_in_a_can,
    "point in a shelf": _lamp_in_a_shelf,
    "world": _world_constant,
    "world image": _world_image,
    "many": _many,
}


# --- media -----------------------------------------------------------------------------------------------------------
def _medium(mesh: bpy.types.Mesh, matrix: Matrix, node: str, **inputs: object) -> bpy.types.Object:
    material = bpy.data.materials.new(f"Medium {node}")
    tree, output = _output(material)
    shader = tree.nodes.new(node)
    for name, value in inputs.items():
        shader.inputs[name.replace("_", " ")].default_value = value
    tree.links.new(shader.outputs[0], output.inputs["Volume"])
    mesh.materials.append(material)
    return _link("Medium", mesh, matrix)


def _box(
    low: tuple[float, float, float],
    high: tuple[float, float, float],
    node: str,
    **inputs: object,
) -> bpy.types.Object:
    mesh = _mesh("Box", lambda shape: bmesh.ops.create_cube(shape, size=1.0))
    centre, size = (Vector(low) + Vector(high)) / 2, Vector(high) - Vector(low)
    return _medium(mesh, Matrix.LocRotScale(centre, None, size), node, **inputs)


def _sphere() -> None:
    mesh = _mesh("Sphere", lambda shape: bmesh.ops.create_uvsphere(shape, u_segments=24, v_segments=12, radius=2.2))
    _medium(mesh, Matrix.Translation((0.0, 0.4, 1.6)), SCATTER, Density=0.25, Anisotropy=0.2)


SCATTER, ABSORB, PRINCIPLED = (
    "ShaderNodeVolumeScatter",
    "ShaderNodeVolumeAbsorption",
    "ShaderNodeVolumePrincipled",
)
ROOM = ((-3.0, -9.0, 0.01), (3.0, 2.9, 4.0))
CLOUD = ((-2.2, -1.5, 0.02), (2.2, 2.5, 3.6))
WHITE, TINTED = (1, 1, 1, 1), (0.9, 0.6, 0.3, 1)


def _glowing_box() -> None:
    """Emission and absorption only, without a surface in it: Cycles would count what lights it as direct light."""
    black = (0, 0, 0, 1)
    inputs = {"Density": 0.3, "Color": black, "Absorption Color": (0.5, 0.2, 0.1, 1)}
    box = _box(
        (-2.2, -3.5, 0.02),
        (2.2, -0.9, 3.6),
        PRINCIPLED,
        **inputs,
        **{"Emission Strength": 0.2, "Emission Color": (0.2, 0.5, 1.0, 1)},
    )
    box.visible_diffuse = False


def _two_boxes(red: tuple[float, ...], blue: tuple[float, ...], red_g: float, blue_g: float) -> None:
    _box((-2.5, -2.0, 0.02), (0.7, 2.0, 3.0), SCATTER, Color=red, Density=0.15, Anisotropy=red_g)
    _box((-0.5, -1.0, 0.04), (2.5, 2.6, 3.4), SCATTER, Color=blue, Density=0.15, Anisotropy=blue_g)


MEDIA: dict[str, Callable[[], object]] = {
    "none": lambda: None,
    "camera inside": lambda: _box(*ROOM, SCATTER, Color=WHITE, Density=0.08, Anisotropy=0.0),
    "camera outside": lambda: _box(*CLOUD, SCATTER, Color=WHITE, Density=0.15, Anisotropy=0.0),
    "dense": lambda: _box(*CLOUD, SCATTER, Color=WHITE, Density=1.5, Anisotropy=0.0),
    "thin": lambda: _box(*ROOM, SCATTER, Color=WHITE, Density=0.002, Anisotropy=0.0),
    "coloured": lambda: _box(*ROOM, SCATTER, Color=TINTED, Density=0.12, Anisotropy=0.0),
    "g -0.5": lambda: _box(*ROOM, SCATTER, Color=WHITE, Density=0.08, Anisotropy=-0.5),
    "g 0.8": lambda: _box(*ROOM, SCATTER, Color=WHITE, Density=0.08, Anisotropy=0.8),
    "absorption": lambda: _box(*ROOM, ABSORB, Color=TINTED, Density=0.2),
    "principled": lambda: _box(
        *ROOM,
        PRINCIPLED,
        Color=TINTED,
        Density=0.1,
        Anisotropy=0.3,
        Absorption_Color=(0.2, 0.4, 0.7, 1),
    ),
    "emission": _glowing_box,
    # Where media overlap, Cycles weighs their phase functions by one number instead of per channel: with both another
    # colour and another asymmetry it would be 10 % off.
    "two colours": lambda: _two_boxes((1, 0.5, 0.3, 1), (0.3, 0.6, 1, 1), 0.2, 0.2),
    "two phases": lambda: _two_boxes(WHITE, WHITE, 0.4, -0.3),
    "sphere": _sphere,
}


# --- cameras ---------------------------------------------------------------------------------------------------------
def _camera(location: tuple[float, float, float], **settings: object) -> None:
    data = bpy.data.cameras.new("Camera")
    for name, value in settings.items():
        setattr(data, name, value)
    turn = (Vector(location) - Vector((0, 0.5, 1.5))).to_track_quat("Z", "Y").to_matrix().to_4x4()
    bpy.context.scene.camera = _link("Camera", data, Matrix.Translation(location) @ turn)


CAMERAS: dict[str, Callable[[], None]] = {
    "perspective": lambda: _camera((1.6, -6.5, 1.8), lens=32.0),
    "shifted": lambda: _camera((1.6, -6.5, 1.8), lens=36.0, shift_x=0.15, shift_y=-0.1, sensor_fit="VERTICAL"),
    "orthographic": lambda: _camera((2.5, -6.5, 2.6), type="ORTHO", ortho_scale=7.0),
    "towards light": lambda: _camera((2.2, -1.5, 0.5), lens=20.0),
}


def build(arrangement: Arrangement, width_px: int = 96, height_px: int = 54) -> bpy.types.Scene:
    """Make the scene in an empty file."""
    scene = new_file(is_empty=True)
    scene.render.resolution_x, scene.render.resolution_y = width_px, height_px
    scene.render.resolution_percentage = 100
    scene.world = bpy.data.worlds.new("World")
    tree, output = _output(scene.world)
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (0, 0, 0, 1)
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    grey = diffuse((0.5, 0.5, 0.5))
    _plane("Floor", Matrix.Diagonal((30, 30, 1, 1)), grey)
    wall = Matrix.Translation((0, 3.0, 0)) @ Matrix.Rotation(radians(90), 4, "X") @ Matrix.Diagonal((30, 30, 1, 1))
    _plane("Wall", wall, diffuse((0.3, 0.4, 0.5)))
    OCCLUDERS[arrangement.occluder]()
    MEDIA[arrangement.medium]()
    LIGHTS[arrangement.light]()
    CAMERAS[arrangement.camera]()
    return scene
