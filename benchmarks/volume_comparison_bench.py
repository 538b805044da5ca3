# SPDX-License-Identifier: GPL-3.0-or-later
"""The race in smoke: a cloud of 256^3 voxels to the error that Cycles reaches.

scripts/python benchmarks/volume_comparison_bench.py --context FILE --output FILE [--cycles-samples FEW MANY]
    [--width PX] [--voxels COUNT] [SCENE...]
As cycles_comparison_bench.py, whose measures of error these are, with Cycles 5.0 by its bpy. Times are those of the
process' threads together, in seconds of CPU, so that a machine that others use as well tells the same; wall_s is beside
them. Cycles up to 4.5 marches with a step that is biased; 5.0 does not.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from cycles_comparison_bench import FLOOR_SHARE, Picture, cycles_render, first_time, rendered, root, trimmed_mean
from mathutils import Vector
from numpy.typing import NDArray

import tyndall.blender
from report import Row, argument_parser, row, write_report
from tyndall.volumes import LEAF_VOXELS, SparseGrid, write_vdb


@dataclass(frozen=True)
class Setting:
    """A row of the ladder from draft to final."""

    samples: int
    error_target: float

    @property
    def name(self) -> str:
        """Short enough for a plot."""
        return f"{self.samples} samples, {100 * self.error_target:g} %"


LADDER = (Setting(1, 0.05), Setting(1, 0.01), Setting(2, 0.01), Setting(4, 0.01), Setting(8, 0.005), Setting(16, 0.005))


def cloud(voxels: int) -> NDArray[np.float32]:
    """A ball of billows: noise whose spectrum falls with the power 1.9 of its frequency. (voxels,) * 3 by x, y, z."""
    rng = np.random.default_rng(7)
    frequency = np.fft.fftfreq(voxels) * voxels
    squared = frequency[:, None, None] ** 2 + frequency[None, :, None] ** 2 + frequency[None, None, :] ** 2
    amplitude = (squared + 9.0) ** (-1.9 / 2 - 0.75)
    noise = np.fft.ifftn(np.fft.fftn(rng.standard_normal((voxels,) * 3)) * amplitude).real
    noise /= noise.std()
    place = (np.arange(voxels) + 0.5) * (2.0 / voxels) - 1.0
    x, y, z = np.meshgrid(place, place, place, indexing="ij")
    density = np.clip(1.1 - 2.2 * (x * x + y * y + z * z) + 0.45 * noise, 0.0, 1.0)
    density[[0, -1]] = density[:, [0, -1]] = density[:, :, [0, -1]] = 0.0
    return density.astype(np.float32)


def write_cloud(path: Path, voxels: int) -> None:
    """As an OpenVDB file over [-1, 1]^3, without its empty leaves."""
    density = cloud(voxels)
    count = voxels // LEAF_VOXELS
    blocks = density.reshape(count, LEAF_VOXELS, count, LEAF_VOXELS, count, LEAF_VOXELS)
    leaves = blocks.transpose(0, 2, 4, 1, 3, 5).reshape(-1, LEAF_VOXELS, LEAF_VOXELS, LEAF_VOXELS)
    origins = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * LEAF_VOXELS
    is_kept = leaves.reshape(len(leaves), -1).any(axis=1)
    local_from_index = np.diag([2.0 / voxels] * 3 + [1.0])
    local_from_index[:3, 3] = 1.0 / voxels - 1.0
    grid = SparseGrid(
        name="density",
        leaf_origins=origins[is_kept].astype(np.int32),
        leaf_values=np.ascontiguousarray(leaves[is_kept]),
        local_from_index=local_from_index,
    )
    write_vdb(path, [grid])


def _add(name: str, data: bpy.types.ID | None) -> bpy.types.Object:
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def open_scene(cloud_path: Path, width_px: int) -> bpy.types.Scene:
    """The cloud before a camera, without a light."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = width_px, width_px * 9 // 16, 100
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.color_mode = "RGB"
    scene.tyndall.pixel_filter = scene.cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    scene.tyndall.filter_width_px = scene.cycles.filter_width = 1.5
    smoke = bpy.data.materials.new("Smoke")
    smoke.use_nodes = True
    tree = smoke.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeVolumePrincipled")
    shader.inputs["Density"].default_value = 6.0
    shader.inputs["Color"].default_value = (0.9, 0.85, 0.8, 1.0)
    shader.inputs["Anisotropy"].default_value = 0.3
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
    volume = bpy.data.volumes.new("Cloud")
    volume.filepath = str(cloud_path)
    volume.materials.append(smoke)
    _add("Cloud", volume)
    camera = bpy.data.cameras.new("Camera")
    scene.camera = _add("Camera", camera)
    scene.camera.location = (0.0, -4.5, 1.0)
    scene.camera.rotation_euler = Vector((0.0, 4.5, -1.0)).to_track_quat("-Z", "Y").to_euler()
    return scene


def sun(_scene: bpy.types.Scene) -> None:
    """Without a size, high and from the side."""
    data = bpy.data.lights.new("Sun", "SUN")
    data.energy, data.angle = 5.0, 0.0
    _add("Sun", data).rotation_euler = (0.8, 0.6, 0.0)


