# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes native/shading/lobes/sheen_table.cpp: a sheen's three numbers, measured from Cycles' pictures of it.

Based on: Zeltner, Burley and Chiang 2022, Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines: what
          comes back of a direction w, the view being in the plane of x, is R a^2 z / (pi |(a x + b z, a y, z)|^4).
Differs:  their table is not read from anywhere. Under a sun without a size a picture has no noise, and
          sqrt(z / (pi value)) is linear in a^2, a b and b^2 + 1, over a sqrt(R): a few suns give all three.

Run it with bpy 4.0 or later (``python tests/support/measure_sheen.py``); two seconds. 4.5 and 5.0 give the same file.
Each pixel is a square of its own: columns lean away from the camera, rows are rougher and rougher. Cycles interpolates
linearly between 32 x 32 values, which squares between them show: written is what has those in between.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

Array = NDArray[np.float64]

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY / "tests"), str(REPOSITORY / "python"), str(REPOSITORY)]

from support.engine_pictures import cycles_pixels  # noqa: E402
from support.small_scenes import add, light, material, mesh, node  # noqa: E402

TARGET = REPOSITORY / "native" / "shading" / "lobes" / "sheen_table.cpp"
NODES = 32
BETWEEN = 2  #: Squares per step of the table.
GRAZING = 1e-3  #: Stands for a cosine of 0, which no camera sees.
#: Cycles drops what reflects less than 1e-5: a bright colour keeps it in the picture.
COLOUR = 1e2
LEAST_ALBEDO = 1e-5  #: With less there is nothing to be drawn.
LEAST_ROUGHNESS = 1e-3  #: As of which Cycles draws all that are less rough.
SUNS = ((0, 0.05, 1), (0, 0.5, 1), (0, 1, 0.4), (0.8, 0.5, 0.5), (0.8, 0.2, 1), (0.3, 0.7, 0.7), (1, 0.3, 0.3))
UNIT = 1e5  #: Of the integers that are written.
_HEADER = """// SPDX-License-Identifier: GPL-3.0-or-later
// Made by tests/support/measure_sheen.py, which says how: measured from Cycles' pictures, in 1 / 100,000.
#include "shading/lobes/sheen.hpp"

namespace tyndall::sheen {
// clang-format off
const std::int32_t table[node_count][node_count][3] = {
"""


def squares(cosines: Array, roughnesses: Array) -> bpy.types.Scene:
    """A pixel each; column by column they lean towards +Y, away from the camera's axis."""
    columns, rows = len(cosines), len(roughnesses)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = columns, rows
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    lens = bpy.data.cameras.new("Camera")
    lens.type, lens.ortho_scale, lens.clip_end = "ORTHO", max(columns, rows), 4.0 / GRAZING
    scene.camera = add("Camera", lens, (0.5 * columns, 0.5 * rows, 2.0 / GRAZING))
    slopes = np.sqrt(1.0 - cosines**2) / cosines
    around = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    corners = np.zeros((rows, columns, 4, 3))
    corners[..., 0] = np.arange(columns)[None, :, None] + around[:, 0]
    corners[..., 1] = np.arange(rows)[:, None, None] + around[:, 1]
    corners[..., 2] = slopes[None, :, None] * (0.5 - around[:, 1])
    faces = np.arange(4 * rows * columns).reshape(-1, 4).tolist()

    def sheen(new: object, link: object) -> bpy.types.NodeSocket:
        shown = node(new, "ShaderNodeBsdfSheen", Color=(COLOUR, COLOUR, COLOUR, 1.0))
        shown.distribution = "MICROFIBER"
        stored = node(new, "ShaderNodeAttribute")
        stored.attribute_name = "roughness"
        link(stored.outputs["Fac"], shown.inputs["Roughness"])
        return shown.outputs[0]

    shape = mesh("Squares", corners.reshape(-1, 3).tolist(), faces, material("Sheen", sheen))
    stored = shape.attributes.new("roughness", "FLOAT", "FACE")
    stored.data.foreach_set("value", np.repeat(roughnesses, columns).astype(np.float32))
    add("Squares", shape).visible_shadow = False  # some reach far above others
    return scene


