# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender of its own: a picture of a scene, and one of it while all of its objects are deleted.

What an artist deletes in a window while a render reads the scene. Prints "the same" if the pictures are.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

REPOSITORY = Path(__file__).parents[2]
sys.path[:0] = [str(REPOSITORY / folder) for folder in (".", "tests", "python", "build/release/python")]

import bpy  # noqa: E402  after the path is set
import numpy as np  # noqa: E402
from numpy.typing import NDArray  # noqa: E402

import tyndall.blender  # noqa: E402
from support.small_scenes import add, cube, empty_scene, light, plane  # noqa: E402


def build() -> bpy.types.Scene:
    """Of each kind of object that a render asks something else: what instances, is made a mesh, is lit alone."""
    scene = empty_scene()
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y = 40, 20
    scene.camera.location, scene.camera.rotation_euler = (0, -8, 6), (0.9, 0, 0)
    scene.camera.data.type = "PERSP"
    plane()
    cube().location.z = 1
    add("Text", bpy.data.curves.new("Text", "FONT"), (-3, 0, 0)).data.body = "T"
    inside = bpy.data.collections.new("Inside")
    inside.objects.link(instanced := cube("Instanced"))
    scene.collection.objects.unlink(instanced)
    instancer = add("Instancer", None, (2, 1, 1))
    instancer.instance_type, instancer.instance_collection = "COLLECTION", inside
    light("SUN", (0, 0, 5), energy=2.0)
    lamp = light("POINT", (3, -1, 3), energy=500.0)
    if bpy.app.version >= (4, 0, 0):
        lamp.light_linking.receiver_collection = inside
    return scene


def picture(scene: bpy.types.Scene, path: Path) -> NDArray[np.float32]:
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return np.array(bpy.data.images.load(f"{path}.exr").pixels[:], np.float32)


def main(folder: Path) -> None:
    tyndall.blender.enable()
    scene = build()
    whole = picture(scene, folder / "whole")

    from tyndall.blender.addon.sync import scene as scenes  # noqa: PLC0415  there once the add-on is

    read_placements: Callable[..., Any] = scenes.read_placements

    def read_and_delete(*of_scene: Any) -> Any:
        found = read_placements(*of_scene)
        for thing in list(bpy.data.objects):
            bpy.data.objects.remove(thing)
        for collection in list(bpy.data.collections):
            bpy.data.collections.remove(collection)
        return found

    scenes.read_placements = read_and_delete
    meanwhile = picture(scene, folder / "meanwhile")
    assert not bpy.data.objects
    assert whole.std() > 0.1
    print("the same" if np.array_equal(whole, meanwhile) else "another picture")


main(Path(sys.argv[-1]))
