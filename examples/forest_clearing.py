# SPDX-License-Identifier: GPL-3.0-or-later
"""A clearing in a birch wood on a misty morning: low sun between the trunks, ferns, a deer on the path.

Trees come from Blender's Sapling Tree Gen, the ground from A.N.T. Landscape. Run as
``blender -b --factory-startup --python examples/forest_clearing.py``; writes forest_clearing.blend beside itself.
"""

from __future__ import annotations

import ast
import sys
from itertools import pairwise
from math import cos, pi, sin
from pathlib import Path

import addon_utils
import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

sys.path.insert(0, str(Path(__file__).resolve().parent))
from scene_kit import (
    Shape,
    camera,
    clear_file,
    diffuse,
    finish,
    fog_box,
    instance,
    link,
    placed,
    shared_collection,
    sun,
    world,
)

TOWARDS_SUN = (-0.55, 1.0, 0.66)  #: From beyond the clearing, a little to the left.
EYE = (0.6, -17.0, 1.55)
DEER = (-0.7, -9.0)
GROUND_SIZE = 110.0


def ground(material: bpy.types.Material) -> bpy.types.Object:
    """Rolling forest floor, flat in the clearing."""
    bpy.ops.mesh.landscape_add(
        ant_terrain_name="Ground", subdivision_x=160, subdivision_y=160, mesh_size_x=GROUND_SIZE,
        mesh_size_y=GROUND_SIZE, random_seed=7, noise_size=14.0, noise_type="hetero_terrain", height=2.2,
        edge_falloff="0", maximum=6.0, minimum=-6.0, refresh=True, land_material="", water_material="",
    )  # fmt: skip
    made = bpy.context.object
    mesh = made.data
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", points.ravel())
    # Flat from the camera to the clearing's far side, rising beyond, so that the wood ends in a hill.
    distance = np.hypot(points[:, 0], points[:, 1] - np.clip(points[:, 1], -20.0, 4.0))
    calm = np.clip((distance - 4.0) / 22.0, 0.05, 1.0)
    points[:, 2] = (points[:, 2] - points[:, 2].mean()) * calm + 0.17 * np.clip(distance - 14.0, 0.0, None)
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.clear()
    mesh.materials.append(material)
    mesh.update()
    return made


def tree(seed: int, bark: bpy.types.Material, leaf: bpy.types.Material) -> bpy.types.Collection:
    """A slender, high-crowned tree of Sapling's aspen preset, as two shared meshes."""
    import add_curve_sapling  # noqa: PLC0415  exists only once the add-on is enabled

    preset = Path(add_curve_sapling.__file__).parent / "presets" / "quaking_aspen.py"
    settings = ast.literal_eval(preset.read_text().partition("\n")[2])
    random = np.random.default_rng(seed)
    settings |= {
        "seed": seed, "levels": 3, "branches": (0, 34, 13, 0), "leaves": 16, "showLeaves": True, "leafShape": "hex",
        "leafScale": 0.27, "leafScaleX": 0.75, "scale": 13.0 + 3.0 * random.random(), "scaleV": 0.0, "baseSize": 0.42,
        "resU": 1, "bevelRes": 1, "curveRes": (8, 4, 2, 1), "ratio": 0.013, "curveV": (28.0, 60.0, 80.0, 0.0),
    }  # fmt: skip
    before = set(bpy.data.objects)
    bpy.ops.curve.tree_add(do_update=True, **settings)
    grown = {made.type: made for made in set(bpy.data.objects) - before}
    collection = shared_collection(f"Tree {seed}")
    evaluated = grown["CURVE"].evaluated_get(bpy.context.evaluated_depsgraph_get())
    for name, mesh, material in (
        ("Wood", bpy.data.meshes.new_from_object(evaluated), bark),
        ("Leaves", grown["MESH"].data.copy(), leaf),
    ):
        mesh.name = f"{name} {seed}"
        mesh.materials.clear()
        mesh.materials.append(material)
        mesh.polygons.foreach_set("use_smooth", [name == "Wood"] * len(mesh.polygons))
        link(mesh.name, mesh, collection)
    for made in grown.values():
        bpy.data.objects.remove(made)
    return collection


