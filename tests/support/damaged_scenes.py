# SPDX-License-Identifier: GPL-3.0-or-later
r"""Scenes with something broken in them, as files in the wild have; and the process that renders them in a row.

Each takes a sound scene (floor, wall, a cube, a sun, a fog box, a camera) and damages one to three things, drawn by its
seed. A damage says whose name a user must read to find it: in a report of the statistics, or in the error.

``python -m support.damaged_scenes FIRST LAST`` prints one JSON object per line: {"seed": 7, "begins": true}, then what
came of it. A crash leaves a line that only begins.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nan, pi
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from support.agreement_scenes import Arrangement, build, diffuse

Random = np.random.Generator
Scene = bpy.types.Scene

#: A picture may be black, or absent, after these; after all others the cube must still be lit.
HIDES_ALL = frozenset({"camera", "frame"})


@dataclass(frozen=True)
class Damage:
    """One thing that is wrong."""

    name: str
    apply: Callable[[Scene, Random], None]
    culprit: str | None = None  #: Name that a report or the error must contain; None: nothing to report.
    of: str = "object"  #: What it is about: two damages of the same kind never meet, except objects and meshes.


DAMAGES: list[Damage] = []


def damage(name: str, culprit: str | None = None, of: str = "object") -> Callable[..., Callable[..., None]]:
    """Enter a function into the list."""

    def enter(
        function: Callable[[Scene, Random], None],
    ) -> Callable[[Scene, Random], None]:
        DAMAGES.append(Damage(name, function, culprit, of))
        return function

    return enter


def _mesh(name: str, points: np.ndarray, faces: list[tuple[int, ...]]) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0.0, 0.0, 0.0)] * len(points), [], faces)
    mesh.vertices.foreach_set("co", np.asarray(points, np.float32).ravel())  # from_pydata would refuse some of them
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


def _soup(random: Random, triangles: int = 40) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    points = random.normal(size=(triangles * 3, 3)).astype(np.float32) * 0.4 + (
        1.4,
        1.5,
        2.2,
    )
    return points.astype(np.float32), [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(triangles)]


def _spoiled_soup(name: str, random: Random, value: float) -> bpy.types.Object:
    points, faces = _soup(random)
    points[random.random(points.shape) < random.choice([0.002, 0.1, 1.0])] = value
    points[0, 0] = value
    return _mesh(name, points, faces)


# --- meshes ----------------------------------------------------------------------------------------------------------
@damage("vertices that are not a number", "NaN Mesh")
def _(_scene: Scene, random: Random) -> None:
    _spoiled_soup("NaN Mesh", random, nan)


@damage("vertices at infinity", "Infinite Mesh")
def _(_scene: Scene, random: Random) -> None:
    _spoiled_soup("Infinite Mesh", random, float(random.choice([inf, -inf])))


@damage("vertices whose squares overflow", None)
def _(_scene: Scene, random: Random) -> None:
    _spoiled_soup("Huge Mesh", random, float(random.choice([1e15, -1e25, 3e38])))


@damage("a mesh of nothing", None)
def _(_scene: Scene, random: Random) -> None:
    _mesh("Empty Mesh", np.zeros((int(random.integers(0, 3)), 3)), [])


@damage("triangles without an area", None)
def _(_scene: Scene, random: Random) -> None:
    points, faces = _soup(random)
    points[1::3], points[2::3] = (
        points[0::3],
        points[0::3] + random.choice([0.0, 1e-30, 1e-6]),
    )
    _mesh("Flat Mesh", points, faces)


@damage("UVs that are not a number", None)
def _(_scene: Scene, random: Random) -> None:
    made = _mesh("NaN UV", *_soup(random))
    layer = made.data.uv_layers.new(name="UVMap")
    layer.data.foreach_set("uv", np.full(len(made.data.loops) * 2, nan, np.float32))
    made.data.materials.append(_textured(bpy.data.images.new("White", 4, 4)))


@damage("more material slots asked for than there are", None)
def _(_scene: Scene, random: Random) -> None:
    made = _mesh("Wrong Slots", *_soup(random))
    made.data.polygons.foreach_set(
        "material_index",
        random.integers(0, 30000, len(made.data.polygons)).astype(np.int32),
    )


@damage("twenty thousand slivers in one place", None)
def _(_scene: Scene, random: Random) -> None:
    points = random.normal(size=(3 * 20000, 3)).astype(np.float32) * (
        1e-5,
        1e-5,
        1.0,
    ) + (1.5, 1.5, 1.5)
    _mesh("Slivers", points, [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(20000)])


# --- objects ---------------------------------------------------------------------------------------------------------
@damage("a scale of zero", None)
def _(_scene: Scene, random: Random) -> None:
    scale = np.where(random.random(3) < 0.5, 0.0, 1.0)
    scale[random.integers(3)] = 0.0
    _mesh("No Scale", *_soup(random)).scale = scale


@damage("a matrix that is not a number", "NaN Object")
def _(_scene: Scene, random: Random) -> None:
    made = _mesh("NaN Object", *_soup(random))
    made.location[int(random.integers(3))] = nan
    made.scale[int(random.integers(3))] = float(random.choice([nan, 1.0]))


@damage("an object at infinity", "Lost Object")
def _(_scene: Scene, random: Random) -> None:
    _mesh("Lost Object", *_soup(random)).location[int(random.integers(3))] = float(random.choice([inf, -inf]))


@damage("scales from tiny to huge", None)
def _(_scene: Scene, random: Random) -> None:
    for exponent in (-38, -20, 20):
        _mesh(f"Scale 1e{exponent}", *_soup(random)).scale = (10.0**exponent,) * 3


@damage("an instance of nothing, and one of an empty collection", None)
def _(scene: Scene, _random: Random) -> None:
    for name, collection in (
        ("Instance of None", None),
        ("Instance of Nothing", bpy.data.collections.new("Nothing")),
    ):
        made = bpy.data.objects.new(name, None)
        made.instance_type, made.instance_collection = "COLLECTION", collection
        scene.collection.objects.link(made)


@damage("instances under a scale of zero and of not a number", "Shared")
def _(scene: Scene, random: Random) -> None:
    inside = bpy.data.collections.new("Shared")
    inside.objects.link(bpy.data.objects.new("Shared", _mesh("Shared", *_soup(random)).data))
    for name, scale in (("Flat Instance", 0.0), ("NaN Instance", nan)):
        made = bpy.data.objects.new(name, None)
        made.instance_type, made.instance_collection, made.scale = (
            "COLLECTION",
            inside,
            (1, scale, 1),
        )
        scene.collection.objects.link(made)


@damage("geometry nodes without an output", None)
def _(_scene: Scene, random: Random) -> None:
    made = _mesh("No Output", *_soup(random))
    made.modifiers.new("Nodes", "NODES").node_group = bpy.data.node_groups.new("Void", "GeometryNodeTree")


# --- materials and images --------------------------------------------------------------------------------------------
def _textured(image: bpy.types.Image | None) -> bpy.types.Material:
    material = diffuse((0.5, 0.5, 0.5))
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    surface = next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    material.node_tree.links.new(texture.outputs[0], surface.inputs[0])
    return material


@damage("an image whose file is gone", "gone.png")
def _(_scene: Scene, random: Random) -> None:
    image = bpy.data.images.new("gone.png", 8, 8)
    image.source, image.filepath = "FILE", "//nowhere/gone.png"
    _mesh("Textured", *_soup(random)).data.materials.append(_textured(image))


@damage("an image that is not an image", "broken.png")
def _(_scene: Scene, random: Random) -> None:
    path = Path(bpy.app.tempdir) / "broken.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + random.bytes(200))
    image = bpy.data.images.new("broken.png", 8, 8)
    image.source, image.filepath = "FILE", str(path)
    _mesh("Textured", *_soup(random)).data.materials.append(_textured(image))


@damage("a texture node without an image", None)
def _(_scene: Scene, random: Random) -> None:
    _mesh("Untextured", *_soup(random)).data.materials.append(_textured(None))


@damage("pixels that are not a number", "NaN Image")
def _(_scene: Scene, random: Random) -> None:
    image = bpy.data.images.new("NaN Image", 8, 8, float_buffer=True)
    pixels = random.random(8 * 8 * 4).astype(np.float32)
    pixels[random.integers(0, 256, 20)] = random.choice([nan, inf])
    image.pixels.foreach_set(pixels)
    _mesh("Textured", *_soup(random)).data.materials.append(_textured(image))


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
    _mesh("Glow", *_soup(random)).data.materials.append(material)


@damage("a material without an output", None)
def _(_scene: Scene, random: Random) -> None:
    material = bpy.data.materials.new("No Output")
    material.use_nodes = True
    material.node_tree.nodes.clear()
    _mesh("No Output", *_soup(random)).data.materials.append(material)


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
                "ShaderNodeBsdfHair",
            ]
        )
    )
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(tree.nodes.new(kind).outputs[0], output.inputs["Surface"])
    _mesh("Odd", *_soup(random)).data.materials.append(material)


@damage("an empty node group", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    group = material.node_tree.nodes.new("ShaderNodeGroup")
    group.node_tree = [None, bpy.data.node_groups.new("Hollow", "ShaderNodeTree")][int(random.integers(2))]
    _mesh("Grouped", *_soup(random)).data.materials.append(material)


# --- lights and the world --------------------------------------------------------------------------------------------
def _light(name: str, kind: str, location: tuple[float, float, float] = (1.5, 0.0, 3.0)) -> bpy.types.Object:
    made = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
    made.location = location
    bpy.context.scene.collection.objects.link(made)
    return made


@damage("a light of no finite power", "Mad Light", "light")
def _(_scene: Scene, random: Random) -> None:
    data = _light("Mad Light", str(random.choice(["SUN", "POINT", "SPOT"]))).data
    data.energy = float(random.choice([nan, inf, -inf]))


@damage("a colour that is not a number", "Mad Light", "light")
def _(_scene: Scene, random: Random) -> None:
    _light("Mad Light", str(random.choice(["SUN", "POINT", "SPOT"]))).data.color = (
        1.0,
        nan,
        1.0,
    )


@damage("a light nowhere", "Lost Light", "light")
def _(_scene: Scene, random: Random) -> None:
    made = _light("Lost Light", str(random.choice(["SUN", "POINT", "SPOT"])))
    made.matrix_world = Matrix(((nan,) * 4,) * 4)
    made.location = (float(random.choice([nan, inf])), 0, 0)


@damage("lights scaled to nothing", None, "light")
def _(_scene: Scene, random: Random) -> None:
    for kind in ("SUN", "POINT", "SPOT"):
        _light(f"Flat {kind}", kind).scale = np.where(random.random(3) < 0.6, 0.0, 1.0)


@damage("lights of absurd sizes", None, "light")
def _(_scene: Scene, random: Random) -> None:
    _light("Wide Sun", "SUN").data.angle = pi
    _light("Wide Point", "POINT").data.shadow_soft_size = float(random.choice([1e-30, 50.0, 1e6]))
    spot = _light("Wide Spot", "SPOT").data
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
        _light("Touching", "POINT", tuple(location)).data.shadow_soft_size = 0.0


@damage("negative light", None, "light")
def _(_scene: Scene, _random: Random) -> None:
    _light("Darkness", "POINT").data.energy = -5.0


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


# --- camera and frame ------------------------------------------------------------------------------------------------
@damage("a camera that is not a number", "Camera", "camera")
def _(scene: Scene, random: Random) -> None:
    scene.camera.location[int(random.integers(3))] = float(random.choice([nan, inf]))


@damage("a camera without a scale", "Camera", "camera")
def _(scene: Scene, _random: Random) -> None:
    scene.camera.scale = (0, 0, 0)


@damage("clipping the wrong way round", None, "camera")
def _(scene: Scene, random: Random) -> None:
    camera = scene.camera.data
    camera.clip_start, camera.clip_end = [(100.0, 1.0), (5.0, 5.0), (1e-6, 1e30)][int(random.integers(3))]


@damage("a lens of absurd length", None, "camera")
def _(scene: Scene, random: Random) -> None:
    scene.camera.data.lens = float(random.choice([1.0, 1e5, 1e9]))


@damage("an orthographic camera of no or endless width", None, "camera")
def _(scene: Scene, random: Random) -> None:
    scene.camera.data.type = "ORTHO"
    scene.camera.data.ortho_scale = float(random.choice([0.0, 1e-7, 1e30]))


@damage("a camera that is no camera", "Floor", "camera")
def _(scene: Scene, _random: Random) -> None:
    scene.camera = bpy.data.objects["Floor"]


@damage("a border around nothing", None, "frame")
def _(scene: Scene, random: Random) -> None:
    settings = scene.render
    settings.use_border, settings.use_crop_to_border = True, bool(random.integers(2))
    settings.border_min_x = settings.border_max_x = 0.5
    settings.border_min_y, settings.border_max_y = [(0.9, 0.1), (0.5, 0.5), (0.0, 1.0)][int(random.integers(3))]


@damage("the smallest frame", None, "frame")
def _(scene: Scene, random: Random) -> None:
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.resolution_percentage = int(random.choice([1, 100]))


@damage("pixels of another shape", None, "frame")
def _(scene: Scene, random: Random) -> None:
    scene.render.pixel_aspect_x = float(random.choice([1.0, 200.0]))
    scene.render.pixel_aspect_y = float(random.choice([2.0, 200.0]))


# --- settings --------------------------------------------------------------------------------------------------------
@damage("settings at their limits", None, "settings")
def _(scene: Scene, random: Random) -> None:
    ours = scene.tyndall
    ours.seed = 2**31 - 1
    ours.filter_width_px = float(random.choice([0.0, 1e9]))
    ours.thread_count = int(random.choice([1, 100000]))
    ours.shafts.error_target = float(random.choice([0.0, 1.0]))
    ours.shafts.resolution = int(random.choice([1, 16, 10**6]))
    ours.shafts.light_samples, ours.shafts.world_samples = 1, 0


@damage("a scale of units that means nothing here", None, "settings")
def _(scene: Scene, random: Random) -> None:
    scene.unit_settings.scale_length = float(random.choice([1e-9, 1e4]))


@damage("a frame far beyond the last", None, "settings")
def _(scene: Scene, _random: Random) -> None:
    scene.frame_set(1_000_000)


METHODS = ("EXACT", "EPIPOLAR", "SHADOW_MAP")


def damages_of(seed: int) -> tuple[Damage, ...]:
    """One damage for the first seeds, so that each is met alone; two or three of different kinds after that."""
    if seed < len(DAMAGES):
        return (DAMAGES[seed],)
    random = np.random.default_rng(seed)
    chosen: list[Damage] = []
    for index in random.permutation(len(DAMAGES))[: 2 + seed % 2]:
        if DAMAGES[index].of == "object" or all(DAMAGES[index].of != other.of for other in chosen):
            chosen.append(DAMAGES[index])
    return tuple(chosen)


def damaged(seed: int) -> Scene:
    """Build the scene of a seed."""
    scene = build(Arrangement(light="sun", medium="camera inside", occluder="none"), 32, 18)
    bpy.ops.mesh.primitive_cube_add(size=1.2, location=(0.0, 0.0, 1.0))
    bpy.context.object.name = "Sound Cube"
    bpy.context.object.data.materials.append(diffuse((0.9, 0.9, 0.9)))
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples = 1
    scene.tyndall.shafts.method = METHODS[seed % 3]
    scene.tyndall.shafts.light_samples = scene.tyndall.shafts.world_samples = 4
    random = np.random.default_rng(1000 + seed)
    for each in damages_of(seed):
        each.apply(scene, random)
    bpy.context.view_layer.update()
    return scene


def outcome(seed: int) -> dict[str, object]:
    """Render a seed's scene; say what came of it."""
    from addon import last_render  # noqa: PLC0415  after the path is set
    from support.cycles_reference import rendered_pixels  # noqa: PLC0415

    scene = damaged(seed)
    name = scene.name
    result: dict[str, object] = {
        "seed": seed,
        "damages": [each.name for each in damages_of(seed)],
        "error": "",
    }
    try:
        pixels = rendered_pixels(scene)
        result["is_finite"] = bool(np.isfinite(pixels).all())
        result["brightest"] = float(np.nan_to_num(pixels).max())
    except RuntimeError as error:
        result["error"] = str(error)
    statistics = last_render.statistics_of(name) or {}
    result["reports"] = statistics.get("reports", [])
    return result


def main() -> None:
    """Render the seeds of a range; the output is for the process that started this one."""
    import addon  # noqa: PLC0415  after the path is set

    first, last = (int(argument) for argument in sys.argv[-2:])
    # Blender writes to the same descriptor as Python: keep a copy for ourselves, and send the rest to the error output.
    lines = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    addon.register()
    for seed in range(first, last):
        print(json.dumps({"seed": seed, "begins": True}), file=lines)
        print(json.dumps(outcome(seed)), file=lines)
    addon.unregister()


if __name__ == "__main__":
    main()
