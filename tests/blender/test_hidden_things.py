# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees what: the outliner's switches, local view and a viewport's kinds of objects, for fog as for surfaces."""

from __future__ import annotations

import bpy
import pytest

from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.small_scenes import CUBE_CORNERS, CUBE_FACES, add, cube, empty_scene, light, material, mesh, node, read
from tyndall.scene_description import SceneDescription


@pytest.fixture(params=["surface", "fog"])
def hideable(request: pytest.FixtureRequest) -> tuple[bpy.types.Scene, bpy.types.Material]:
    """An empty scene, and what its objects are of: what hides a surface must hide a fog."""
    scene = empty_scene()
    fog = material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter").outputs[0])
    return scene, fog if request.param == "fog" else material("Surface")


def names_in(description: SceneDescription) -> set[str]:
    return {name for group in description.instances for name in group.object_names}


def collection_of(thing: bpy.types.Object) -> bpy.types.LayerCollection:
    """Move an object into a collection of its own."""
    scene = bpy.context.scene
    collection = bpy.data.collections.new(thing.name)
    scene.collection.children.link(collection)
    scene.collection.objects.unlink(thing)
    collection.objects.link(thing)
    return bpy.context.view_layer.layer_collection.children[thing.name]


def a_viewport() -> tuple[bpy.types.Area, bpy.types.SpaceView3D]:
    areas = bpy.context.window_manager.windows[0].screen.areas
    area = next(area for area in areas if area.type == "VIEW_3D")
    return area, area.spaces[0]


def names_in_viewport() -> set[str]:
    """What the window's 3D viewport would draw."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return names_in(SceneReader().read(depsgraph, Reports(), lambda: None, viewport=a_viewport()[1]))


def names_in_render(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """What a final render of the scene is given."""
    rendered = []
    read_scene = SceneReader.read

    def remember(self: SceneReader, *arguments: object, **options: object) -> SceneDescription:
        rendered.append(read_scene(self, *arguments, **options))
        return rendered[-1]

    monkeypatch.setattr(SceneReader, "read", remember)
    bpy.ops.render.render()
    return names_in(rendered[-1])


def test_what_is_hidden_is_hidden_for_fog_as_for_surfaces(
    hideable: tuple[bpy.types.Scene, bpy.types.Material], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The switches of Blender's outliner: camera and monitor, of objects and of collections; eye; check mark."""
    _, of = hideable
    names = ("Shown", "Render", "Monitor", "Eye", "Render+", "Monitor+", "Eye+", "Unchecked")
    things = {name: cube(name, of) for name in names}
    things["Render"].hide_render = True
    things["Monitor"].hide_viewport = True
    things["Eye"].hide_set(True)
    collection_of(things["Render+"]).collection.hide_render = True
    collection_of(things["Monitor+"]).collection.hide_viewport = True
    collection_of(things["Eye+"]).hide_viewport = True
    collection_of(things["Unchecked"]).exclude = True
    assert names_in_render(monkeypatch) == {"Shown", "Monitor", "Eye", "Monitor+", "Eye+"}
    assert names_in_viewport() == {"Shown", "Render", "Render+"}


def test_local_view_hides_what_is_not_in_it(hideable: tuple[bpy.types.Scene, bpy.types.Material]) -> None:
    """Lamps as well; and instances, with what makes them."""
    _, of = hideable
    collection = bpy.data.collections.new("Twig")
    collection.objects.link(bpy.data.objects.new("Leaf", mesh("Leaf", CUBE_CORNERS, CUBE_FACES, of)))
    for name in ("Seen", "Unseen"):
        instancer = add(name, None)
        instancer.instance_type, instancer.instance_collection = "COLLECTION", collection
    cube("Alone", of)
    light("POINT", (0, 0, 2))
    assert names_in_viewport() == {"Leaf", "Alone"}
    for thing in bpy.context.view_layer.objects:
        thing.select_set(thing.name in {"Alone", "Seen"})
    area, space = a_viewport()
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area, region=region):
        bpy.ops.view3d.localview()
        reader, depsgraph = SceneReader(), bpy.context.evaluated_depsgraph_get()
        description = reader.read(depsgraph, Reports(), lambda: None, viewport=space)
        bpy.ops.view3d.localview()
    assert sorted(name for group in description.instances for name in group.object_names) == ["Alone", "Leaf"]
    assert not description.lights
    assert len(read().lights) == 1
    everything = reader.read(bpy.context.evaluated_depsgraph_get(), Reports(), lambda: None, viewport=space)
    assert sorted(name for group in everything.instances for name in group.object_names) == ["Alone", "Leaf", "Leaf"]


def test_a_viewport_hides_kinds_of_objects(hideable: tuple[bpy.types.Scene, bpy.types.Material]) -> None:
    """Each kind for itself: without empties to see, what they instance is still there."""
    _, of = hideable
    collection = bpy.data.collections.new("Twig")
    collection.objects.link(bpy.data.objects.new("Leaf", mesh("Leaf", CUBE_CORNERS, CUBE_FACES, of)))
    instancer = add("Instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", collection
    text = bpy.data.curves.new("Text", "FONT")
    text.body, text.extrude = "fog", 0.1
    text.materials.append(of)
    add("Text", text)
    _, space = a_viewport()
    assert names_in_viewport() == {"Leaf", "Text"}
    space.show_object_viewport_empty = False
    assert names_in_viewport() == {"Leaf", "Text"}
    space.show_object_viewport_font = False
    assert names_in_viewport() == {"Leaf"}
    collection_of(instancer).hide_viewport = True
    assert not names_in_viewport()
    space.show_object_viewport_font, space.show_object_viewport_mesh = True, False
    assert names_in_viewport() == {"Text"}


def test_a_collection_for_indirect_light_only_is_not_seen() -> None:
    """Nor are instances that something in it makes; their shadows are."""
    empty_scene()
    leaf = bpy.data.objects.new("Leaf", mesh("Leaf", CUBE_CORNERS, CUBE_FACES))
    twig = bpy.data.collections.new("Twig")
    twig.objects.link(leaf)
    instancer = add("Instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", twig
    cube("Seen")
    for thing in (cube("Unseen"), instancer):
        collection_of(thing).indirect_only = True
    flags = {group.object_names[0]: (group.is_camera_visible, group.casts_shadow) for group in read().instances}
    assert flags == {"Seen": (True, True), "Unseen": (False, True), "Leaf": (False, True)}


def test_a_holdout_is_one_whether_object_or_collection_asks_for_it() -> None:
    empty_scene()
    cube("Plain")
    cube("By itself").is_holdout = True
    collection_of(cube("By collection")).holdout = True
    held_out = {group.object_names[0]: group.is_held_out for group in read().instances}
    assert held_out == {"Plain": False, "By itself": True, "By collection": True}
