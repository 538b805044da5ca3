# SPDX-License-Identifier: GPL-3.0-or-later
"""Every way of every node that computes, for flat_nodes.py: with all its inputs varying."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import bpy

from .flat_nodes import Inputs, Setup, Socket, with_inputs

NUMBERS = ("number 0", "number 1", "number 2")
VECTORS = ("vector 0", "vector 1", "vector 2")


def choices(kind: str, name: str) -> list[str]:
    """Identifiers that a property of a node may have in this Blender."""
    return [item.identifier for item in getattr(bpy.types, kind).bl_rna.properties[name].enum_items]


def _exists(kind: str) -> bool:
    return hasattr(bpy.types, kind)


#: Where functions are steep, inputs stay where Cycles' own rounding does not show.
_RANGE_OF = {
    "EXPONENT": (-3.0, 3.0),
    "POWER": (0.0, 3.0),
    "SINH": (-3.0, 3.0),
    "COSH": (-3.0, 3.0),
    "TANGENT": (-1.3, 1.3),
    "LOGARITHM": (0.05, 9.0),
}


def _math() -> Iterable[Setup]:
    for operation in choices("ShaderNodeMath", "operation"):
        low, high = _RANGE_OF.get(operation, (-2.0, 3.0))
        build = with_inputs("ShaderNodeMath", *NUMBERS, operation=operation)
        yield Setup(f"Math {operation}", build, low, high, is_special=operation != "LOGARITHM")
    yield Setup("Math clamped", with_inputs("ShaderNodeMath", *NUMBERS, operation="ADD", use_clamp=True))


def _vector_math() -> Iterable[Setup]:
    for operation in choices("ShaderNodeVectorMath", "operation"):
        low, high = _RANGE_OF.get(operation, (-2.0, 3.0))
        sources = VECTORS
        if operation == "SCALE":
            sources = ("vector 0", "number 0")
        elif operation == "REFRACT":
            sources = ("vector 0", "vector 1", "number 0")
        yield Setup(
            f"Vector Math {operation}", with_inputs("ShaderNodeVectorMath", *sources, operation=operation), low, high
        )


def _ranges() -> Iterable[Setup]:
    for kind in choices("ShaderNodeMapRange", "interpolation_type"):
        for is_clamped in (False, True):
            options = {"interpolation_type": kind, "clamp": is_clamped}
            suffix = f"{kind}{' clamped' if is_clamped else ''}"
            numbers = ("number 0", "number 1", "number 2", "number 3", "number 0", "number 1")
            yield Setup(f"Map Range {suffix}", with_inputs("ShaderNodeMapRange", *numbers, **options))
            vectors = ("vector 0", "vector 1", "vector 2", "vector 3", "vector 0", "vector 1")
            yield Setup(
                f"Map Range of vectors {suffix}",
                with_inputs("ShaderNodeMapRange", *vectors, data_type="FLOAT_VECTOR", **options),
            )
    for kind in choices("ShaderNodeClamp", "clamp_type"):
        yield Setup(f"Clamp {kind}", with_inputs("ShaderNodeClamp", *NUMBERS, clamp_type=kind))


def _rotations() -> Iterable[Setup]:
    for kind in choices("ShaderNodeVectorRotate", "rotation_type"):
        for invert in (False, True):
            last = {"AXIS_ANGLE": ("vector 2", "number 0"), "EULER_XYZ": ("vector 2",)}.get(kind, ("number 0",))
            yield Setup(
                f"Vector Rotate {kind}{' back' if invert else ''}",
                with_inputs("ShaderNodeVectorRotate", "vector 0", "vector 1", *last, rotation_type=kind, invert=invert),
            )
    for kind in choices("ShaderNodeMapping", "vector_type"):
        sources = ["vector 0", "vector 1", "vector 2", "vector 3"]
        if kind in {"VECTOR", "NORMAL"}:
            sources.remove("vector 1")  # which has no location
        yield Setup(f"Mapping {kind}", with_inputs("ShaderNodeMapping", *sources, vector_type=kind))


def _normal(output: int) -> Callable[[Inputs], Socket]:
    def build(inputs: Inputs) -> Socket:
        node = inputs.new("ShaderNodeNormal")
        node.outputs[0].default_value = (0.6, -0.3, 0.9)
        inputs.link(inputs.vector(0), node.inputs[0])
        return node.outputs[output]

    return build


def _parts() -> Iterable[Setup]:
    yield Setup("Combine XYZ", with_inputs("ShaderNodeCombineXYZ", *NUMBERS))
    for index, axis in enumerate("XYZ"):
        yield Setup(f"Separate XYZ {axis}", with_inputs("ShaderNodeSeparateXYZ", "vector 0", output=index))
    yield Setup("Normal direction", _normal(0))
    yield Setup("Normal dot", _normal(1))


def _mixes() -> Iterable[Setup]:
    for blend in choices("ShaderNodeMix", "blend_type"):
        yield Setup(
            f"Mix {blend}",
            with_inputs("ShaderNodeMix", "number 0", "colour 0", "colour 1", data_type="RGBA", blend_type=blend),
        )
        yield Setup(
            f"Mix {blend} unclamped",
            with_inputs(
                "ShaderNodeMix",
                *("number 0", "colour 0", "colour 1"),
                data_type="RGBA",
                blend_type=blend,
                clamp_factor=False,
            ),
            0.0,
            1.5,
        )
        yield Setup(
            f"Old Mix {blend}",
            with_inputs("ShaderNodeMixRGB", "number 0", "colour 0", "colour 1", blend_type=blend, use_clamp=True),
        )
    for is_clamped in (False, True):
        suffix = " clamped" if is_clamped else ""
        options = {"clamp_factor": is_clamped}
        yield Setup(f"Mix of numbers{suffix}", with_inputs("ShaderNodeMix", *NUMBERS, data_type="FLOAT", **options))
        for mode, factor in (("UNIFORM", "number 0"), ("NON_UNIFORM", "vector 2")):
            sources = (factor, "vector 0", "vector 1")
            yield Setup(
                f"Mix of vectors {mode}{suffix}",
                with_inputs("ShaderNodeMix", *sources, data_type="VECTOR", factor_mode=mode, **options),
            )
    yield Setup(
        "Mix clamped result",
        with_inputs("ShaderNodeMix", "number 0", "colour 0", "colour 1", data_type="RGBA", clamp_result=True),
    )


def _adjustments() -> Iterable[Setup]:
    yield Setup("Invert", with_inputs("ShaderNodeInvert", "number 0", "colour 0"))
    yield Setup("Gamma", with_inputs("ShaderNodeGamma", "colour 0", "number 0"))
    yield Setup("Bright/Contrast", with_inputs("ShaderNodeBrightContrast", "colour 0", "number 0", "number 1"))
    numbers = ("number 0", "number 1", "number 2", "number 3")
    # Up to 3.x a hue below -0.5 is none.
    yield Setup("Hue/Saturation", with_inputs("ShaderNodeHueSaturation", *numbers, "colour 0"), -0.5)
    yield Setup("Hue/Saturation in range", with_inputs("ShaderNodeHueSaturation", *numbers, "colour 0"), 0.0, 1.0)
    yield Setup("RGB to BW", with_inputs("ShaderNodeRGBToBW", "colour 0"))
    yield Setup("Blackbody", with_inputs("ShaderNodeBlackbody", "number 0"), 700.0, 13000.0)
    yield Setup("Wavelength", with_inputs("ShaderNodeWavelength", "number 0"), 370.0, 790.0)


def _models() -> Iterable[Setup]:
    for mode in ("RGB", "HSV", "HSL"):
        for low, high in ((0.0, 1.0), (-2.0, 3.0)):
            suffix = f"{mode}{'' if low == 0.0 else ' beyond'}"
            if mode == "HSV" or low == 0.0:
                yield Setup(f"Combine {suffix}", with_inputs("ShaderNodeCombineColor", *NUMBERS, mode=mode), low, high)
            for index, channel in enumerate(mode):
                yield Setup(
                    f"Separate {suffix} {channel}",
                    with_inputs("ShaderNodeSeparateColor", "colour 0", mode=mode, output=index),
                    low,
                    high,
                )
    for mode in ("RGB", "HSV"):  # up to 3.2
        if _exists(f"ShaderNodeCombine{mode}"):
            yield Setup(f"Old Combine {mode}", with_inputs(f"ShaderNodeCombine{mode}", *NUMBERS), 0.0, 1.0)
            yield Setup(f"Old Separate {mode}", with_inputs(f"ShaderNodeSeparate{mode}", "colour 0"), 0.0, 1.0)


def _ramp(interpolation: str, mode: str, output: int) -> Callable[[Inputs], Socket]:
    def build(inputs: Inputs) -> Socket:
        node = inputs.new("ShaderNodeValToRGB")
        ramp = node.color_ramp
        ramp.color_mode = mode
        if mode == "RGB":
            ramp.interpolation = interpolation
        else:
            ramp.hue_interpolation = interpolation
        ramp.elements[0].position, ramp.elements[0].color = 0.1, (0.9, 0.2, 0.3, 0.5)
        ramp.elements[1].position, ramp.elements[1].color = 0.83, (0.1, 0.4, 0.9, 1.0)
        ramp.elements.new(0.4).color = (0.3, 0.8, 0.1, 0.2)
        inputs.link(inputs.number(0), node.inputs[0])
        return node.outputs[output]

    return build


def _curve(kind: str, source: str, *, extrapolates: bool) -> Callable[[Inputs], Socket]:
    def build(inputs: Inputs) -> Socket:
        node = inputs.new(kind)
        mapping = node.mapping
        mapping.extend = "EXTRAPOLATED" if extrapolates else "HORIZONTAL"
        for index, curve in enumerate(mapping.curves):
            curve.points.new(0.3 + 0.1 * index, 0.7 - 0.15 * index)
            curve.points[0].location = (0.05 * index, 0.1)
        mapping.update()
        inputs.link(inputs.number(1), node.inputs[0])
        inputs.link(inputs.number(0) if source == "number" else inputs.colour(0), node.inputs[1])
        return node.outputs[0]

    return build


def _tables() -> Iterable[Setup]:
    for interpolation in ("LINEAR", "CONSTANT", "EASE", "CARDINAL", "B_SPLINE"):
        yield Setup(f"Color Ramp {interpolation}", _ramp(interpolation, "RGB", 0), -0.2, 1.2)
    for mode in ("HSV", "HSL"):
        for interpolation in ("NEAR", "FAR", "CW", "CCW"):
            yield Setup(f"Color Ramp {mode} {interpolation}", _ramp(interpolation, mode, 0), -0.2, 1.2)
    yield Setup("Color Ramp alpha", _ramp("LINEAR", "RGB", 1), -0.2, 1.2)
    for kind, source in (
        ("ShaderNodeRGBCurve", "colour"),
        ("ShaderNodeVectorCurve", "colour"),
        ("ShaderNodeFloatCurve", "number"),
    ):
        for extrapolates in (False, True):
            name = f"{kind.removeprefix('ShaderNode')}{' extrapolated' if extrapolates else ''}"
            yield Setup(name, _curve(kind, source, extrapolates=extrapolates), -1.5, 2.0)


def _group(input_type: str, output_type: str) -> bpy.types.NodeTree:
    """A group that passes its input on, over borders of these types."""
    tree = bpy.data.node_groups.new(f"{input_type} to {output_type}", "ShaderNodeTree")
    if hasattr(tree, "interface"):  # from 4.0 on
        tree.interface.new_socket("In", in_out="INPUT", socket_type=input_type)
        tree.interface.new_socket("Out", in_out="OUTPUT", socket_type=output_type)
    else:
        tree.inputs.new(input_type, "In")
        tree.outputs.new(output_type, "Out")
    tree.links.new(tree.nodes.new("NodeGroupInput").outputs[0], tree.nodes.new("NodeGroupOutput").inputs[0])
    return tree


def _through_group(input_type: str, output_type: str, depth: int) -> Callable[[Inputs], Socket]:
    def build(inputs: Inputs) -> Socket:
        found = inputs.colour(0)
        for _ in range(depth):
            node = inputs.new("ShaderNodeGroup")
            node.node_tree = _group(input_type, output_type)
            inputs.link(found, node.inputs[0])
            found = node.outputs[0]
        return found

    return build


def _muted(kind: str, target: str, source: str) -> Callable[[Inputs], Socket]:
    """What passes a muted node, in a sum."""

    def build(inputs: Inputs) -> Socket:
        muted, total = inputs.new(kind), inputs.new("ShaderNodeVectorMath")
        muted.mute = True
        if target:
            inputs.link(inputs.colour(0), muted.inputs[target])
        total.inputs[0].default_value = (0.25, 0.5, 0.75)
        inputs.link(muted.outputs[source], total.inputs[0])
        inputs.link(inputs.vector(1), total.inputs[1])
        return total.outputs[0]

    return build


def _through_reroutes(inputs: Inputs) -> Socket:
    found = inputs.colour(0)
    for _ in range(3):
        node = inputs.new("NodeReroute")
        inputs.link(found, node.inputs[0])
        found = node.outputs[0]
    value = inputs.new("ShaderNodeMath")
    value.operation = "SINE"
    inputs.link(found, value.inputs[0])
    return value.outputs[0]


def _widely_used(inputs: Inputs) -> Socket:
    """Each node feeds the next one twice: two to the 60 ways lead to the first."""
    found = inputs.colour(0)
    for step in range(60):
        node = inputs.new("ShaderNodeMixRGB")
        node.inputs[0].default_value = 0.25
        node.blend_type = "DARKEN" if step % 2 else "LIGHTEN"
        inputs.link(found, node.inputs[1])
        inputs.link(found, node.inputs[2])
        found = node.outputs[0]
    return found


def _many_values(inputs: Inputs) -> Socket:
    """More numbers that are needed at once than a program has registers."""
    total = None
    numbers = []
    for step in range(70):
        node = inputs.new("ShaderNodeMath")
        node.operation = "SUBTRACT"
        node.inputs[1].default_value = 0.01 * step
        inputs.link(inputs.number(0), node.inputs[0])
        numbers.append(node.outputs[0])
    for number in reversed(numbers):
        node = inputs.new("ShaderNodeMath")
        node.operation = "MAXIMUM" if total is None else "PINGPONG"
        inputs.link(number, node.inputs[0])
        if total is not None:
            inputs.link(total, node.inputs[1])
        total = node.outputs[0]
    return total


def _graphs() -> Iterable[Setup]:
    for through in ("NodeSocketColor", "NodeSocketFloat", "NodeSocketVector"):
        for leaving in ("NodeSocketColor", "NodeSocketFloat", "NodeSocketVector"):
            name = f"group {through.removeprefix('NodeSocket')} to {leaving.removeprefix('NodeSocket')}"
            yield Setup(name, _through_group(through, leaving, 1))
    yield Setup("three groups", _through_group("NodeSocketColor", "NodeSocketFloat", 3))
    yield Setup("muted Gamma", _muted("ShaderNodeGamma", "Color", "Color"))
    yield Setup("muted RGB to BW", _muted("ShaderNodeRGBToBW", "Color", "Val"))
    yield Setup("muted RGB", _muted("ShaderNodeRGB", "", "Color"))
    yield Setup("reroutes", _through_reroutes)
    yield Setup("widely used", _widely_used)
    yield Setup("many values", _many_values, -1.0, 1.0)


GRAPH_SETUPS = [*_graphs()]
MATH_SETUPS = [*_math(), *_vector_math(), *_ranges(), *_rotations(), *_parts()]
COLOUR_SETUPS = [*_mixes(), *_adjustments(), *_models(), *_tables()]
