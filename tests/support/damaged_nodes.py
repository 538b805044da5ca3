# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees that are broken, and nodes of absurd parameters."""

from __future__ import annotations

from math import inf, nan

import bpy
import numpy as np

from support.agreement_shapes import diffuse
from support.damages import Random, Scene, damage, mesh_object, soup, textured

ABSURD = (0.0, -0.0, -1.0, -1e30, 1e30, 3e38, 1e-38, 2.0)
NOT_NUMBERS = (nan, inf, -inf)
SHADERS = (
    "ShaderNodeBsdfPrincipled", "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic",
    "ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction", "ShaderNodeBsdfTranslucent", "ShaderNodeBsdfTransparent",
    "ShaderNodeBsdfSheen", "ShaderNodeBsdfVelvet", "ShaderNodeSubsurfaceScattering", "ShaderNodeBsdfHair",
    "ShaderNodeBsdfHairPrincipled", "ShaderNodeBsdfToon", "ShaderNodeEmission", "ShaderNodeBsdfMetallic",
)  # fmt: skip
PATTERNS = (
    "ShaderNodeTexNoise", "ShaderNodeTexVoronoi", "ShaderNodeTexWave", "ShaderNodeTexMagic", "ShaderNodeTexBrick",
    "ShaderNodeTexChecker", "ShaderNodeTexGradient", "ShaderNodeTexWhiteNoise", "ShaderNodeTexMusgrave",
    "ShaderNodeMapRange", "ShaderNodeClamp", "ShaderNodeGamma", "ShaderNodeBrightContrast", "ShaderNodeHueSaturation",
    "ShaderNodeBlackbody", "ShaderNodeWavelength", "ShaderNodeVectorRotate", "ShaderNodeMapping", "ShaderNodeFresnel",
    "ShaderNodeLayerWeight", "ShaderNodeWireframe", "ShaderNodeBevel", "ShaderNodeAmbientOcclusion",
)  # fmt: skip


def node_of(tree: bpy.types.NodeTree, names: tuple[str, ...], random: Random) -> bpy.types.Node:
    """One of them, of those that this Blender has."""
    return tree.nodes.new(str(random.choice([name for name in names if hasattr(bpy.types, name)])))


def surface_of(material: bpy.types.Material) -> tuple[bpy.types.NodeTree, bpy.types.Node, bpy.types.Node]:
    """The tree of a plain material, its shader and its output."""
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    return tree, shader, next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")


def on_soup(material: bpy.types.Material, random: Random, name: str) -> bpy.types.Object:
    """Triangles that wear it."""
    material.name = name
    made = mesh_object(name, *soup(random))
    made.data.materials.append(material)
    return made


def spoil(node: bpy.types.Node, random: Random, values: tuple[float, ...], share: float = 0.4) -> None:
    """Some of its inputs, at least one of them."""
    sockets = [it for it in node.inputs if hasattr(it, "default_value") and it.type in {"VALUE", "RGBA", "VECTOR"}]
    if not sockets:
        return
    at_least = int(random.integers(len(sockets)))
    for index, socket in enumerate(sockets):
        if index == at_least or random.random() < share:
            if socket.type == "VALUE":
                socket.default_value = float(random.choice(values))
            else:
                socket.default_value = [float(random.choice(values)) for _ in socket.default_value]


@damage("a shader of absurd parameters", None)
def _(_scene: Scene, random: Random) -> None:
    for index in range(4):
        material = diffuse((0.5, 0.5, 0.5))
        tree, _shader, output = surface_of(material)
        shader = node_of(tree, SHADERS, random)
        spoil(shader, random, ABSURD)
        tree.links.new(shader.outputs[0], output.inputs["Surface"])
        on_soup(material, random, f"Absurd {index}")


@damage("a shader of parameters that are not numbers", "Mad Shader")
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, _shader, output = surface_of(material)
    shader = node_of(tree, SHADERS[:3], random)
    bad = float(random.choice((nan, inf)))  # of -inf Blender's colours make 0
    next(it for it in shader.inputs if it.type == "RGBA").default_value = [bad] * 4
    spoil(shader, random, NOT_NUMBERS)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    on_soup(material, random, "Mad Shader")


@damage("a pattern of absurd parameters", None)
def _(_scene: Scene, random: Random) -> None:
    for index in range(4):
        material = diffuse((0.5, 0.5, 0.5))
        tree, shader, _output = surface_of(material)
        pattern = node_of(tree, PATTERNS, random)
        spoil(pattern, random, (*ABSURD, *NOT_NUMBERS))
        tree.links.new(pattern.outputs[0], shader.inputs[int(random.integers(2))])
        on_soup(material, random, f"Pattern {index}")


