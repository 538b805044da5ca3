# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews of materials, a world and lamps: in panels, and as icons, whose pixels are compared with those of Cycles."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

#: And the icons that each makes. Cycles takes 10 s for one here.
ICONS = {"TYNDALL": ("plastic", "rough metal", "half there", "world", "lamp"), "CYCLES": ("plastic", "lamp")}
#: Name: inputs of its Principled BSDF.
MATERIALS = {
    "plastic": {"Base Color": (0.8, 0.05, 0.05, 1.0)},
    "rough metal": {"Base Color": (0.9, 0.6, 0.2, 1.0), "Metallic": 1.0, "Roughness": 0.4},
    "half there": {"Base Color": (0.1, 0.4, 0.8, 1.0), "Alpha": 0.5},
}


def things(engine: str) -> dict[str, bpy.types.ID]:
    """New ones, so that no icon is another engine's."""
    made: dict[str, bpy.types.ID] = {}
    for name, inputs in MATERIALS.items():
        material = made[name] = bpy.data.materials.new(f"{name} by {engine}")
        material.use_nodes = True
        for socket, value in inputs.items():
            material.node_tree.nodes["Principled BSDF"].inputs[socket].default_value = value
    world = made["world"] = bpy.data.worlds.new(f"world by {engine}")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.05, 0.2, 0.6, 1.0)
    lamp = made["lamp"] = bpy.data.lights.new(f"lamp by {engine}", "SPOT")
    lamp.energy, lamp.color, lamp.shadow_soft_size = 300.0, (1.0, 0.5, 0.2), 0.0
    return made


def pixels_of(thing: bpy.types.ID) -> np.ndarray:
    preview = thing.preview
    width, height = preview.image_size
    return np.array(preview.image_pixels_float, np.float32).reshape(height, width, 4)


def has_icon(thing: bpy.types.ID) -> bool:
    return thing.preview is not None and bool(thing.preview.image_size[0]) and bool(pixels_of(thing).any())


def icons(window: Any, engine: str) -> Iterator[float]:
    started = time.monotonic()
    made = {name: thing for name, thing in things(engine).items() if name in ICONS[engine]}
    for thing in made.values():
        with bpy.context.temp_override(window=window.bpy_window, id=thing):
            bpy.ops.ed.lib_id_generate_preview()
        yield from window.until(lambda thing=thing: has_icon(thing))
    window.facts[f"{engine} s"] = time.monotonic() - started
    yield 0.5  # an icon fills by and by
    for name, thing in made.items():
        np.save(window.folder / f"{name} by {engine}.npy", pixels_of(thing))


def panels(window: Any) -> Iterator[float]:
    cube, light = bpy.data.objects["Cube"], bpy.data.objects["Light"]
    properties = window.area("PROPERTIES").spaces[0]
    layer = bpy.context.view_layer
    for tab, thing in (("MATERIAL", cube), ("WORLD", cube), ("DATA", light)):
        layer.objects.active = thing
        yield 0.2
        properties.context = tab
        yield 0.3
        yield from window.until(lambda: not bpy.app.is_job_running("RENDER_PREVIEW"))
        yield from window.calm()
        window.screenshot(f"preview_{tab.lower()}")


def session(window: Any) -> Iterator[float]:
    from addon import last_render
    from addon.engine import failures, sessions

    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    for panel in [panel for panel in bpy.types.Panel.__subclasses__() if panel.__name__.endswith("_preview")]:
        if hasattr(panel, "bl_rna"):
            bpy.utils.unregister_class(panel)
            panel.bl_options = set()  # open
            bpy.utils.register_class(panel)
    window.area("VIEW_3D").type = "PROPERTIES"
    yield from window.calm()
    cube = bpy.data.objects["Cube"]
    cube.active_material = bpy.data.materials.new("Short")
    cube.active_material.use_nodes = False  # a short tab, on which the preview is seen
    yield from panels(window)
    for engine in ICONS:
        scene.render.engine = engine
        yield from icons(window, engine)
    scene.render.engine = "TYNDALL"
    window.facts["recorded"] = last_render.statistics_of(scene.name)
    window.facts["kept"] = len(sessions._kept)  # noqa: SLF001
    window.facts["failed"] = failures.last_error()
