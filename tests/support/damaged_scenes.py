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

import bpy
import numpy as np

#: The order in which damages are listed is that of these.
from support import (  # noqa: F401
    damaged_frames,
    damaged_glass,
    damaged_images,
    damaged_lamps,
    damaged_lenses,
    damaged_looks,
    damaged_nodes,
    damaged_shapes,
    damaged_surroundings,
    damaged_things,
    damaged_views,
)
from support.agreement_scenes import Arrangement, build
from support.agreement_shapes import diffuse
from support.damages import DAMAGES, Damage, Scene

#: A picture may be black, or absent, after these; after all others the cube must still be lit.
HIDES_ALL = frozenset({"camera", "frame", "darkness"})


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


def damaged(seed: int, damages: tuple[Damage, ...]) -> Scene:
    """Build the scene of a seed, with these damages."""
    scene = build(Arrangement(light="sun", medium="camera inside", occluder="none"), 32, 18)
    bpy.ops.mesh.primitive_cube_add(size=1.2, location=(0.0, 0.0, 1.0))
    bpy.context.object.name = "Sound Cube"
    bpy.context.object.data.materials.append(diffuse((0.9, 0.9, 0.9)))
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples = 1
    scene.tyndall.shafts.method = METHODS[seed % 3]
    # The maps of most are small: those that the error target asks for take a hundred times as long as all the rest.
    scene.tyndall.shafts.resolution = 256 if seed % 10 else 0
    scene.tyndall.shafts.light_samples = scene.tyndall.shafts.world_samples = 4
    indirect = scene.tyndall.indirect  # of combinations: one damage changes the light of what stands beside it
    indirect.has_bounce = indirect.has_mirrors = indirect.has_refraction = seed >= len(DAMAGES) and seed % 2 == 1
    indirect.bounce_samples = 1
    random = np.random.default_rng(1000 + seed)
    for each in damages:
        each.apply(scene, random)
    bpy.context.view_layer.update()
    return scene


def _sound_pixels(seed: int) -> np.ndarray:
    """Of the scene without a damage, with the settings that the seed's has."""
    from support.cycles_reference import rendered_pixels  # noqa: PLC0415

    settings = seed % len(METHODS), seed % 10 == 0
    if settings not in _SOUND_PIXELS:
        _SOUND_PIXELS[settings] = rendered_pixels(damaged(seed, ()))
    return _SOUND_PIXELS[settings]


_SOUND_PIXELS: dict[tuple[int, bool], np.ndarray] = {}


def outcome(seed: int) -> dict[str, object]:
    """Render a seed's scene; say what came of it."""
    from addon import last_render  # noqa: PLC0415  after the path is set
    from support.cycles_reference import rendered_pixels  # noqa: PLC0415

    damages = damages_of(seed)
    scene = damaged(seed, damages)
    name = scene.name
    result: dict[str, object] = {
        "seed": seed,
        "damages": [each.name for each in damages],
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
    if [each.of for each in damages] == ["object"] and not result["error"]:
        beside = np.s_[:, : pixels.shape[1] // 3]  # of what is damaged, which stands to the right
        result["lost_beside"] = float((_sound_pixels(seed)[beside] - pixels[beside]).max())
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