@damage("mathematics without a result", None)
def _(_scene: Scene, random: Random) -> None:
    for index in range(4):
        material = diffuse((0.5, 0.5, 0.5))
        tree, shader, _output = surface_of(material)
        node = tree.nodes.new(str(random.choice(["ShaderNodeMath", "ShaderNodeVectorMath"])))
        operations = [it.identifier for it in node.bl_rna.properties["operation"].enum_items]
        node.operation = str(random.choice(operations))
        spoil(node, random, (*ABSURD, *NOT_NUMBERS), 1.0)
        result = next(it for it in node.outputs if it.enabled)
        for socket in shader.inputs:
            if random.random() < 0.6 and not socket.is_unavailable:
                tree.links.new(result, socket)
        on_soup(material, random, f"Sum {index}")


@damage("bumps, normals and displacements of absurd heights", None)
def _(_scene: Scene, random: Random) -> None:
    for index, kind in enumerate(("ShaderNodeBump", "ShaderNodeNormalMap", "ShaderNodeDisplacement")):
        material = diffuse((0.5, 0.5, 0.5))
        tree, shader, output = surface_of(material)
        node = tree.nodes.new(kind)
        spoil(node, random, (*ABSURD, *NOT_NUMBERS), 0.7)
        noise = tree.nodes.new("ShaderNodeTexNoise")
        socket = node.inputs.get("Height") or node.inputs["Color"]
        tree.links.new(noise.outputs[0], socket)
        is_displaced = kind == "ShaderNodeDisplacement"
        tree.links.new(node.outputs[0], output.inputs["Displacement"] if is_displaced else shader.inputs["Normal"])
        on_soup(material, random, f"Bump {index}")


