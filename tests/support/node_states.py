# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes of every shader node that the running Blender has: what the compiler reports about each output."""

from __future__ import annotations

import sys
from dataclasses import dataclass

import bpy

from .engine_pictures import tyndall_pixels
from .small_scenes import add, empty_scene, use_nodes

#: They hold a tree together or end it, or Cycles has none of them.
STRUCTURE = {
    "NodeFrame", "NodeGroupInput", "NodeGroupOutput", "NodeReroute", "ShaderNodeGroup", "ShaderNodeCustomGroup",
    "ShaderNodeOutputMaterial", "ShaderNodeOutputWorld", "ShaderNodeOutputLight",
    "ShaderNodeOutputLineStyle", "ShaderNodeUVAlongStroke",
}  # fmt: skip


_CHOICE = "choice"  #: In names of materials.


@dataclass(frozen=True)
class NodeState:
    """Of one class of nodes."""

    label: str
    outputs: tuple[str, ...]
    reports: tuple[str, ...]  #: What is said of it, with the default values of its inputs; empty: it is drawn.
    by_choice: tuple[str, ...] = ()  #: Of shaders: what else is said, of other distributions and of shares above 0.

    def said(self) -> str:
        """In a table."""
        said = "; ".join(report.removeprefix(f"{self.label} ") for report in self.reports) or "as in Cycles"
        more = "; ".join(report.removeprefix(f"{self.label}'s ") for report in self.by_choice)
        return f"{said}; by choice: {more}" if more else said


def node_classes() -> dict[str, str]:
    """Labels by identifier, of all nodes that a material's tree takes."""
    trial = bpy.data.materials.new("Trial")
    use_nodes(trial)
    found = {}
    for name in sorted(set(dir(bpy.types))):
        if not name.startswith("ShaderNode") or name in STRUCTURE:
            continue
        try:
            node = trial.node_tree.nodes.new(name)
        except RuntimeError:
            continue  # a base class, or of another kind of tree
        found[name] = node.bl_label
    bpy.data.materials.remove(trial)
    return found


def node_states() -> dict[str, NodeState]:
    """By identifier; renders one small picture in which each output has a material of its own."""
    scene = empty_scene()
    scene.render.resolution_x, scene.render.resolution_y = 4, 4
    classes = node_classes()
    outputs = {name: _add_materials(name) for name in classes}
    shown = [material for material in bpy.data.materials if material.name.startswith("ShaderNode")]
    mesh = bpy.data.meshes.new("Faces")
    around = ((0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5))
    corners = [(face + x, y, 0.0) for face in range(len(shown)) for x, y in around]
    mesh.from_pydata(corners, [], [tuple(range(4 * face, 4 * face + 4)) for face in range(len(shown))])
    mesh.uv_layers.new(name="UVMap")
    for material in shown:
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", list(range(len(shown))))
    add("Faces", mesh)
    tyndall_pixels(scene)
    said: dict[str, set[str]] = {name: set() for name in classes}
    by_choice: dict[str, set[str]] = {name: set() for name in classes}
    package = type(scene.tyndall).__module__.rpartition(".properties")[0]  # it may run under two names
    statistics = sys.modules[f"{package}.last_render"].statistics_of(scene.name)
    for line in statistics["reports"]:
        culprit, _, text = str(line).partition('": ')
        name, _, which = culprit.removeprefix('Material "').partition(".")
        if name in said and text:
            (by_choice if which.startswith(_CHOICE) else said)[name].update(text.split("; "))
    return {
        name: NodeState(label, outputs[name], tuple(sorted(said[name])), tuple(sorted(by_choice[name] - said[name])))
        for name, label in classes.items()
    }


