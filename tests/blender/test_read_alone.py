# SPDX-License-Identifier: GPL-3.0-or-later
"""What changed since the last read is read alone, and becomes what a read of everything would."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import pytest

from addon.sync import scene as sync_scene
from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.followed_scene import Followed
from support.small_scenes import (
    add,
    cube,
    empty_scene,
    light,
    material,
    node,
    read,
)
from tyndall.fingerprints import fingerprint


def test_changed_lights_are_read_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """From a live depsgraph, and as a fresh read would: a slider of a light looks at no instance."""
    scene = empty_scene()
    box, lamp = cube(), light("POINT", (0, 0, 2))
    light("AREA", (0, 0, 4), size=0.0)  # left out, with a report
    spot = light("SPOT", (2, 0, 4))
    if not spot.data.use_nodes:
        spot.data.use_nodes = True
    passes: list[object] = []
    monkeypatch.setattr(sync_scene, "read_placements", counting_passes(sync_scene.read_placements, passes))
    followed = Followed()

    def in_window(new: Callable[..., Any], link: Callable[..., Any]) -> bpy.types.NodeSocket:
        emission = new("ShaderNodeEmission")
        link(new("ShaderNodeTexCoord").outputs["Window"], emission.inputs["Color"])
        return emission.outputs[0]

    def add_edit() -> None:
        lamp.data.tyndall.occluder_edits.add().kind = "HOLES"

    of_lights = [
        lambda: setattr(lamp.data, "energy", 7.0),
        lambda: setattr(spot.data, "energy", 5.0),  # an update of its nodes, too
        lambda: setattr(spot.data.node_tree.nodes["Emission"].inputs["Strength"], "default_value", 2.0),
        lambda: setattr(lamp, "location", (1, 2, 3)),
        lambda: setattr(lamp, "visible_diffuse", False),
        lambda: setattr(lamp, "is_shadow_catcher", False),
        lambda: setattr(lamp.data.tyndall, "scatters_in_media", False),
        add_edit,
        lambda: setattr(scene.camera, "location", (3, 2, 1)),
        lambda: setattr(scene.camera.data, "lens", 20.0),
    ]
    of_more = [
        lambda: box.hide_set(True),
        lambda: box.hide_set(False),
        lambda: lamp.hide_set(True),
        lambda: lamp.hide_set(False),
    ]
    of_parents = [lambda: setattr(box, "parent", lamp)]  # in 3.4 it is no more than a move
    of_both = [lambda: setattr(lamp, "location", (0, 0, 1))]  # and the box with it
    of_seen = [
        lambda: box.data.materials.append(material("Window", in_window)),
        lambda: setattr(scene.camera, "location", (1, 2, 3)),
        lambda: setattr(scene.camera.data, "ortho_scale", 30.0),
    ]
    of_all = [
        lambda: bpy.data.objects.remove(lamp),
        lambda: light("SUN", (0, 0, 2)),
    ]
    with followed.hears():
        scene.view_layers[0].update()
        followed.read()
        for changes, expected in (
            *((of_lights, {0}), (of_more, {1}), (of_parents, {0, 1})),
            *((of_both, {0}), (of_seen, {1}), (of_all, {1})),
        ):
            for change in changes:
                change()
                scene.view_layers[0].update()
                passes.clear()
                found = followed.read()
                assert len(passes) in expected
                assert fingerprint(found) == fingerprint(read())
                assert any("no area" in line for line in found.reports)


def counting_passes(function: Callable[..., Any], passes: list[object]) -> Callable[..., Any]:
    def counted(*arguments: Any, **options: Any) -> Any:
        passes.append(arguments)
        return function(*arguments, **options)

    return counted


def test_moved_objects_are_read_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """From a live depsgraph, and as a fresh read would, whatever hangs on what moves."""
    scene = empty_scene()
    box, child, far = cube("Box"), cube("Child"), cube("Far")
    child.parent = box
    collection = bpy.data.collections.new("Twigs")
    twig = bpy.data.objects.new("Twig", box.data)
    collection.objects.link(twig)
    instancer = add("Instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", collection
    both = bpy.data.objects.new("Both", box.data)  # as itself and in the collection
    collection.objects.link(both)
    scene.collection.objects.link(both)
    centre = cube("Centre")
    points, leaf = cube("Points"), cube("Leaf")
    points.instance_type, leaf.parent = "VERTS", points

    def edit_and_move() -> None:
        box.data.vertices[0].co.z, box.location.x = 9.0, 5.0
        box.data.update_tag()

    def by_centre(new: Any, link: Any) -> Any:
        coordinates = node(new, "ShaderNodeTexCoord")
        coordinates.object = centre
        diffuse = node(new, "ShaderNodeBsdfDiffuse")
        link(coordinates.outputs["Object"], diffuse.inputs["Color"])
        return diffuse.outputs[0]

    far.data.materials.append(material("By centre", surface=by_centre))
    scene.frame_set(1)
    for frame, place in ((1, (0, 0, 0)), (2, (0, 1, 0)), (3, (0, 2, 0))):
        far.location, far.hide_viewport, far.color[0] = place, frame == 3, 1.0 - 0.25 * frame
        far.keyframe_insert("location", frame=frame)
        far.keyframe_insert("hide_viewport", frame=frame)
        far.keyframe_insert("color", frame=frame)
    passes: list[object] = []
    monkeypatch.setattr(sync_scene, "read_placements", counting_passes(sync_scene.read_placements, passes))
    followed = Followed()

    alone = [
        lambda: setattr(box, "location", (1, 2, 3)),  # and its child
        lambda: setattr(box, "scale", (-1, 2, 1)),
        lambda: setattr(child, "rotation_euler", (1, 0, 0)),
    ]
    with_more = [
        lambda: setattr(twig, "location", (1, 0, 0)),
        lambda: setattr(both, "location", (2, 0, 0)),
        lambda: setattr(instancer, "location", (3, 0, 0)),
        lambda: setattr(centre, "location", (0, 3, 0)),
        lambda: setattr(points, "location", (0, 0, 4)),
        edit_and_move,
        lambda: setattr(box, "visible_camera", False),
        lambda: setattr(box, "is_holdout", True),
        lambda: setattr(box, "name", "Renamed"),
        lambda: scene.frame_set(2),
        lambda: scene.frame_set(3),
        lambda: scene.frame_set(1),
        lambda: setattr(box.modifiers.new("Subdivision", "SUBSURF"), "levels", 1),
    ]
    with followed.hears():
        scene.view_layers[0].update()
        followed.read()
        for changes, expected in ((alone, 0), (with_more, None)):
            for index, change in enumerate(changes):
                change()
                scene.view_layers[0].update()
                passes.clear()
                live = followed.read()
                assert expected is None or len(passes) == expected, index
                fresh = SceneReader().read(bpy.context.evaluated_depsgraph_get(), Reports(), lambda: None)
                assert fingerprint(live) == fingerprint(fresh), index
