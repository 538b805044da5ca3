# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials, images, lights, worlds and media that are broken."""

from __future__ import annotations

from math import inf, nan, pi
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from support.agreement_shapes import diffuse
from support.damages import Random, Scene, damage, light_object, mesh_object, soup, textured

# --- materials and images --------------------------------------------------------------------------------------------


@damage("an image whose file is gone", "gone.png")
def _(_scene: Scene, random: Random) -> None:
    image = bpy.data.images.new("gone.png", 8, 8)
    image.source, image.filepath = "FILE", "//nowhere/gone.png"
    mesh_object("Textured", *soup(random)).data.materials.append(textured(image))


@damage("an image that is not an image", "broken.png")
def _(_scene: Scene, random: Random) -> None:
    path = Path(bpy.app.tempdir) / "broken.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + random.bytes(200))
    image = bpy.data.images.new("broken.png", 8, 8)
    image.source, image.filepath = "FILE", str(path)
    mesh_object("Textured", *soup(random)).data.materials.append(textured(image))


@damage("a texture node without an image", None)
def _(_scene: Scene, random: Random) -> None:
    mesh_object("Untextured", *soup(random)).data.materials.append(textured(None))


@damage("pixels that are not a number", "NaN Image")
def _(_scene: Scene, random: Random) -> None:
    image = bpy.data.images.new("NaN Image", 8, 8, float_buffer=True)
    pixels = random.random(8 * 8 * 4).astype(np.float32)
    pixels[random.integers(0, 256, 20)] = random.choice([nan, inf])
    image.pixels.foreach_set(pixels)
    mesh_object("Textured", *soup(random)).data.materials.append(textured(image))


@damage("an emission that is not a number", "Endless Glow")
def _(_scene: Scene, random: Random) -> None:
    material = bpy.data.materials.new("Endless Glow")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, glow = (
        tree.nodes.new("ShaderNodeOutputMaterial"),
        tree.nodes.new("ShaderNodeEmission"),
    )
    glow.inputs["Strength"].default_value = nan
    tree.links.new(glow.outputs[0], output.inputs["Surface"])
    mesh_object("Glow", *soup(random)).data.materials.append(material)


@damage("a material without an output", None)
def _(_scene: Scene, random: Random) -> None:
    material = bpy.data.materials.new("No Output")
    material.use_nodes = True
    material.node_tree.nodes.clear()
    mesh_object("No Output", *soup(random)).data.materials.append(material)


@damage("a node that is not supported", "Odd Material")
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    material.name = "Odd Material"
    tree = material.node_tree
    kind = str(
        random.choice(
            [
                "ShaderNodeBsdfGlass",
                "ShaderNodeSubsurfaceScattering",
                "ShaderNodeEeveeSpecular",
            ]
        )
    )
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(tree.nodes.new(kind).outputs[0], output.inputs["Surface"])
    mesh_object("Odd", *soup(random)).data.materials.append(material)


