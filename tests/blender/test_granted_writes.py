# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes of handlers are done although Blender believes that something is being drawn, when it denies them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import bpy
import pytest

from addon import over_engine
from addon.granted_writes import write
from addon.over_engine.shafts_scene import shafts_scene_of
from support.small_scenes import empty_scene

Drawing = Callable[[Callable[[], object]], None]


@pytest.fixture
def amid_drawing() -> Iterator[Drawing]:
    """Calls a function where Blender denies writes: in a poll, as in what draws."""
    waiting: list[Callable[[], object]] = []
    errors: list[Exception] = []

    class Asked(bpy.types.Operator):
        bl_idname, bl_label = "tyndall_test.asked", "Asked"

        @classmethod
        def poll(cls, _context: bpy.types.Context) -> bool:
            while waiting:
                try:
                    waiting.pop()()
                except Exception as error:  # noqa: BLE001  Blender would print it, and go on
                    errors.append(error)
            return True

    def call(function: Callable[[], object]) -> None:
        waiting.append(function)
        bpy.ops.tyndall_test.asked.poll()
        assert not waiting, "Blender has asked"
        if errors:
            raise errors.pop()

    bpy.utils.register_class(Asked)
    yield call
    bpy.utils.unregister_class(Asked)


def test_what_blender_denies_is_granted(amid_drawing: Drawing) -> None:
    scene = empty_scene()

    def change() -> None:
        scene.frame_step = 7
        bpy.ops.object.empty_add()

    with pytest.raises(AttributeError, match="not allowed"):
        amid_drawing(change)
    assert (scene.frame_step, len(scene.objects)) == (1, 1)
    amid_drawing(lambda: write(change))
    assert (scene.frame_step, len(scene.objects)) == (7, 2)


@pytest.mark.parametrize("is_drawing", [False, True])
def test_errors_of_the_change_itself_arrive(amid_drawing: Drawing, *, is_drawing: bool) -> None:
    scene = empty_scene()

    def change() -> None:
        scene.frame_step = 7
        scene.no_such_setting = 1

    with pytest.raises(AttributeError, match="no_such_setting"):
        (amid_drawing if is_drawing else lambda function: function())(lambda: write(change))
    write(lambda: setattr(scene, "frame_step", 3))
    assert scene.frame_step == 3


@pytest.mark.parametrize("event", ["depsgraph_update_post", "render_init", "render_pre"])
def test_light_shafts_keep_in_step_amid_drawing(amid_drawing: Drawing, event: str) -> None:
    """Of two threads, one may draw panels while the other is about to render."""
    scene = empty_scene()
    scene.render.engine = "CYCLES"
    over_engine.set_up(scene)
    shafts = shafts_scene_of(scene)
    other = scene.camera.copy()
    scene.collection.objects.link(other)
    shafts.camera, scene.camera = scene.camera, other
    graph = bpy.context.evaluated_depsgraph_get()
    ours = [handler for handler in getattr(bpy.app.handlers, event) if "over_engine" in handler.__module__]
    assert len(ours) == 1
    scene.frame_end += 1
    amid_drawing(lambda: ours[0](scene, graph))
    assert shafts.camera == other
