# SPDX-License-Identifier: GPL-3.0-or-later
"""Light shafts over another engine's picture: what becomes of the artist's nodes and scenes, and what is said."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import last_render, over_engine, panels
from addon.engine import failures
from addon.over_engine import compositor
from addon.over_engine.shafts_scene import shafts_scene_of
from addon.panels import over_engine as over_engine_panel
from support.over_engine_scene import (
    HEIGHT_PX,
    WIDTH_PX,
    hall_in_fog,
    node_output,
    own_render,
    picture_without_fog,
    rendered,
    set_up,
    use_cycles,
)
from support.recording_layout import HeadlessContext, drawn
from support.small_scenes import cube


@pytest.fixture
def hall(tmp_path: Path) -> bpy.types.Scene:
    return hall_in_fog(tmp_path)


def test_off_the_picture_is_the_engines_own(hall: bpy.types.Scene) -> None:
    """Bit for bit, fog included; on again it is what it was."""
    before = rendered(hall)
    set_up(hall)
    composite = rendered(hall)
    hall.tyndall.over_engine.is_enabled = False
    assert np.array_equal(rendered(hall), before)
    hall.tyndall.over_engine.is_enabled = True
    assert np.array_equal(rendered(hall), composite)
    assert np.abs(composite - before).max() > 0.01


def test_removing_leaves_no_trace(hall: bpy.types.Scene) -> None:
    before = rendered(hall)
    things = everything()
    set_up(hall)
    assert everything() != things
    bpy.ops.tyndall.over_engine_remove()
    compose, fog_group = "Light Shafts over Picture", "Left to Light Shafts"
    assert everything() - things == {compose, fog_group}, "the groups are there for the next time"
    assert things <= everything()
    assert compositor.tree_of(hall) is None
    assert np.array_equal(rendered(hall), before)


def everything() -> set[str]:
    """Scenes and node groups of the file, and what is linked in materials."""
    links = [
        f"{owner.name}: {link.from_node.name} to {link.to_node.name}"
        for owner in bpy.data.materials
        if owner.node_tree
        for link in owner.node_tree.links
    ]
    return {*bpy.data.scenes.keys(), *bpy.data.node_groups.keys(), *links}


def artists_tree(scene: bpy.types.Scene) -> bpy.types.NodeTree:
    """Picture, Glare, output, and a blur that leads nowhere."""
    if compositor.HAS_GROUPS:
        tree = bpy.data.node_groups.new("Mine", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        scene.compositing_node_group = tree
        output = tree.nodes.new("NodeGroupOutput")
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("CompositorNodeComposite")
    picture, flip, blur = (tree.nodes.new(f"CompositorNode{kind}") for kind in ("RLayers", "Flip", "Blur"))
    tree.links.new(picture.outputs["Image"], flip.inputs["Image"])
    tree.links.new(picture.outputs["Image"], blur.inputs["Image"])
    tree.links.new(flip.outputs[0], output.inputs[0])
    return tree


def links_of(tree: bpy.types.NodeTree) -> set[tuple[str, str, str, str]]:
    return {
        (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
        for link in tree.links
    }


def test_the_artists_nodes_stay_as_they_are(hall: bpy.types.Scene) -> None:
    """Ours go before the output; setting up twice does nothing twice; removing restores the links."""
    tree = artists_tree(hall)
    nodes, links = set(tree.nodes.keys()), links_of(tree)
    places = {node.name: tuple(node.location) for node in tree.nodes}
    set_up(hall)
    assert len(tree.nodes) == len(nodes) + 2
    assert links - links_of(tree) == {link for link in links if "Flip" in link[0]}
    assert all(tuple(tree.nodes[name].location) == place for name, place in places.items())
    composite, once = rendered(hall), links_of(tree)
    bpy.ops.tyndall.over_engine_set_up()
    hall.tyndall.over_engine.is_enabled = True
    assert (len(tree.nodes), links_of(tree), len(bpy.data.scenes)) == (len(nodes) + 2, once, 2)
    assert np.array_equal(rendered(hall), composite)
    bpy.ops.tyndall.over_engine_remove()
    assert (set(tree.nodes.keys()), links_of(tree), len(bpy.data.scenes)) == (nodes, links, 1)


def test_nodes_that_were_added_since_stay_linked(hall: bpy.types.Scene) -> None:
    """Whether the nodes before them were made for us, or by the artist."""
    set_up(hall)
    tree, node = compositor.tree_of(hall), compositor.compose_node(hall)
    flip = tree.nodes.new("CompositorNodeFlip")
    output = node.outputs["Image"].links[0].to_socket
    tree.links.new(node.outputs["Image"], flip.inputs["Image"])
    tree.links.new(flip.outputs[0], output)
    assert over_engine.problems(hall) == []
    bpy.ops.tyndall.over_engine_set_up()
    assert len(tree.nodes) == 5
    before = picture_without_fog(hall)
    bpy.ops.tyndall.over_engine_remove()
    assert [link.from_node.type for link in flip.inputs["Image"].links] == ["R_LAYERS"]
    assert [link.from_node.name for link in output.links] == [flip.name]
    assert before.any()


def test_it_survives_undo_save_and_reload(hall: bpy.types.Scene, tmp_path: Path) -> None:
    """The switch, the second scene, the nodes and the fog, and the picture."""
    bpy.ops.ed.undo_push(message="before")
    set_up(hall)
    composite = rendered(hall)
    bpy.ops.ed.undo_push(message="set up")
    bpy.ops.ed.undo()
    hall = bpy.context.scene
    assert (over_engine.is_set_up(hall), len(bpy.data.scenes)) == (False, 1)
    assert not hall.tyndall.over_engine.is_enabled
    bpy.ops.ed.redo()
    hall = bpy.context.scene
    assert over_engine.problems(hall) == []
    assert np.array_equal(rendered(hall), composite)
    blend = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    bpy.ops.wm.read_factory_settings()
    bpy.ops.wm.open_mainfile(filepath=blend)
    hall = bpy.context.scene
    assert over_engine.problems(hall) == []
    assert np.array_equal(rendered(hall), composite)


def test_appended_it_brings_all_of_it_along(hall: bpy.types.Scene, tmp_path: Path) -> None:
    set_up(hall)
    composite = rendered(hall)
    path, blend = hall.render.filepath, str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.name = "Other"
    with bpy.data.libraries.load(blend, link=False) as (_, wanted):
        wanted.scenes = ["Scene"]
    appended = bpy.data.scenes["Scene"]
    if bpy.app.version < (4, 0, 0):  # appends no scene that a node reads
        assert "deleted" in over_engine.problems(appended)[0]
        over_engine.set_up(appended)
    assert over_engine.problems(appended) == []
    assert shafts_scene_of(appended) is not None
    appended.render.filepath = path
    assert np.array_equal(rendered(appended), composite)


def test_new_objects_and_collections_are_seen(hall: bpy.types.Scene) -> None:
    """Whether they come into the scene itself or into a collection of it, and they go again; at once in a script."""
    set_up(hall)
    before, middle = rendered(hall), (HEIGHT_PX // 2, WIDTH_PX // 2)
    open_view = node_output(hall, "Transmittance")[middle][0]
    wall = cube("Wall", bpy.data.materials["Paint"])
    wall.location, wall.scale = (0, -3, 2), (1, 0.1, 2)
    blocked = node_output(hall, "Transmittance")[middle][0]
    assert blocked > open_view + 0.1
    collection = bpy.data.collections.new("Props")
    hall.collection.children.link(collection)
    hall.collection.objects.unlink(wall)
    collection.objects.link(wall)
    assert node_output(hall, "Transmittance")[middle][0] == blocked
    bpy.data.objects.remove(wall)
    bpy.data.collections.remove(collection)
    assert np.array_equal(rendered(hall), before)


def test_fog_of_a_linked_material_is_named(hall: bpy.types.Scene, tmp_path: Path) -> None:
    """It cannot be changed, and would be drawn twice."""
    blend = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend, copy=True)
    bpy.data.materials.remove(bpy.data.materials["Fog"])
    with bpy.data.libraries.load(blend, link=True) as (_, wanted):
        wanted.materials = ["Fog"]
    bpy.data.objects["Fog"].data.materials[0] = wanted.materials[0]
    bpy.ops.tyndall.over_engine_set_up()
    assert bpy.ops.tyndall.leave_fog() == {"CANCELLED"}
    assert not any(node.type == "GROUP" for node in wanted.materials[0].node_tree.nodes)


def test_a_deleted_scene_leaves_the_picture_alone_and_is_mended(hall: bpy.types.Scene) -> None:
    set_up(hall)
    composite = rendered(hall)
    picture = picture_without_fog(hall)
    bpy.data.scenes.remove(shafts_scene_of(hall))
    assert "deleted" in over_engine.problems(hall)[0]
    assert np.array_equal(rendered(hall), picture)
    bpy.ops.tyndall.over_engine_set_up()
    assert over_engine.problems(hall) == []
    assert np.array_equal(rendered(hall), composite)


def test_a_missing_group_is_named_and_mended(hall: bpy.types.Scene) -> None:
    set_up(hall)
    composite = rendered(hall)
    bpy.data.node_groups.remove(bpy.data.node_groups["Light Shafts over Picture"])
    assert "missing" in over_engine.problems(hall)[0]
    bpy.ops.tyndall.over_engine_set_up()
    assert over_engine.problems(hall) == []
    assert np.array_equal(rendered(hall), composite)


def test_what_the_artist_did_to_the_nodes_is_named(hall: bpy.types.Scene) -> None:
    """Muted, unlinked, removed, or compositing off: each has its words, and the button mends what it may."""
    set_up(hall)
    tree, node = compositor.tree_of(hall), compositor.compose_node(hall)
    node.mute = True
    assert "muted" in over_engine.problems(hall)[0]
    bpy.ops.tyndall.over_engine_set_up()
    hall.render.use_compositing = False
    assert "Post Processing" in over_engine.problems(hall)[0]
    hall.render.use_compositing = True
    (output,) = compositor.outputs_of(tree)
    tree.links.new(node.inputs["Image"].links[0].from_socket, output)
    assert "do not reach" in over_engine.problems(hall)[0]
    bpy.ops.tyndall.over_engine_set_up()
    assert over_engine.problems(hall) == []
    for layer in [layer for layer in tree.nodes if layer.type == "R_LAYERS" and layer.scene != hall]:
        tree.nodes.remove(layer)
    assert "No node reads" in over_engine.problems(hall)[0]
    bpy.ops.tyndall.over_engine_set_up()
    assert over_engine.problems(hall) == []


def test_a_copied_scene_gets_its_own(hall: bpy.types.Scene) -> None:
    """Until then its nodes read the light shafts of the scene that it was copied from, and the panel says so."""
    set_up(hall)
    copied = hall.copy()
    if compositor.HAS_GROUPS:
        assert "make it single-user" in over_engine.problems(copied)[0]
        copied.compositing_node_group = copied.compositing_node_group.copy()
    assert over_engine.problems(copied) != []
    with bpy.context.temp_override(scene=copied):
        bpy.ops.tyndall.over_engine_set_up()
    assert (over_engine.problems(copied), over_engine.problems(hall)) == ([], [])
    assert shafts_scene_of(copied) != shafts_scene_of(hall)


@pytest.mark.parametrize("why", ["linked", "switched off", "shared", "Tyndall", "shafts"])
def test_where_it_cannot_be_set_up_the_button_says_why(hall: bpy.types.Scene, tmp_path: Path, why: str) -> None:
    words = {
        "linked": "linked",
        "switched off": "Use Nodes",
        "shared": "single-user",
        "Tyndall": "itself",
        "shafts": "holds",
    }
    if why == ("switched off" if compositor.HAS_GROUPS else "shared"):
        pytest.skip("of the other versions")
    scene = hall
    if why == "linked":
        artists_tree(hall)
        blend = str(tmp_path / "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=blend, copy=True)
        with bpy.data.libraries.load(blend, link=True) as (_, wanted):
            wanted.scenes = ["Scene"]
        scene = wanted.scenes[0]
    elif why == "switched off":
        artists_tree(hall)
        hall.use_nodes = False
    elif why == "shared":
        artists_tree(hall)
        bpy.data.scenes.new("Other").compositing_node_group = hall.compositing_node_group
    elif why == "Tyndall":
        hall.render.engine = "TYNDALL"
    else:
        set_up(hall)
        scene = shafts_scene_of(hall)
    assert words[why] in over_engine.why_not(scene)
    with bpy.context.temp_override(scene=scene):
        assert not bpy.ops.tyndall.over_engine_set_up.poll()
    if why not in {"shafts", "linked"}:
        scene.tyndall.over_engine.is_enabled = True
        assert not over_engine.is_set_up(scene)


def test_a_scene_that_turns_to_us_has_its_shafts_once(hall: bpy.types.Scene) -> None:
    own = own_render(hall)
    use_cycles(hall)
    set_up(hall)
    hall.render.engine = "TYNDALL"
    assert np.array_equal(rendered(hall), own)
    assert "itself" in over_engine.problems(hall)[0]


def test_without_a_camera_blender_says_so(hall: bpy.types.Scene) -> None:
    set_up(hall)
    hall.camera = None
    assert "no camera" in over_engine.problems(hall)[0]
    with pytest.raises(RuntimeError, match=r"(?i)no camera"):
        bpy.ops.render.render()


def test_an_error_of_ours_leaves_the_picture_alone_and_is_told(hall: bpy.types.Scene) -> None:
    """Blender hands errors of the second scene to nobody: the panel says what it was, and the picture has no shafts."""
    hall.camera.scale.z = 0.0
    set_up(hall)
    composite = rendered(hall)
    assert "its scale is 0" in failures.last_error()
    assert "its scale is 0" in last_render.statistics_of(hall.name)["reports"][0]
    assert np.array_equal(composite, picture_without_fog(hall))


@pytest.mark.parametrize("panel", over_engine_panel.CLASSES)
def test_the_panel_says_what_is(hall: bpy.types.Scene, panel: type[bpy.types.Panel]) -> None:
    """Under any engine: how to set it up, then settings, what is wrong, and what the last render did."""
    assert "Set Up" in drawn(panel, engine="CYCLES")
    set_up(hall)
    rendered(hall)
    shown = drawn(panel, engine="CYCLES")
    assert "Set Up Again" not in shown
    assert {"default_value", "pixel_samples", "method", "Leave Fog to the Shafts", "Remove"} <= set(shown)
    assert any("last render" in line for line in shown)
    assert drawn(panels.transfer_functions.TYNDALL_PT_sidebar_transfer_functions, engine="CYCLES")
    bpy.data.scenes.remove(shafts_scene_of(hall))
    assert "Set Up Again" in drawn(panel, engine="CYCLES")
    bpy.ops.tyndall.over_engine_remove()
    hall.render.engine = "TYNDALL"
    assert not panel.poll(HeadlessContext(engine="TYNDALL"))