@damage("links that turn in a circle", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, output = surface_of(material)
    one, two = tree.nodes.new("ShaderNodeMath"), tree.nodes.new("ShaderNodeMath")
    mix = tree.nodes.new("ShaderNodeMixShader")
    for source, target in (
        (one.outputs[0], two.inputs[0]), (two.outputs[0], one.inputs[1]), (one.outputs[0], shader.inputs[0]),
        (shader.outputs[0], mix.inputs[1]), (mix.outputs[0], mix.inputs[2]), (mix.outputs[0], output.inputs["Surface"]),
    ):  # fmt: skip
        tree.links.new(source, target)
    on_soup(material, random, "Circle")


def group_with(name: str) -> bpy.types.NodeTree:
    """A group of one shader output, which nothing feeds yet."""
    group = bpy.data.node_groups.new(name, "ShaderNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    else:
        group.outputs.new("NodeSocketShader", "Shader")
    group.nodes.new("NodeGroupOutput")
    return group


@damage("groups in groups, in a circle where Blender lets them", None)
def _(_scene: Scene, random: Random) -> None:
    groups = [group_with(f"Ring {index}") for index in range(3)]
    for index, group in enumerate(groups):
        node = group.nodes.new("ShaderNodeGroup")
        node.node_tree = groups[(index + 1) % 3]  # Blender refuses the last
        if node.outputs:
            group.links.new(node.outputs[0], next(it for it in group.nodes if it.type == "GROUP_OUTPUT").inputs[0])
    material = diffuse((0.5, 0.5, 0.5))
    tree, _shader, output = surface_of(material)
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = groups[0]
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    on_soup(material, random, "Ring")


@damage("a hundred groups in each other", None)
def _(_scene: Scene, random: Random) -> None:
    inner = group_with("Depth")
    inner.links.new(inner.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], inner.nodes[0].inputs[0])
    for _index in range(100):
        outer = group_with("Depth")
        node = outer.nodes.new("ShaderNodeGroup")
        node.node_tree = inner
        outer.links.new(node.outputs[0], outer.nodes[0].inputs[0])
        inner = outer
    material = diffuse((0.5, 0.5, 0.5))
    tree, _shader, output = surface_of(material)
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = inner
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    on_soup(material, random, "Depth")


@damage("a chain of four hundred nodes", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, _output = surface_of(material)
    source = tree.nodes.new("ShaderNodeTexNoise").outputs[0]
    for _index in range(400):
        node = tree.nodes.new("ShaderNodeMath")
        tree.links.new(source, node.inputs[0])
        source = node.outputs[0]
    tree.links.new(source, shader.inputs[0])
    on_soup(material, random, "Chain")


@damage("forty nodes with two to the fortieth ways through them", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, output = surface_of(material)
    is_of_shaders = bool(random.integers(2))
    source = shader.outputs[0] if is_of_shaders else tree.nodes.new("ShaderNodeTexNoise").outputs[0]
    for _index in range(40):
        node = tree.nodes.new("ShaderNodeMixShader" if is_of_shaders else "ShaderNodeMath")
        for socket in node.inputs[1 if is_of_shaders else 0 :][:2]:
            tree.links.new(source, socket)
        source = node.outputs[0]
    tree.links.new(source, output.inputs["Surface"] if is_of_shaders else shader.inputs[0])
    on_soup(material, random, "Diamonds")


@damage("two outputs of which none is active, and muted links", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, output = surface_of(material)
    tree.nodes.new("ShaderNodeOutputMaterial").target = "EEVEE"
    output.is_active_output = False
    shader.mute = bool(random.integers(2))
    for link in tree.links:
        link.is_muted = bool(random.integers(2))
    on_soup(material, random, "Muted")


@damage("drivers that are no expressions", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, _output = surface_of(material)
    made = on_soup(material, random, "Driven")
    curves = [made.driver_add("location", 0), shader.inputs["Roughness"].driver_add("default_value")]
    for curve in curves:
        curve.driver.type = "SCRIPTED"
        curve.driver.expression = str(random.choice(["1 / 0", "(", "no_such_name", "float('nan')", "1e400", ""]))
    tree.update_tag()


@damage("sockets of kinds that do not fit", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, output = surface_of(material)
    tree.links.new(tree.nodes.new("ShaderNodeValue").outputs[0], output.inputs["Surface"])
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeMath").inputs[0])
    tree.links.new(shader.outputs[0], output.inputs["Volume"])
    tree.links.new(tree.nodes.new("ShaderNodeVolumeScatter").outputs[0], output.inputs["Displacement"])
    on_soup(material, random, "Unfit")


@damage("maps, attributes and objects that are not there", None)
def _(_scene: Scene, random: Random) -> None:
    material = textured(bpy.data.images.new("Grey", 2, 2))
    tree = material.node_tree
    texture = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeTexImage")
    kind = (
        "ShaderNodeUVMap",
        "ShaderNodeAttribute",
        "ShaderNodeVertexColor",
        "ShaderNodeTexCoord",
        "ShaderNodeTangent",
    )
    node = tree.nodes.new(kind[int(random.integers(len(kind)))])
    for name in ("uv_map", "attribute_name", "layer_name"):
        if hasattr(node, name):
            setattr(node, name, "No Such Map")
    source = node.outputs[int(random.integers(len(node.outputs)))]
    tree.links.new(source, texture.inputs[0])
    made = on_soup(material, random, "Mapless")
    while made.data.uv_layers:
        made.data.uv_layers.remove(made.data.uv_layers[0])


@damage("images of no or odd kinds", None)
def _(_scene: Scene, random: Random) -> None:
    for index, source in enumerate(("FILE", "SEQUENCE", "MOVIE", "GENERATED", "TILED")):
        image = bpy.data.images.new(f"Odd {index}", 1, 1)
        image.source = source
        image.filepath = str(random.choice(["", "//", "/", "//no\\such.mov", "//odd.<UDIM>.exr", "/dev/null"]))
        material = textured(image)
        on_soup(material, random, f"Odd Image {index}")


@damage("ramps and curves without points to speak of", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, _output = surface_of(material)
    ramp, curves = tree.nodes.new("ShaderNodeValToRGB"), tree.nodes.new("ShaderNodeRGBCurve")
    ramp.color_ramp.elements.remove(ramp.color_ramp.elements[0])
    ramp.color_ramp.elements[0].color = [float(value) for value in random.choice((nan, 1e30, -1.0), 4)]
    ramp.color_ramp.elements.new(ramp.color_ramp.elements[0].position)
    for curve in curves.mapping.curves:
        for point in curve.points:
            point.location = (0.5, float(random.choice([0.5, 1e20, -1e20])))
    curves.mapping.update()
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], curves.inputs["Color"])
    tree.links.new(curves.outputs[0], shader.inputs[0])
    on_soup(material, random, "Ramp")


@damage("slots without a material, and a mesh whose materials are all gone", None)
def _(_scene: Scene, random: Random) -> None:
    made = on_soup(diffuse((0.5, 0.5, 0.5)), random, "Slots")
    made.data.materials.append(None)
    made.material_slots[0].link = "OBJECT"
    made.material_slots[0].material = None
    made.data.polygons.foreach_set("material_index", np.arange(len(made.data.polygons), dtype=np.int32) % 3)
    gone = on_soup(diffuse((0.5, 0.5, 0.5)), random, "Gone")
    bpy.data.materials.remove(gone.data.materials[0])


@damage("a colour of no finite size behind valid nodes", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, _output = surface_of(material)
    value = tree.nodes.new("ShaderNodeValue")
    value.outputs[0].default_value = float(random.choice(NOT_NUMBERS))
    noise = tree.nodes.new("ShaderNodeTexNoise")
    add = tree.nodes.new("ShaderNodeMath")
    tree.links.new(value.outputs[0], add.inputs[0])
    tree.links.new(noise.outputs[0], add.inputs[1])
    for socket in shader.inputs:
        if not socket.is_unavailable:
            tree.links.new(add.outputs[0], socket)
    on_soup(material, random, "Endless Colour")
