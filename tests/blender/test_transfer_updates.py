# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes of a transfer function reach the dependency graph and the renders, and nothing else is sent anew."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy
import pytest

from addon import last_render
from addon.sync.images import ImageReader
from addon.sync.reports import Reports
from addon.sync.transfer_functions import read_transfer_functions
from support.small_scenes import light
from support.transfer_scene import add_layers, image, sent, shafts
from tyndall.renderer import RenderConfig, Session
from tyndall.transfer_functions import LayerKind


@pytest.fixture
def updated() -> Iterator[list[str]]:
    seen: list[str] = []

    def note(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        seen.extend(update.id.name for update in depsgraph.updates)

    bpy.app.handlers.depsgraph_update_post.append(note)
    yield seen
    bpy.app.handlers.depsgraph_update_post.remove(note)


def test_each_setting_reaches_the_dependency_graph(function: bpy.types.NodeTree, updated: list[str]) -> None:
    """Set by a script, every property tags its function or its scene."""
    add_layers("DIFFUSION")
    bpy.ops.tyndall.transfer_constraint_add()
    layer = function.tyndall.layers[0]
    groups = (function.tyndall, function.tyndall.x, function.tyndall.y, layer, layer.constraints[0])
    for group in (*groups, shafts().transfer_states[0]):
        for name, rna in group.bl_rna.properties.items():
            is_ours = hasattr(type(group), "UNNAMED") or name != "name"
            if name == "rna_type" or rna.type == "COLLECTION" or rna.is_readonly or not is_ours:
                continue
            bpy.context.view_layer.update()
            updated.clear()
            setattr(group, name, getattr(group, name))
            bpy.context.view_layer.update()
            assert group.id_data.name in updated, f"{name} tags nothing"


def test_an_image_that_has_not_changed_is_sent_as_it_was(function: bpy.types.NodeTree) -> None:
    """The same object: the viewport sees that its picture is the same."""
    add_layers("IMAGE")
    function.tyndall.layers[0].image = image("Picture", 8)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    images = ImageReader()
    first, second = (
        read_transfer_functions(bpy.context.scene, depsgraph, images, Reports())[0].function.layers[0] for _ in range(2)
    )
    assert first.image is second.image
    assert first == second


@pytest.fixture
def rendered(monkeypatch: pytest.MonkeyPatch) -> list[RenderConfig]:
    """What each render was asked for, in turn."""
    seen: list[RenderConfig] = []
    render = Session.render

    def spy(session: Session, camera: Any, config: RenderConfig, *arguments: Any) -> Any:
        seen.append(config)
        return render(session, camera, config, *arguments)

    monkeypatch.setattr(Session, "render", spy)
    return seen


def test_a_render_is_asked_for_what_the_scene_shows(function: bpy.types.NodeTree, rendered: list[RenderConfig]) -> None:
    """The final render's settings hold the functions, and its reports what was left out of them."""
    add_layers("SOLID", "IMAGE")
    lamp = light("SPOT", (0, 0, 5))
    shafts().transfer_light = lamp
    bpy.ops.render.render()
    bpy.data.objects.remove(lamp)
    bpy.ops.render.render()
    config, without_lamp = rendered
    assert (config.reference_light, without_lamp.reference_light) == ("Spot", "")
    assert [one.function.layers[0].kind for one in config.transfer_functions] == [LayerKind.SOLID]
    lines = last_render.statistics_of(bpy.context.scene.name)["reports"]
    assert any('layer "Image": left out: it has no image' in line for line in lines)


def test_a_render_has_the_keyed_value(function: bpy.types.NodeTree, rendered: list[RenderConfig]) -> None:
    """A slider that was moved over its key, and not keyed, counts in the viewport only, as everywhere in Blender."""
    add_layers("SOLID")
    layer = function.tyndall.layers[0]
    layer.opacity = 0.25
    layer.keyframe_insert("opacity", frame=1)
    layer.opacity = 0.75
    assert sent().layers[0].opacity == 0.75
    bpy.ops.render.render()
    assert rendered[0].transfer_functions[0].function.layers[0].opacity == 0.25
