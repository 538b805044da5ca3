# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a sun of the world's image by the button in the World properties, undoes that, does it again, updates it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

from support.mouse import click_at, press

CLICKS = ("tyndall.sun_from_world",)
WIDTH_PX, HEIGHT_PX = 64, 32
BUTTON_PX = (380, 174)  #: From the window's left and top, where no other panel of ours is above.


def session(window: Any) -> Iterator[float]:
    from addon.panels import CLASSES
    from addon.panels.world import TYNDALL_PT_world_sun

    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    image = bpy.data.images.new("Sky", WIDTH_PX, HEIGHT_PX, float_buffer=True)
    pixels = np.full((HEIGHT_PX, WIDTH_PX, 4), 0.3, np.float32)
    pixels[22, 20, :3] = 900.0
    image.pixels.foreach_set(pixels.ravel())
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs[0], tree.nodes["Background"].inputs["Color"])
    area = window.area("VIEW_3D")
    area.type = "PROPERTIES"
    yield from window.calm()
    area.spaces[0].context = "WORLD"
    for cls in reversed([one for one in CLASSES if getattr(one, "bl_context", "") == "world"]):
        if cls is not TYNDALL_PT_world_sun:
            bpy.utils.unregister_class(cls)
    yield from window.calm()
    window.screenshot("world_sun_before")

    def suns() -> list[str]:
        return [one.name for one in bpy.context.scene.objects if one.type == "LIGHT" and one.data.type == "SUN"]

    bpy.ops.ed.undo_push(message="begin")
    yield from click_at(window, *BUTTON_PX)
    window.facts["made"] = suns()
    window.facts["takes_sun"] = bpy.context.scene.world.tyndall.takes_sun
    window.screenshot("world_sun_made")
    yield from press(window, ("ctrl+z",))
    window.facts["undone"] = suns()
    yield from press(window, ("ctrl+shift+z",))
    window.facts["redone"] = suns()
    yield from click_at(window, *BUTTON_PX)
    window.facts["updated"] = suns()
    window.screenshot("world_sun_updated")
