# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render takes of memory before its first sample, beyond meshes, textures and Embree.

Each scene is made and rendered in a process of its own, which has rendered a square with a small image before, so that
libraries are loaded (29 MiB for images): 16 x 16 pixels of one sample, so that there is next to no picture; and in
another one by an engine that has Blender find triangles and normals of the meshes, which it keeps, and does nothing
else.

  mesh       one of a million triangles, with a UV map
  meshes     a thousand of a thousand triangles each
  instances  a mesh of 1,000 triangles, 100,000 times
  sky        an equirectangular image of 4096 x 2048 floats as the world: waves, and a sun of a few pixels
  textures   nine images of 2048 x 2048 bytes in files, each on a square

Rows: of each scene the seconds of the render; data_mib, the arrays of its meshes, places and images as they are handed
over; embree_mib, what Embree held at most; peak_mib, by how much the process grew at most; blender_mib, by how much it
grew with the other engine; beyond, what was none of these, in proportion to the first two. With scripts/python:

  benchmarks/set_up_memory_bench.py --context build/logs/bench-context.json --output set_up_memory.json
"""

from __future__ import annotations

import argparse
import atexit
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray
from process_memory import forget_most_memory, memory_bytes, most_memory_bytes

import tyndall.blender
from report import Row, argument_parser, row, write_report
from tyndall import _native
from tyndall.scene_description import Image, SceneDescription

MIB = 1024.0 * 1024.0
_FOLDER = Path(tempfile.mkdtemp())
atexit.register(shutil.rmtree, _FOLDER)


def _grid(name: str, side: int, height: float = 0.1) -> bpy.types.Mesh:
    """Waves of side x side quadrilaterals, each two triangles."""
    axis = np.linspace(-1.0, 1.0, side + 1, dtype=np.float32)
    x, y = np.meshgrid(axis, axis)
    corners = np.stack([x, y, height * np.sin(9.0 * x) * np.cos(7.0 * y)], -1).reshape(-1, 3)
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1)
    faces = np.stack([first, first + 1, first + side + 2, first + side + 1], -1).astype(np.int32)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(corners))
    mesh.vertices.foreach_set("co", corners.ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    uvs = 0.5 * corners[faces.ravel(), :2] + 0.5
    mesh.uv_layers.new().data.foreach_set("uv", uvs.ravel())
    return mesh


def _add(mesh: bpy.types.Mesh) -> bpy.types.Object:
    thing = bpy.data.objects.new(mesh.name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def _mesh() -> None:
    _add(_grid("Grid", 708))


def _meshes() -> None:
    for index in range(1000):
        _add(_grid(f"Grid.{index}", 22, height=0.001 * index)).location = (index % 32, index // 32, 0.0)


def _instances() -> None:
    """On the faces of a parent."""
    small = _add(_grid("Small", 22))
    small.scale = (0.01,) * 3
    parent = _add(_grid("Places", 316))
    small.parent, parent.instance_type = parent, "FACES"
    parent.show_instancer_for_render = False


def _sky() -> None:
    image = bpy.data.images.new("Sky", 4096, 2048, float_buffer=True)
    x, y = np.meshgrid(np.linspace(0.0, 60.0, 4096), np.linspace(0.0, 40.0, 2048))
    rgba = np.ones((2048, 4096, 4), np.float32)
    rgba[..., :3] = (1.0 + 0.5 * np.sin(x) * np.cos(1.3 * y) + 0.2 * np.sin(5.0 * x + 7.0 * y))[..., None]
    rgba[1500:1508, 1000:1008] = 5e4
    image.pixels.foreach_set(rgba.ravel())
    image.update()
    tree = bpy.context.scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs[0], next(node for node in tree.nodes if node.type == "BACKGROUND").inputs[0])


def _picture(index: int, side_px: int) -> None:
    """On a square of its own."""
    image = bpy.data.images.new(f"Image {index}", side_px, side_px)
    image.generated_type = "COLOR_GRID"
    image.filepath_raw = str(_FOLDER / f"{index}.tif")
    image.file_format = "TIFF"
    image.save()
    image = bpy.data.images.load(image.filepath_raw)
    material = bpy.data.materials.new(image.name)
    material.use_nodes = True
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs[0], next(node for node in tree.nodes if node.inputs).inputs[0])
    mesh = _grid(image.name, 1)
    mesh.materials.append(material)
    _add(mesh).location = (2 * (index % 3), 2 * (index // 3), 0.0)


def _textures() -> None:
    for index in range(9):
        _picture(index, 2048)


SCENES: dict[str, Callable[[], None]] = {
    "mesh": _mesh,
    "meshes": _meshes,
    "instances": _instances,
    "sky": _sky,
    "textures": _textures,
}


def _empty() -> bpy.types.Scene:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.tyndall.pixel_samples = 1
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.camera.location = (0.0, 0.0, 40.0)
    scene.collection.objects.link(scene.camera)
    return scene


def _arrays(description: SceneDescription) -> Iterator[NDArray[np.generic]]:
    for mesh in {group.mesh.key: group.mesh for group in description.instances}.values():
        given = (mesh.positions, mesh.triangles, mesh.material_slots, mesh.corner_normals)
        yield from (array for array in given if array is not None)
        yield from (values for _, values in mesh.uv_maps)
    yield from (group.world_from_object for group in description.instances)


def _image_bytes(description: SceneDescription) -> int:
    images: dict[str, Image] = {
        use.image.key: use.image for material in description.materials for use in material.textures
    }
    if description.world.image is not None:
        images[description.world.image.key] = description.world.image
    return sum(int(np.prod(image.shape)) * (4 if image.is_float else 1) for image in images.values())


class _Triangles(bpy.types.RenderEngine):
    bl_idname, bl_label = "TRIANGLES", "Triangles"

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        for instance in depsgraph.object_instances:
            if instance.object.type == "MESH":
                instance.object.data.calc_loop_triangles()
                _ = instance.object.data.vertex_normals[0].vector


def _measured(name: str, engine: str) -> dict[str, float]:
    """Of one render."""
    from tyndall.blender.addon.sync.reports import Reports  # noqa: PLC0415  there once it is enabled
    from tyndall.blender.addon.sync.scene import SceneReader  # noqa: PLC0415

    _empty()
    _picture(0, 4)
    bpy.ops.render.render()
    scene = _empty()
    SCENES[name]()
    scene.frame_set(1)  # evaluated: what follows is the render's
    bpy.utils.register_class(_Triangles)
    scene.render.engine = engine
    _native.return_free_memory()
    forget_most_memory()
    before, embree, began = memory_bytes(), _native.most_embree_bytes(), time.perf_counter()
    bpy.ops.render.render()
    seconds, peak = time.perf_counter() - began, most_memory_bytes() - before
    embree = _native.most_embree_bytes() - embree
    bpy.utils.unregister_class(_Triangles)  # one that is left over makes bpy 4.5 hang
    description = SceneReader().read(bpy.context.evaluated_depsgraph_get(), Reports(), lambda: None)
    data = sum(array.nbytes for array in _arrays(description)) + _image_bytes(description)
    return {
        "seconds": seconds,
        "data_mib": data / MIB,
        "embree_mib": embree / MIB,
        "peak_mib": peak / MIB,
    }


def _in_another_process(name: str, engine: str) -> dict[str, float]:
    command = [sys.executable, __file__, "--measure", name, engine]
    done = subprocess.run(command, env=os.environ, check=True, capture_output=True, text=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def _row(name: str) -> Row:
    found = _in_another_process(name, tyndall.blender.ENGINE)
    blender_mib = _in_another_process(name, _Triangles.bl_idname)["peak_mib"]
    known_mib = found["data_mib"] + found["embree_mib"]
    beyond = (found["peak_mib"] - blender_mib - known_mib) / known_mib
    return row(name, found.pop("seconds"), **found, blender_mib=blender_mib, beyond=beyond)


def main() -> None:
    """Write the rows; or, in a process that was asked for a scene, print what that took."""
    if sys.argv[1:2] == ["--measure"]:
        tyndall.blender.enable()
        print(json.dumps(_measured(*sys.argv[2:])))
        return
    parser = argument_parser(__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("scenes", nargs="*", default=list(SCENES), metavar="SCENE")
    arguments = parser.parse_args()
    write_report([_row(name) for name in arguments.scenes], arguments)


if __name__ == "__main__":
    main()
