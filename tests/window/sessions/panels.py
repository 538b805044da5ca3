# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens every tab of the Properties editor in which we draw."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

TABS = (
    ("RENDER", "Cube"),
    ("OUTPUT", "Cube"),
    ("VIEW_LAYER", "Cube"),
    ("WORLD", "Cube"),
    ("OBJECT", "Cube"),
    ("MATERIAL", "Cube"),
    ("DATA", "Light"),
    ("DATA", "Camera"),
)


def session(window: Any) -> Iterator[float]:
    from addon import last_render

    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    last_render.record(
        scene.name,
        {
            "stages": [{"name": "scene update", "seconds": 0.012}, {"name": "light shafts", "seconds": 1.2}],
            "skipped": [{"what": "world", "reason": "it is black"}],
            "counts": {"triangles": 12.0},
            "reports": ['Material "Gold": Glossy is drawn as Diffuse'],
        },
    )
    tree = scene.world.node_tree
    medium = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(medium.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    area = window.area("VIEW_3D")
    area.type = "PROPERTIES"
    yield from window.calm()  # its tabs exist once it has been drawn
    drawn = []
    for tab, object_name in TABS:
        bpy.context.view_layer.objects.active = bpy.data.objects[object_name]
        area.spaces[0].context = tab
        yield from window.calm()
        window.screenshot(f"panels_{tab.lower()}_{object_name.lower()}")
        drawn.append(tab)
    window.facts["drawn"] = drawn