@damage("an empty node group", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    group = material.node_tree.nodes.new("ShaderNodeGroup")
    group.node_tree = [None, bpy.data.node_groups.new("Hollow", "ShaderNodeTree")][int(random.integers(2))]
    mesh_object("Grouped", *soup(random)).data.materials.append(material)


# --- lights and the world --------------------------------------------------------------------------------------------


@damage("a light of no finite power", "Mad Light", "light")
def _(_scene: Scene, random: Random) -> None:
    data = light_object("Mad Light", str(random.choice(["SUN", "POINT", "SPOT"]))).data
    data.energy = float(random.choice([nan, inf, -inf]))


@damage("a colour that is not a number", "Mad Light", "light")
def _(_scene: Scene, random: Random) -> None:
    light_object("Mad Light", str(random.choice(["SUN", "POINT", "SPOT"]))).data.color = (
        1.0,
        nan,
        1.0,
    )


@damage("a light nowhere", "Lost Light", "light")
def _(_scene: Scene, random: Random) -> None:
    made = light_object("Lost Light", str(random.choice(["SUN", "POINT", "SPOT"])))
    made.matrix_world = Matrix(((nan,) * 4,) * 4)
    made.location = (float(random.choice([nan, inf])), 0, 0)


@damage("lights scaled to nothing", None, "light")
def _(_scene: Scene, random: Random) -> None:
    for kind in ("SUN", "POINT", "SPOT"):
        light_object(f"Flat {kind}", kind).scale = np.where(random.random(3) < 0.6, 0.0, 1.0)


@damage("lights of absurd sizes", None, "light")
def _(_scene: Scene, random: Random) -> None:
    light_object("Wide Sun", "SUN").data.angle = pi
    light_object("Wide Point", "POINT").data.shadow_soft_size = float(random.choice([1e-30, 50.0, 1e6]))
    spot = light_object("Wide Spot", "SPOT").data
    spot.spot_size, spot.spot_blend = (
        float(random.choice([pi, 0.02])),
        float(random.choice([0.0, 1.0])),
    )


@damage("a light in the camera, one in a corner, one in the fog's side", None, "light")
def _(scene: Scene, _random: Random) -> None:
    for location in (
        scene.camera.matrix_world.translation,
        (0.0, 3.0, 0.0),
        (3.0, 0.0, 2.0),
    ):
        light_object("Touching", "POINT", tuple(location)).data.shadow_soft_size = 0.0


@damage("negative light", None, "light")
def _(_scene: Scene, _random: Random) -> None:
    light_object("Darkness", "POINT").data.energy = -5.0


@damage("no world", None, "world")
def _(scene: Scene, _random: Random) -> None:
    scene.world = None


@damage("a world of no finite strength", "World", "world")
def _(scene: Scene, random: Random) -> None:
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = float(random.choice([nan, inf]))


@damage("a sky whose file is gone", "gone.hdr", "world")
def _(scene: Scene, _random: Random) -> None:
    image = bpy.data.images.new("gone.hdr", 8, 8)
    image.source, image.filepath = "FILE", "//nowhere/gone.hdr"
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs[0], tree.nodes["Background"].inputs["Color"])


# --- media -----------------------------------------------------------------------------------------------------------
def _fog(name: str, **inputs: float) -> bpy.types.Object:
    mesh = bpy.data.objects["Medium"].data.copy()
    mesh.name = name
    material = mesh.materials[0].copy()
    material.name = name
    shader = next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeVolumeScatter")
    for socket, value in inputs.items():
        shader.inputs[socket].default_value = value
    mesh.materials[0] = material
    made = bpy.data.objects.new(name, mesh)
    made.matrix_world = bpy.data.objects["Medium"].matrix_world.copy()
    bpy.context.scene.collection.objects.link(made)
    return made


@damage("a density without a bound", "Mad Fog", "medium")
def _(_scene: Scene, random: Random) -> None:
    _fog("Mad Fog", Density=float(random.choice([nan, inf])))


@damage("a density beyond all measure", None, "absurd medium")
def _(_scene: Scene, random: Random) -> None:
    # Far from the cube, which must stay visible.
    _fog("Wall of Fog", Density=float(random.choice([1e9, 1e28]))).matrix_world = Matrix.Translation((9, 0, 0))


@damage("a negative density", None, "medium")
def _(_scene: Scene, _random: Random) -> None:
    _fog("Negative Fog", Density=-1.0)


@damage("a phase function that is a delta", None, "medium")
def _(_scene: Scene, random: Random) -> None:
    _fog("Laser Fog", Density=0.01, Anisotropy=float(random.choice([-1.0, 1.0])))


@damage("a medium whose mesh is open", "Open Fog", "medium")
def _(_scene: Scene, random: Random) -> None:
    mesh = _fog("Open Fog", Density=0.05).data
    points = [vertex.co.copy() for vertex in mesh.vertices]
    faces = [tuple(face.vertices) for face in mesh.polygons]
    faces.pop(int(random.integers(len(faces))))
    mesh.clear_geometry()
    mesh.from_pydata(points, [], faces)


@damage("a medium turned inside out, and the same again", None, "medium")
def _(_scene: Scene, _random: Random) -> None:
    _fog("Same Fog", Density=0.01)
    _fog("Inside Out", Density=0.01).data.flip_normals()


@damage("a medium without a volume", None, "medium")
def _(_scene: Scene, random: Random) -> None:
    _fog("Flat Fog", Density=1.0).scale[int(random.integers(3))] = 0.0


@damage("a medium of vertices that are not a number", "NaN Fog", "medium")
def _(_scene: Scene, _random: Random) -> None:
    mesh = _fog("NaN Fog", Density=0.1).data
    mesh.vertices[3].co.x = nan
