# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of a point, its object and the asking ray, as set-ups of patch_nodes.py."""

from __future__ import annotations

from collections.abc import Callable

from .patch_nodes import Link, New, Socket
from .small_scenes import node

Build = Callable[[New, Link], Socket]


def output(kind: str, name: str, **properties: object) -> Build:
    def build(new: New, _: Link) -> Socket:
        created = new(kind)
        for key, value in properties.items():
            setattr(created, key, value)
        return next(socket for socket in created.outputs if socket.identifier == name)

    return build


def transformed(kind: str, source: str, target: str) -> Build:
    def build(new: New, link: Link) -> Socket:
        created = new("ShaderNodeVectorTransform")
        created.vector_type, created.convert_from, created.convert_to = kind, source, target
        geometry = new("ShaderNodeNewGeometry")
        link(geometry.outputs["Normal" if kind == "NORMAL" else "Position"], created.inputs[0])
        return created.outputs[0]

    return build


def weighed(kind: str, name: str, **inputs: float) -> Build:
    return lambda new, _: node(new, kind, **inputs).outputs[name]


def wires(new: New) -> Socket:
    created = node(new, "ShaderNodeWireframe", Size=0.4)
    created.use_pixel_size = True
    return created.outputs[0]


INPUT_SETUPS: dict[str, Build] = {
    **{
        f"coordinate {name}": output("ShaderNodeTexCoord", name)
        for name in ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection")
    },
    **{
        f"geometry {name}": output("ShaderNodeNewGeometry", name)
        for name in ("Position", "Normal", "Tangent", "True Normal", "Incoming", "Backfacing", "Pointiness")
    },
    **{
        f"object {name}": output("ShaderNodeObjectInfo", name)
        for name in ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random")
    },
    **{
        f"camera {name}": output("ShaderNodeCameraData", name)
        for name in ("View Vector", "View Z Depth", "View Distance")
    },
    **{
        f"attribute {name}": output("ShaderNodeAttribute", "Vector", attribute_name=name)
        for name in ("warmth", "flow", "step", "Other", "nothing")
    },
    "attribute as a number": output("ShaderNodeAttribute", "Fac", attribute_name="flow"),
    "other UV map": output("ShaderNodeUVMap", "UV", uv_map="Other"),
    "radial tangent": output("ShaderNodeTangent", "Tangent", direction_type="RADIAL", axis="X"),
    "UV tangent": output("ShaderNodeTangent", "Tangent", direction_type="UV_MAP", uv_map="Other"),
    **{
        f"{kind.lower()} {source.lower()} to {target.lower()}": transformed(kind, source, target)
        for kind in ("POINT", "VECTOR", "NORMAL")
        for source, target in (("WORLD", "OBJECT"), ("OBJECT", "CAMERA"), ("CAMERA", "WORLD"))
    },
    "fresnel": weighed("ShaderNodeFresnel", "Fac", IOR=1.3),
    "fresnel of less": weighed("ShaderNodeFresnel", "Fac", IOR=0.8),
    "layer weight": weighed("ShaderNodeLayerWeight", "Fresnel", Blend=0.3),
    "facing": weighed("ShaderNodeLayerWeight", "Facing", Blend=0.3),
    "facing much": weighed("ShaderNodeLayerWeight", "Facing", Blend=0.8),
    **{
        f"{name.lower()} falloff": weighed("ShaderNodeLightFalloff", name, Strength=0.01, Smooth=200.0)
        for name in ("Quadratic", "Linear", "Constant")
    },
    "hard falloff": weighed("ShaderNodeLightFalloff", "Linear", Strength=0.1),
    **{
        f"ray {name}": output("ShaderNodeLightPath", name)
        for name in ("Is Camera Ray", "Is Shadow Ray", "Is Diffuse Ray", "Ray Length", "Ray Depth")
    },
    "wireframe in metres": lambda new, _: node(new, "ShaderNodeWireframe", Size=0.01).outputs[0],
    "wireframe in pixels": lambda new, _: wires(new),
}
