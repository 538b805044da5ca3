# SPDX-License-Identifier: GPL-3.0-or-later
"""Real scenes that nobody here made, as both engines are asked to draw them; they lie beside the repository.

What is changed in each is as little as makes a picture: a camera or a light where there is none. `Scene.changes` says
it in words, for the sheet that shows the pictures.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
from mathutils import Vector

REPOSITORY = Path(__file__).parents[2]
FOLDER = "data/blend"


def _nothing(_scene: bpy.types.Scene) -> None:
    pass


Place = tuple[float, float, float]  #: In metres.


def look(scene: bpy.types.Scene, place: Place, at: Place, lens: float = 28.0) -> None:
    """Put a camera there."""
    data = bpy.data.cameras.new("Added")
    data.lens = lens
    thing = bpy.data.objects.new("Added camera", data)
    scene.collection.objects.link(thing)
    thing.location = place
    thing.rotation_euler = (Vector(at) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    scene.camera = thing


def _sun(scene: bpy.types.Scene, energy: float = 3.0) -> None:
    data = bpy.data.lights.new("Added sun", "SUN")
    data.energy, data.angle = energy, math.radians(1.0)
    thing = bpy.data.objects.new("Added sun", data)
    scene.collection.objects.link(thing)
    thing.rotation_euler = (math.radians(40.0), math.radians(15.0), 0.0)


def _bedroom(_scene: bpy.types.Scene) -> None:
    bpy.data.objects["blocker"].hide_render = True


def _around(distance: float, height: float, lens: float = 35.0) -> Callable[[bpy.types.Scene], None]:
    """A camera that sees all objects, and a sun."""

    def prepare(scene: bpy.types.Scene) -> None:
        scene.view_layers[0].update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        corners = [
            instance.matrix_world @ Vector(corner)
            for instance in depsgraph.object_instances
            if instance.object.type == "MESH"
            for corner in instance.object.bound_box
        ]
        low = Vector([min(corner[axis] for corner in corners) for axis in range(3)])
        high = Vector([max(corner[axis] for corner in corners) for axis in range(3)])
        centre, size = (low + high) / 2, (high - low).length
        look(scene, tuple(centre + Vector((0.6, -1.0, height)).normalized() * distance * size), tuple(centre), lens)
        _sun(scene)

    return prepare


@dataclass(frozen=True)
class RealScene:
    """A file of other people's."""

    path: str  #: Below FOLDER.
    credit: str
    changes: str = "as it is"
    prepare: Callable[[bpy.types.Scene], None] = _nothing
    differences: str = ""  #: What is not the same light in both engines, and why.
    mean_bound: float = 0.0  #: Of the picture's mean, and of the median block: what these leave.
    median_bound: float = 0.0
    oldest: tuple[int, int, int] = (3, 4, 0)  #: Older ones crash while they read it.

    @property
    def name(self) -> str:
        """Of the file."""
        return Path(self.path).stem

    def found(self) -> Path | None:
        """Beside the repository, or beside the main work tree of a linked one."""
        roots = [REPOSITORY.parent / "shared", Path(os.environ.get("TYNDALL_SHARED", "/nowhere"))]
        return next((root / FOLDER / self.path for root in roots if (root / FOLDER / self.path).exists()), None)

    def open(self, width_px: int) -> bpy.types.Scene:
        """Open it, at a size that keeps its proportions."""
        path = self.found()
        if path is None:
            raise FileNotFoundError(f"../shared/{FOLDER}/{self.path} is not there")
        try:
            bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
        except RuntimeError as error:  # what a file lost is reported so, though it was read
            print(f"{self.name}: {str(error).splitlines()[0]}")
        scene = bpy.context.scene
        self.prepare(scene)
        render = scene.render
        height = max(1, round(width_px * render.resolution_y / render.resolution_x))
        render.resolution_x, render.resolution_y, render.resolution_percentage = width_px, min(height, width_px), 100
        render.use_border = False
        return scene


REAL_SCENES = (
    RealScene(
        "engineer_room/bedroom.blend",
        "Mark Raynsford, CC BY 4.0",
        "with its light blocker hidden",
        _bedroom,
        differences="A note on the board lies there twice, at one place: in Cycles the two shadow each other.",
    ),
    RealScene("baked_hall/scene.blend", "Bevy-BakedGI-Demo, MIT or Apache-2.0"),
    RealScene("dino_forest/vr_dino.blend", "armory_examples, zlib"),
    RealScene("race_track/race_track.blend", "armory_templates, zlib"),
    RealScene("displaced_terrain/mesh_terrain.blend", "armory_examples, zlib"),
    RealScene("hair_grass/particle_hair.blend", "armory_examples, zlib"),
    RealScene("teapot_room/render_voxelao_teapots.blend", "armory_examples, zlib"),
    RealScene(
        "gi_level/zdm2.blend",
        "godot-demo-projects, MIT",
        "with a camera and a sun",
        _around(0.45, 0.7),
        differences="Edges of three and more faces, and those of faces turned over, are smoothed by Cycles, which "
        "knows the marked edges alone; ours has the normals of Blender's own viewport.",
    ),
    RealScene(
        "yofrankie_lava/levels/minilevel_lava_Falls.blend",
        "YoFrankie! (c) 2008, Blender Foundation, www.blender.org, CC BY 3.0",
        "with a camera and a sun",
        _around(0.5, 0.6),
        oldest=(4, 5, 0),
    ),
    RealScene(
        "gltf_odd/gn_nested_instances.blend",
        "glTF-Blender-IO, Apache-2.0",
        "with a camera and a sun",
        _around(1.5, 0.6),
        oldest=(4, 5, 0),
    ),
    RealScene("gltf_odd/22_simple_GN.blend", "glTF-Blender-IO, Apache-2.0"),
    RealScene(
        "gltf_odd/16_volume.blend",
        "glTF-Blender-IO, Apache-2.0",
        "with a camera and a sun",
        _around(1.5, 0.6),
        differences="Two of its cubes are glass, which Cycles draws black without bounces and ours lets light through.",
        mean_bound=0.06,
    ),
    RealScene("gltf_odd/19_sheen.blend", "glTF-Blender-IO, Apache-2.0", "with a camera and a sun", _around(1.2, 0.6)),
)