def fern(seed: int, material: bpy.types.Material) -> bpy.types.Collection:
    """A fern of arching fronds with paired leaflets."""
    random = np.random.default_rng(seed)
    shape = Shape()
    for frond in range(11):
        heading, reach, rise = (
            2 * pi * frond / 11 + 0.4 * random.random(),
            0.55 + 0.3 * random.random(),
            0.5 + 0.3 * random.random(),
        )
        spine = [Vector((reach * t, 0.0, rise * sin(pi * 0.8 * t) * (1 - 0.35 * t))) for t in np.linspace(0.06, 1, 15)]
        place = Matrix.Rotation(heading, 4, "Z")
        for index, (a, b) in enumerate(pairwise(spine)):
            width = 0.17 * sin(pi * (0.12 + 0.85 * index / 14))
            for side in (-1, 1):
                tip = (a + b) / 2 + Vector((0.06, side * width, -0.25 * width))
                shape.add(
                    [a, a.lerp(b, 0.72), tip],
                    [(0, 1, 2) if side > 0 else (0, 2, 1)],
                    0,
                    place,
                )
    collection = shared_collection(f"Fern {seed}")
    link(f"Fern {seed}", shape.mesh(f"Fern {seed}", material), collection)
    return collection


def grass(seed: int, material: bpy.types.Material) -> bpy.types.Collection:
    """A tuft of bent blades, two quads and a tip each."""
    random = np.random.default_rng(seed)
    shape = Shape()
    for _ in range(60):
        root = Vector((random.normal() * 0.22, random.normal() * 0.22, -0.03))
        heading, height, bend = (
            2 * pi * random.random(),
            0.16 + 0.26 * random.random(),
            0.04 + 0.18 * random.random(),
        )
        out = Vector((cos(heading), sin(heading), 0))
        wide = Vector((-out.y, out.x, 0)) * 0.008
        middle = root + out * bend * 0.3 + Vector((0, 0, height * 0.6))
        tip = root + out * bend + Vector((0, 0, height))
        shape.add(
            [root - wide, root + wide, middle + wide * 0.7, middle - wide * 0.7, tip],
            [(0, 1, 2, 3), (3, 2, 4)],
        )
    collection = shared_collection(f"Grass {seed}")
    link(f"Grass {seed}", shape.mesh(f"Grass {seed}", material), collection)
    return collection


def deer(material: bpy.types.Material) -> bpy.types.Object:
    """A roe buck of skinned tubes, 1.3 m to the antlers, that looks along -X."""
    joints = {
        "rump": (0.42, 0, 0.80, 0.13), "loin": (0.15, 0, 0.82, 0.145), "chest": (-0.22, 0, 0.80, 0.16),
        "shoulder": (-0.36, 0, 0.88, 0.10), "neck": (-0.50, 0, 1.06, 0.07), "poll": (-0.58, 0, 1.22, 0.062),
        "cheek": (-0.68, 0, 1.18, 0.055), "nose": (-0.82, 0, 1.10, 0.028), "tail": (0.55, 0, 0.80, 0.03),
    }  # fmt: skip
    chains = [["tail", "rump", "loin", "chest", "shoulder", "neck", "poll", "cheek", "nose"]]
    for side, y in (("left", 0.085), ("right", -0.085)):
        shift = 0.05 if side == "left" else -0.06
        for end, hip in (("fore", -0.27), ("hind", 0.38)):
            back = 0.10 if end == "hind" else 0.0
            leg = f"{end}_{side}"
            joints |= {
                f"{leg}_hip": (hip, y, 0.70, 0.075),
                f"{leg}_knee": (hip + back + shift * 0.5, y, 0.42, 0.035),
                f"{leg}_hock": (hip + shift, y, 0.16, 0.021),
                f"{leg}_hoof": (hip + shift - 0.02, y, 0.0, 0.026),
            }  # fmt: skip
            chains.append([f"{leg}_{part}" for part in ("hip", "knee", "hock", "hoof")])
        joints |= {
            f"ear_{side}_root": (-0.56, y * 0.5, 1.26, 0.022), f"ear_{side}": (-0.53, y * 1.5, 1.37, 0.012),
            f"antler_{side}_root": (-0.60, y * 0.35, 1.26, 0.014),
            f"antler_{side}_fork": (-0.58, y * 0.75, 1.42, 0.010),
            f"antler_{side}_tip": (-0.61, y * 0.95, 1.55, 0.005), f"antler_{side}_tine": (-0.67, y * 0.8, 1.48, 0.004),
        }  # fmt: skip
        chains += [
            [f"ear_{side}_root", f"ear_{side}"],
            [f"antler_{side}_{part}" for part in ("root", "fork", "tip")],
        ]
        chains.append([f"antler_{side}_fork", f"antler_{side}_tine"])
    shape, sides = Shape(), 12
    for chain in chains:
        nodes = [joints[name] for name in chain]
        for (*a, ra), (*b, rb) in pairwise(nodes):
            axis = Vector(b) - Vector(a)
            place = Matrix.Translation(a) @ axis.to_track_quat("Z", "Y").to_matrix().to_4x4()
            shape.lathe([(ra, 0.0), (rb, axis.length)], sides, 0, place)
            shape.ball(b, (rb, rb, rb), 0, sides)
    return link("Deer", shape.mesh("Deer", material, smooth=True))