def measured(cosines: Array, roughnesses: Array) -> tuple[Array, Array, Array, Array]:
    """Of each roughness and cosine: a, b, R, and how far off the suns are that these draw, relative; 0 where R is."""
    scene = squares(cosines, roughnesses)
    sines = np.sqrt(1.0 - cosines**2)
    rows, values = [], []
    for place in SUNS:
        towards = Vector(place).normalized()
        lamp = light("SUN", (0, 0, 0), energy=1.0, angle=0.0)
        lamp.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
        across, up, back = lamp.rotation_euler.to_matrix().col[2]
        x, z = (
            sines * back - cosines * up,
            sines * up + cosines * back,
        )  # the plane's axis on the view's side, and its normal
        rows.append(np.stack([x**2 + across**2, 2.0 * x * z, z**2], axis=-1))
        values.append(cycles_pixels(scene, samples=1, seed=1)[..., 0] / COLOUR)
        bpy.data.objects.remove(lamp)
    height = np.sqrt([row[:, 2] for row in rows])
    value = np.moveaxis(np.array(values), 0, 2)  # roughness, cosine, sun
    is_there = value.min(axis=2) > 0.0
    root = np.sqrt(height.T / (math.pi * np.where(is_there[..., None], value, 1.0)))
    design = np.moveaxis(np.array(rows), 0, 1) / root[..., None]
    solved = np.linalg.pinv(design) @ np.ones((len(SUNS), 1))
    along, both, up = np.moveaxis(solved[..., 0], -1, 0)
    albedo = np.where(is_there, 1.0 / np.where(is_there, along * up - both**2, 1.0), 0.0)
    is_there &= albedo > LEAST_ALBEDO
    off = np.where(is_there, np.abs(design @ solved - 1.0).max(axis=(2, 3)), 0.0)
    return along * np.sqrt(albedo), both * np.sqrt(albedo), np.where(is_there, albedo, 0.0), off


def between(places: Array) -> Array:
    """(places, nodes) shares of the nodes."""
    return np.maximum(0.0, 1.0 - np.abs(places[:, None] * (NODES - 1) - np.arange(NODES)))


def table_of(cosines: Array, roughnesses: Array, numbers: tuple[Array, Array, Array]) -> Array:
    """(roughness, cosine, 3) by least squares; a and b go straight on where there is nothing to be measured."""
    shares = np.einsum("ri,cj->rcij", between(roughnesses), between(cosines)).reshape(-1, NODES * NODES)
    straight = np.diff(np.eye(NODES), 2, axis=0)
    bends = np.concatenate([np.kron(np.eye(NODES), straight), np.kron(straight, np.eye(NODES))])
    is_there = (numbers[2] > 0.0).ravel()
    found = []
    for index, values in enumerate(numbers):
        counts = is_there if index < 2 else np.ones_like(is_there)
        known = shares[counts]
        normal = known.T @ known + (1e-9 if index < 2 else 0.0) * bends.T @ bends
        solved = np.linalg.solve(normal, known.T @ values.ravel()[counts])
        print(f"{'abR'[index]}: off by up to {np.abs(known @ solved - values.ravel()[counts]).max():.1e} in between")
        found.append(solved.reshape(NODES, NODES))
    return np.stack(found, axis=-1)


def write(table: Array) -> None:
    """Make the native source."""
    table[..., [0, 2]] = np.maximum(table[..., [0, 2]], 0.0)
    numbers = np.rint(table * UNIT).astype(int)
    lines = []
    for row in numbers:
        lines.append("    {")
        lines += [
            "        " + " ".join("{" + ", ".join(map(str, three)) + "}," for three in row[first : first + 4])
            for first in range(0, NODES, 4)
        ]
        lines.append("    },")
    TARGET.write_text(_HEADER + "\n".join(lines) + "\n};\n// clang-format on\n} // namespace tyndall::sheen\n")


def main() -> None:
    places = np.linspace(0.0, 1.0, BETWEEN * (NODES - 1) + 1)
    cosines, roughnesses = np.maximum(places, GRAZING), np.maximum(places, LEAST_ROUGHNESS)
    *numbers, off = measured(cosines, roughnesses)
    print(f"Blender {bpy.app.version_string}; each square is off by up to {off.max():.1e} of its light")
    write(table_of(cosines, roughnesses, tuple(numbers)))


if __name__ == "__main__":
    main()
