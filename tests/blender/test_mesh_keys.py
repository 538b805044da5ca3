# SPDX-License-Identifier: GPL-3.0-or-later
"""The same key promises the same content: the native side sends and builds nothing for it."""

from __future__ import annotations

import bpy
import pytest

from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.small_scenes import (
    cube,
    empty_scene,
    placements,
    plane,
    read,
    red_green,
)


def key_of(thing: bpy.types.Object, reader: SceneReader) -> str:
    return placements(read(reader), thing.name)[0].mesh.key


def test_a_key_outlives_moves_materials_and_frames() -> None:
    scene, reader = empty_scene(), SceneReader()
    thing = cube()
    before = key_of(thing, reader)
    thing.location.x = 3
    thing.data.materials.append(red_green()[0])
    scene.frame_set(7)
    assert key_of(thing, reader) == before
    assert key_of(thing, SceneReader()) == before


@pytest.mark.parametrize("change", ["vertex", "face", "smooth", "uv", "slot"])
def test_a_key_changes_with_the_content(change: str) -> None:
    empty_scene()
    reader, thing = SceneReader(), plane()
    for one in red_green():
        thing.data.materials.append(one)
    before = key_of(thing, reader)
    data = thing.data
    if change == "vertex":
        data.vertices[0].co.z = 1e-4
    elif change == "face":
        data.flip_normals()
    elif change == "smooth":
        data.vertices[0].co.z = 5  # a bent plane: smooth and flat differ
        data.update()
        before = key_of(thing, reader)
        data.polygons[0].use_smooth = True
    elif change == "uv":
        data.uv_layers[0].data[0].uv = (0.5, 0.25)
    else:
        data.polygons[0].material_index = 1
    data.update()
    assert key_of(thing, reader) != before


def test_a_live_depsgraph_reads_only_what_it_updated(
    monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    """Moving the camera reads no mesh; editing one of two meshes reads that one."""
    from addon.sync import scene as scene_module  # noqa: PLC0415  to count its calls

    scene, reader = empty_scene(), SceneReader()
    first, second = cube("First"), plane()
    names_read: list[str] = []
    original = scene_module.read_mesh

    def counting(data: bpy.types.Mesh, *others: object) -> object:
        names_read.append(data.name)
        return original(data, *others)

    monkeypatch.setattr(scene_module, "read_mesh", counting)

    def hear(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        reader.note_updates(depsgraph)

    def read_live() -> list[str]:
        names_read.clear()
        bpy.context.view_layer.update()
        reader.read(bpy.context.evaluated_depsgraph_get(), Reports(), lambda: None, is_live=True)
        return sorted(names_read)

    bpy.app.handlers.depsgraph_update_post.append(hear)
    request.addfinalizer(lambda: bpy.app.handlers.depsgraph_update_post.remove(hear))

    assert read_live() == ["First", "Plane"]
    scene.camera.location.x = 1
    assert read_live() == []
    second.location.x = 2
    assert read_live() == []
    first.data.vertices[0].co.z = 9
    first.data.update()
    first.data.update_tag()
    assert read_live() == ["First"]