def rest_on(surface: BVHTree, x: float, y: float) -> Vector:
    """The surface's point below (x, y)."""
    point, *_ = surface.ray_cast(Vector((x, y, 60.0)), Vector((0, 0, -1)))
    if point is None:
        message = f"({x:.1f}, {y:.1f}) lies beside the ground"
        raise ValueError(message)
    return point


def plant(surface: BVHTree, trees: list, ferns: list, tufts: list) -> None:
    """Trees around the clearing and along the way to it, undergrowth below; nothing in the camera's way."""
    random = np.random.default_rng(21)
    wood = bpy.data.collections.new("Wood")
    bpy.context.scene.collection.children.link(wood)
    standing: list[tuple[float, float]] = []
    while len(standing) < 290:
        x, y = random.uniform(-48, 48), random.uniform(-26, 50)
        in_clearing = np.hypot(x / 1.1, y + 1.0) < 9.5
        in_view = y < 0 and abs(x - EYE[0]) < 2.2 + 0.28 * (y - EYE[1]) and y > EYE[1] - 8
        too_close = any(np.hypot(x - a, y - b) < 1.9 for a, b in standing)
        # A gap in the crowns through which the sun finds the deer.
        along = ((x - DEER[0]) * TOWARDS_SUN[0] + (y - DEER[1]) * TOWARDS_SUN[1]) / np.hypot(*TOWARDS_SUN[:2])
        aside = abs((x - DEER[0]) * TOWARDS_SUN[1] - (y - DEER[1]) * TOWARDS_SUN[0]) / np.hypot(*TOWARDS_SUN[:2])
        shades_deer = 0 < along < 26 and aside < 1.9
        if in_clearing or in_view or too_close or shades_deer:
            continue
        standing.append((x, y))
        lean = placed(
            rest_on(surface, x, y) - Vector((0, 0, 0.15)),
            (random.normal() * 2, random.normal() * 2, random.uniform(0, 360)),
        )
        instance(
            trees[random.integers(len(trees))],
            lean @ Matrix.Scale(random.uniform(0.85, 1.25), 4),
            wood,
        )
    for kinds, count, spread, low, high in (
        (ferns, 420, 19.0, 0.7, 1.5),
        (tufts, 3600, 13.0, 0.7, 1.5),
    ):
        for _ in range(count):
            x, y = random.normal() * spread, random.normal() * spread
            if abs(x) > 50 or abs(y) > 50 or np.hypot(x - EYE[0], y - EYE[1]) < 2.0:
                continue
            on_path = abs(x - 0.8 * sin(y * 0.22)) < 0.8
            before_deer = (
                EYE[1] < y < DEER[1] + 0.8 and abs(x - np.interp(y, (EYE[1], DEER[1]), (EYE[0], DEER[0]))) < 0.9
            )
            if on_path or before_deer or (kinds is ferns and np.hypot(x, y + 1) < 6.5):
                continue
            place = placed(
                rest_on(surface, x, y),
                (random.normal() * 6, random.normal() * 6, random.uniform(0, 360)),
            )
            instance(
                kinds[random.integers(len(kinds))],
                place @ Matrix.Scale(random.uniform(low, high), 4),
                wood,
            )


def build() -> None:
    """Put the scene together."""
    clear_file()
    addon_utils.enable("add_curve_sapling")
    addon_utils.enable("ant_landscape")
    bark = diffuse("Bark", (0.30, 0.26, 0.22))
    floor = ground(diffuse("Forest Floor", (0.13, 0.12, 0.055)))
    # Not Object.ray_cast, which evaluates the scene anew after each plant.
    surface = BVHTree.FromObject(floor, bpy.context.evaluated_depsgraph_get())
    leaf = diffuse("Leaves", (0.16, 0.26, 0.04))
    trees = [tree(seed, bark, leaf) for seed in (1, 2, 3, 4)]
    ferns = [fern(seed, diffuse(f"Fern {seed}", (0.22, 0.38, 0.08))) for seed in (1, 2)]
    tufts = [grass(seed, diffuse(f"Grass {seed}", (0.30, 0.38, 0.10))) for seed in (1, 2)]
    plant(surface, trees, ferns, tufts)
    buck = deer(diffuse("Deer", (0.30, 0.17, 0.09)))
    buck.matrix_world = placed(rest_on(surface, *DEER), (0, 0, 25))
    sun("Sun", TOWARDS_SUN, 30.0, (1.0, 0.79, 0.52), 0.5)
    world((0.45, 0.62, 1.0), 0.28)
    fog_box((-53, -27, -3.0), (53, 53, 15.0), 0.0045, (0.99, 0.99, 1.0), 0.4)
    camera(EYE, (-0.9, -1.0, 3.1), 28.0)
    finish(__file__, view="Filmic", look="High Contrast", exposure=0.3)


build()