def spot_in_haze(_scene: bpy.types.Scene) -> None:
    """The cloud's shadow in fog."""
    data = bpy.data.lights.new("Spot", "SPOT")
    data.energy, data.shadow_soft_size, data.spot_size, data.spot_blend = 1500.0, 0.0, math.radians(45.0), 0.3
    lamp = _add("Spot", data)
    lamp.location = (-3.0, -1.0, 2.5)
    lamp.rotation_euler = (-lamp.location).to_track_quat("-Z", "Y").to_euler()
    haze = bpy.data.materials.new("Haze")
    haze.use_nodes = True
    tree = haze.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeVolumeScatter")
    shader.inputs["Density"].default_value = 0.05
    shader.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
    corners = [(x, y, z) for x in (-4, 4) for y in (-3, 4) for z in (-2, 3)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new("Haze")
    mesh.from_pydata(corners, [], faces)
    mesh.materials.append(haze)
    _add("Haze", mesh)


SCENES: dict[str, Callable[[bpy.types.Scene], None]] = {"sun": sun, "spot in haze": spot_in_haze}


def timed(render: Callable[[], tuple[Picture, float]]) -> tuple[Picture, float, float]:
    """The picture, seconds of CPU, seconds on the wall."""
    start = time.process_time()
    picture, wall_s = render()
    return picture, time.process_time() - start, wall_s


def tyndall_render(scene: bpy.types.Scene, setting: Setting) -> tuple[Picture, float]:
    """One picture."""
    scene.render.engine = "TYNDALL"
    ours = scene.tyndall
    ours.pixel_samples, ours.noise_threshold = setting.samples, 0.0
    ours.shafts.method, ours.shafts.grid_error_target = "EPIPOLAR", setting.error_target
    return rendered(scene)


def compare(name: str, cloud_path: Path, width_px: int, few: int, many: int) -> list[Row]:
    """Rows of one scene."""
    scene = open_scene(cloud_path, width_px)
    SCENES[name](scene)
    ours = [(setting, *timed(lambda setting=setting: tyndall_render(scene, setting))) for setting in LADDER]
    a, few_s, few_wall_s = timed(lambda: cycles_render(scene, few, seed=1))
    b, _, _ = timed(lambda: cycles_render(scene, few, seed=2))
    c, many_s, many_wall_s = timed(lambda: cycles_render(scene, many, seed=3))
    finest = ours[-1][1]
    weight = 1.0 / (finest + FLOOR_SHARE * finest.mean()) ** 2
    few_squared, mixed_squared = weight * (a - b) ** 2, weight * (a - c) ** 2
    few_variance = trimmed_mean(few_squared, few_squared) / 2
    many_variance = trimmed_mean(mixed_squared, mixed_squared) - few_variance
    version = ".".join(map(str, bpy.app.version[:2]))
    rows = [
        row(f"{name}, Cycles {version}/{few} samples", few_s, rel_error=root(few_variance), wall_s=few_wall_s),
        row(f"{name}, Cycles {version}/{many} samples", many_s, rel_error=root(many_variance), wall_s=many_wall_s),
    ]
    ladder = []
    for setting, picture, seconds, wall_s in ours:
        squared = weight * (picture - (a + b) / 2) * (picture - c)
        error = root(trimmed_mean(squared, weight * (picture - finest) ** 2))
        if error > 0.0:
            ladder.append((seconds, error))
        bias = float(picture.mean() / ((few * (a + b) + many * c) / (2 * few + many)).mean()) - 1.0
        rows.append(row(f"{name}, Tyndall/{setting.name}", seconds, rel_error=error, bias_of_mean=bias, wall_s=wall_s))
    for samples, seconds, variance in ((few, few_s, few_variance), (many, many_s, many_variance)):
        ours_s = first_time(ladder, root(variance))
        rows.append(
            row(
                f"{name}: to the error of Cycles {version} at {samples}",
                seconds,
                target=root(variance),
                tyndall_seconds=ours_s or 0.0,
                times_faster=seconds / ours_s if ours_s else 0.0,
            )
        )
    for line in rows:
        print(line, flush=True)
    return rows


def main() -> None:
    """Compare the scenes and write the report."""
    parser = argument_parser(__doc__)
    parser.add_argument("--cycles-samples", type=int, nargs=2, default=(64, 256), metavar=("FEW", "MANY"))
    parser.add_argument("--width", type=int, default=480, metavar="PX")
    parser.add_argument("--voxels", type=int, default=256, metavar="COUNT")
    parser.add_argument("scenes", nargs="*", default=tuple(SCENES))
    arguments = parser.parse_args(sys.argv[1:])
    tyndall.blender.enable()
    try:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "cloud.vdb"
            write_cloud(path, arguments.voxels)
            rows = [
                line
                for name in arguments.scenes
                for line in compare(name, path, arguments.width, *arguments.cycles_samples)
            ]
    finally:
        tyndall.blender.disable()
    write_report(rows, arguments)


if __name__ == "__main__":
    main()