def _add_materials(name: str) -> tuple[str, ...]:
    """One for each output, which its name tells."""
    first = bpy.data.materials.new(f"{name}.0")
    use_nodes(first)
    node = first.node_tree.nodes.new(name)
    outputs = [
        socket.name for socket in node.outputs if not getattr(socket, "is_unavailable", False) and socket.enabled
    ]
    if not outputs:  # an output node
        return ()
    is_shader = node.outputs[0].type == "SHADER" and "Volume" not in name
    for index, output in enumerate(outputs):
        material = first if index == 0 else bpy.data.materials.new(f"{name}.{index}")
        _show(material, name, output)
    if is_shader:
        shown = _show(bpy.data.materials.new(f"{name}.{_CHOICE}"), name, outputs[0])
        for socket in shown.inputs:
            if socket.type == "VALUE" and socket.default_value == 0.0:
                socket.default_value = 0.5
        for which in ("distribution", "model"):
            kinds = shown.bl_rna.properties.get(which)
            for kind in [item.identifier for item in kinds.enum_items] if kinds else ():
                setattr(_show(bpy.data.materials.new(f"{name}.{_CHOICE} {kind}"), name, outputs[0]), which, kind)
    return tuple(outputs)


def _show(material: bpy.types.Material, name: str, output: str) -> bpy.types.Node:
    use_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    end, node = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(name)
    socket = node.outputs[output]
    if output in {"Volume", "Displacement"}:
        tree.links.new(socket, end.inputs[output])
    elif socket.type == "VECTOR" and "Displacement" in name:
        tree.links.new(socket, end.inputs["Displacement"])
    elif socket.type == "SHADER":
        tree.links.new(socket, end.inputs["Volume" if "Volume" in name else "Surface"])
    else:
        emission = tree.nodes.new("ShaderNodeEmission")
        tree.links.new(socket, emission.inputs["Color"])
        tree.links.new(emission.outputs[0], end.inputs["Surface"])
    return node


#: Which test holds what is no value, or a value that only one domain has; by node.
TESTS = {
    **dict.fromkeys(
        [
            "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfMetallic",
            "ShaderNodeBsdfPrincipled", "ShaderNodeBsdfToon", "ShaderNodeBsdfTranslucent", "ShaderNodeBsdfVelvet",
        ],
        "test_closure_agreement",
    ),
    **dict.fromkeys(
        ["ShaderNodeAddShader", "ShaderNodeMixShader", "ShaderNodeBsdfTransparent", "ShaderNodeEmission"],
        "test_material_agreement",
    ),
    **dict.fromkeys(["ShaderNodeValue", "ShaderNodeVertexColor"], "test_sync"),
    "ShaderNodeBsdfSheen": "test_sheen_agreement",
    "ShaderNodeSubsurfaceScattering": "test_subsurface_agreement",
    "ShaderNodeHairInfo": "test_hair_agreement",
    "ShaderNodeParticleInfo": "test_particle_info",
    "ShaderNodePointInfo": "test_point_info",
    **dict.fromkeys(["ShaderNodeBsdfHair", "ShaderNodeBsdfHairPrincipled"], "test_hair_shaders"),
    "ShaderNodeHoldout": "test_holdouts",
    **dict.fromkeys(["ShaderNodeAmbientOcclusion", "ShaderNodeBevel"], "test_surroundings_nodes"),
    **dict.fromkeys(["ShaderNodeDisplacement", "ShaderNodeVectorDisplacement"], "test_normal_agreement"),
    **dict.fromkeys(
        [
            "ShaderNodeVolumeAbsorption", "ShaderNodeVolumeCoefficients", "ShaderNodeVolumePrincipled",
            "ShaderNodeVolumeScatter",
        ],
        "test_media_agreement",
    ),
}  # fmt: skip
#: Of worlds and lights: a material has no use for them.
ELSEWHERE = {
    "ShaderNodeOutputAOV": "passes: test_aov_nodes",
    "ShaderNodeScript": "scripts are not run, their outputs are mid grey",
    "ShaderNodeBackground": "worlds: test_world_agreement",
    "ShaderNodeTexSky": "worlds: test_sky_agreement",
    "ShaderNodeVolumeInfo": "media with grids: test_volumes_agreement",
}
