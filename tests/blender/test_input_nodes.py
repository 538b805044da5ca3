# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes read of a point, its object and the asking ray is what Cycles reads there."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import pytest

from addon import last_render
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.patch_nodes import Link, New, Shown, Socket, patch_scene, shown_on_patches
from support.small_scenes import add, empty_scene, material, mesh, node

#: A picture of Cycles is up to a hundredth of a pixel off its pixels' centres.
BOUND = 2e-3
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


SETUPS: dict[str, Build] = {
    **{
        f"coordinate {name}": output("ShaderNodeTexCoord", name)
        for name in ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection")
    },
    **{
        f"geometry {name}": output("ShaderNodeNewGeometry", name)
        for name in ("Position", "Normal", "Tangent", "True Normal", "Incoming", "Backfacing")
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
        f"ray {name}": output("ShaderNodeLightPath", name)
        for name in ("Is Camera Ray", "Is Shadow Ray", "Is Diffuse Ray", "Ray Length", "Ray Depth")
    },
}


@pytest.fixture(scope="module")
def shown() -> dict[str, Shown]:
    return shown_on_patches(SETUPS)


# Seen to fail with another turn of bits in the hash of an object's name.
@pytest.mark.parametrize("name", SETUPS)
def test_a_point_is_read_as_in_cycles(shown: dict[str, Shown], name: str) -> None:
    # A corner of a triangle, at which a tangent bends, may lie on the other side of a pixel's centre.
    assert shown[name].off(0.97 if "tangent" in name.lower() else 1.0) < BOUND, (shown[name].cycles, shown[name].ours)


def test_no_camera_ray_asks_twice(shown: dict[str, Shown]) -> None:
    """The others' answers are 0, which a broken reading would give, too."""
    assert (shown["ray Is Camera Ray"].ours == 1.0).all()
    for name in ("coordinate Window", "object Random", "geometry Position", "attribute flow"):
        assert shown[name].ours.std() > 0.0 or name.startswith("object")
    assert (shown["object Random"].ours > 0.0).all()


def test_instances_have_random_numbers_of_their_own() -> None:
    """As Cycles' are: each face of a plane shows a copy of a small one."""
    scene = empty_scene(6)
    scene.camera.data.ortho_scale = 6.0
    corners = [(x - 3.0, y - 3.0, 0.0) for y in range(7) for x in range(7)]
    faces = [(i, i + 1, i + 8, i + 7) for row in range(6) for i in range(7 * row, 7 * row + 6)]
    parent = add("Faces", mesh("Faces", corners, faces))
    parent.instance_type = "FACES"
    parent.show_instancer_for_render = False

    def build(new: New, link: Link) -> Socket:
        emission = new("ShaderNodeEmission")
        link(new("ShaderNodeObjectInfo").outputs["Random"], emission.inputs["Color"])
        return emission.outputs[0]

    small = [(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)]
    child = add("Copy", mesh("Copy", small, [(0, 1, 2, 3)], material("Random", build)))
    child.parent = parent
    ours = tyndall_pixels(scene)
    cycles = cycles_pixels(scene, samples=1, seed=1)
    assert ours == pytest.approx(cycles, abs=1e-5)
    assert len({round(float(value), 4) for value in ours[..., 0].ravel()}) > 30


def test_what_is_not_there_is_named_once() -> None:
    scene = patch_scene({"Parted": output("ShaderNodeNewGeometry", "Random Per Island")})
    tyndall_pixels(scene)
    reports = [
        line for line in last_render.statistics_of("Scene")["reports"] if "Parted" in line and "Geometry" in line
    ]
    assert len(reports) == 1
    assert "Random Per Island" in reports[0]
    assert bpy.data.materials["Parted"] is not None
