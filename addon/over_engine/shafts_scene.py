# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that renders the light shafts of another one: made, found, and kept in step with it.

It shares the master's objects, collections and world. Frame and frame size are given to it by Blender, camera by
``render_pre``, all that is ours and the border are read through ``master`` when it renders; the rest is copied here.
Its name begins with a dot: Blender leaves such names out of its menus.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

if TYPE_CHECKING:
    from bpy.types import LayerCollection, Object, Scene, TimelineMarker, ViewLayer

ENGINE = "TYNDALL"
#: What changes how the objects of a scene are evaluated.
_RENDER_SETTINGS = (
    "fps",
    "fps_base",
    "frame_map_old",
    "frame_map_new",
    "use_simplify",
    "simplify_subdivision_render",
    "simplify_child_particles_render",
    "simplify_volumes",
    "use_persistent_data",
)
_SCENE_SETTINGS = ("world", "use_gravity", "gravity", "frame_start", "frame_end")
_UNIT_SETTINGS = ("system", "scale_length")
_LAYER_SETTINGS = ("material_override", "world_override", "use_sky", "use_solid")


def shafts_scene_of(master: Scene) -> Scene | None:
    """The one that renders for ``master``."""
    return next((scene for scene in bpy.data.scenes if scene.tyndall.over_engine.master == master), None)


def new(master: Scene) -> Scene:
    """Of the master's objects, with no animation, markers, strips and nodes of its own."""
    scene = master.copy()
    scene.name = f".{master.name} Light Shafts"
    scene.property_unset("tyndall")
    scene.tyndall.over_engine.master, scene.tyndall.over_engine.renders_shafts = master, True
    scene.animation_data_clear()
    scene.timeline_markers.clear()
    scene.sequence_editor_clear()
    _clear_compositor(scene)
    for layer in list(scene.view_layers)[1:]:
        scene.view_layers.remove(layer)
    layer = scene.view_layers[0]
    layer.name, layer.use = "Light Shafts", True
    scene.render.engine = ENGINE
    scene.render.use_single_layer = False
    layer.tyndall.use_pass_shafts = layer.tyndall.use_pass_transmittance = True
    return scene


def _clear_compositor(scene: Scene) -> None:
    if hasattr(scene, "compositing_node_group"):  # Blender 5.0
        scene.compositing_node_group = None
        return
    if scene.node_tree is not None:
        scene.node_tree.nodes.clear()
    scene.use_nodes = False


def remove(master: Scene) -> None:
    """Its own scene, and those that lost their master."""
    for scene in list(bpy.data.scenes):
        if scene.tyndall.over_engine.master == master or is_orphan(scene):
            bpy.data.scenes.remove(scene)


def is_orphan(scene: Scene) -> bool:
    """Whether it renders for a scene that was deleted."""
    return scene.tyndall.over_engine.renders_shafts and scene.tyndall.over_engine.master is None


def keep_in_step(master: Scene, scene: Scene) -> None:
    """Give ``scene`` what has changed in its master: objects, collections, what view layers show. Writes little."""
    for owner, source, names in (
        (scene, master, _SCENE_SETTINGS),
        (scene.render, master.render, _RENDER_SETTINGS),
        (scene.unit_settings, master.unit_settings, _UNIT_SETTINGS),
    ):
        for name in names:
            _set(owner, name, getattr(source, name))
    follow_frame(master, scene)
    _share(master.collection.objects, scene.collection.objects)
    _share(master.collection.children, scene.collection.children)
    layers = _layers_of(master)
    for name in _LAYER_SETTINGS:
        if hasattr(layers[0], name):
            values = [getattr(layer, name) for layer in layers]
            _set(scene.view_layers[0], name, values[0] if all(value == values[0] for value in values) else _mixed(name))
    _show_same([layer.layer_collection for layer in layers], scene.view_layers[0].layer_collection)


def follow_frame(master: Scene, scene: Scene) -> None:
    """Take the master's camera at its current frame, and its part of a frame. Works while both are about to render."""
    if scene.frame_subframe != master.frame_subframe:
        scene.frame_float = master.frame_float  # Blender hands on whole frames only
    camera = _camera_at_frame(master)
    if camera is not None:  # without one, Blender refuses to render either
        _set(scene, "camera", camera)


def _camera_at_frame(master: Scene) -> Object | None:
    """What markers will have switched to: before a frame of an animation renders, they have not yet."""
    bound = [marker for marker in master.timeline_markers if marker.camera and not marker.camera.hide_render]
    if not bound:
        return master.camera
    past = [marker for marker in bound if marker.frame <= master.frame_current]
    return (max(past, key=_frame_of) if past else min(bound, key=_frame_of)).camera


def _frame_of(marker: TimelineMarker) -> int:
    return marker.frame


def _mixed(name: str) -> bool | None:
    """What stands for view layers that differ: all surfaces and the sky, in their own materials."""
    return True if name.startswith("use_") else None


def _layers_of(master: Scene) -> list[ViewLayer]:
    chosen = master.view_layers.get(master.tyndall.over_engine.view_layer)
    if chosen is not None:
        return [chosen]
    return [layer for layer in master.view_layers if layer.use] or [master.view_layers[0]]


def _set(owner: Any, name: str, value: Any) -> None:  # noqa: ANN401  whatever Blender keeps there
    """Only where it differs: writing tags Blender's scene, and would begin every viewport anew."""
    if getattr(owner, name) != value:
        setattr(owner, name, value)


def _share(wanted: Any, shown: Any) -> None:  # noqa: ANN401  objects or children of a collection
    """Link and unlink until both hold the same."""
    expected, present = set(wanted), set(shown)
    for thing in present - expected:
        shown.unlink(thing)
    for thing in expected - present:
        shown.link(thing)


def _show_same(sources: list[LayerCollection], shown: LayerCollection) -> None:
    """Shown is what one of the sources shows; hidden from the camera is what all that show it hide from it."""
    for child in shown.children:
        same = [
            candidate for source in sources for candidate in source.children if candidate.collection == child.collection
        ]
        showing = [candidate for candidate in same if not candidate.exclude]
        _set(child, "exclude", not showing)
        _set(child, "indirect_only", bool(showing) and all(candidate.indirect_only for candidate in showing))
        _show_same(same, child)
