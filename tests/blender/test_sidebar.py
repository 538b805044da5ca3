# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar's tab Light Shafts: its steps in the order of the work, what each shows, and what its buttons do."""

from __future__ import annotations

import math

import bpy
import pytest

from addon import last_render, panels
from addon.animation_paths import curves_at
from addon.keyed_shafts import animated_properties
from addon.panels import animate, medium, output
from addon.properties.heterogeneity import WIND_PATH
from support.recording_layout import drawn
from support.small_scenes import add, cube, light, material, node

ANIMATE = animate.TYNDALL_PT_sidebar_animate


def fog(name: str = "Fog", kind: str = "ShaderNodeVolumeScatter", **inputs: object) -> bpy.types.Material:
    return material(name, volume=lambda new, _link: node(new, kind, **inputs).outputs["Volume"])


def labels() -> list[str]:
    return [found.label for found in animated_properties(bpy.context.scene)]


def identifier(label: str) -> str:
    return next(found.identifier for found in animated_properties(bpy.context.scene) if found.label == label)


def key_frames(label: str) -> tuple[float, ...]:
    return next(found.key_frames for found in animated_properties(bpy.context.scene) if found.label == label)


def test_the_tab_follows_the_way_of_working(scene: bpy.types.Scene) -> None:
    """From the medium to the output; what belongs to a step is inside of it."""
    steps = [
        cls.bl_label
        for cls in panels.CLASSES
        if getattr(cls, "bl_category", "") == "Light Shafts" and not hasattr(cls, "bl_parent_id")
    ]
    assert steps[:6] == ["Medium", "Shape the Shafts", "Colour the Shafts", "Texture the Air", "Animate", "Output"]
    within = {cls.bl_label for cls in panels.CLASSES if getattr(cls, "bl_parent_id", "") == "TYNDALL_PT_sidebar_colour"}
    assert within == {"Transfer Functions", "Gobo", "Paint the Shafts"}


# Medium


def test_medium_says_what_is_missing_and_what_a_density_means(scene: bpy.types.Scene) -> None:
    """An empty scene is offered a fog box; one with haze its numbers, where no node stands in their way."""
    shown = drawn(medium.TYNDALL_PT_sidebar_medium)
    assert " ".join(shown) == "Shafts show in haze: fill the scene with some tyndall.add_fog_box"
    cube("Box", fog(Density=0.1))
    shown = drawn(medium.TYNDALL_PT_sidebar_medium)
    assert "Half the light is left after 6.93 m" in shown
    assert shown.count("default_value") == 2
    assert shown[-1] == "attenuates_light"


def test_the_density_of_a_grid_is_not_taken_for_a_reach(scene: bpy.types.Scene) -> None:
    """It multiplies what the file holds, which the panel has not read."""
    data = bpy.data.volumes.new("Smoke")
    data.materials.append(fog("Smoke", "ShaderNodeVolumePrincipled", Density=2.0))
    add("Smoke", data)
    shown = drawn(medium.TYNDALL_PT_sidebar_medium)
    assert shown.count("default_value") == 2
    assert not any("Half the light" in line for line in shown)


def test_a_medium_of_other_nodes_says_that_it_is(scene: bpy.types.Scene) -> None:
    """A shader that mixes two has no density of its own."""
    cube("Box", material("Mix", volume=lambda new, _link: new("ShaderNodeMixShader").outputs[0]))
    assert "By its nodes: Mix Shader" in drawn(medium.TYNDALL_PT_sidebar_medium)


def test_many_media_do_not_fill_the_sidebar(scene: bpy.types.Scene) -> None:
    """Six, and how many more there are; materials that nothing uses do not count."""
    for index in range(9):
        made = fog(f"Fog {index}")
        if index < 8:
            cube(f"Box {index}", made)
    shown = drawn(medium.TYNDALL_PT_sidebar_medium)
    assert shown.count("name") == 6
    assert "... and 2 more materials" in shown


def test_a_world_without_bounds_is_named(scene: bpy.types.Scene) -> None:
    """Its density is there to be changed, and the remedy beside it."""
    tree = scene.world.node_tree
    tree.links.new(tree.nodes.new("ShaderNodeVolumeScatter").outputs[0], tree.get_output_node("CYCLES").inputs[1])
    shown = drawn(medium.TYNDALL_PT_sidebar_medium)
    assert "Turn into a Fog Box" in shown
    assert "tyndall.add_fog_box" not in shown
    assert shown.count("default_value") == 2


def test_select_medium_finds_what_holds_it(scene: bpy.types.Scene) -> None:
    """All objects with this material; hidden ones cannot be selected, and a button says so."""
    made = fog()
    boxes = [cube(name, made) for name in ("Near", "Far")]
    assert bpy.ops.tyndall.select_medium(material_name="Fog") == {"FINISHED"}
    assert {thing.name for thing in bpy.context.selected_objects} == {"Near", "Far"}
    assert bpy.context.view_layer.objects.active in boxes
    for box in boxes:
        box.hide_set(True)
    with pytest.raises(RuntimeError, match="what holds it is hidden"):
        bpy.ops.tyndall.select_medium(material_name="Fog")
    for box in boxes:
        bpy.data.objects.remove(box)
    with pytest.raises(RuntimeError, match="nothing in this scene has it"):
        bpy.ops.tyndall.select_medium(material_name="Fog")
    with pytest.raises(RuntimeError, match="nothing in this scene has it"):
        bpy.ops.tyndall.select_medium(material_name="gone")


# Animate


def test_animate_lists_what_is_keyed_by_the_names_that_artists_know(scene: bpy.types.Scene) -> None:
    """Of the scene, of lights and their edits, of functions and of media; not what has nothing to do with shafts."""
    assert labels() == []
    assert any("Nothing of the shafts is keyed" in line for line in drawn(ANIMATE))
    scene.tyndall.shafts.keyframe_insert("transfer_mix", frame=1)
    scene.keyframe_insert(WIND_PATH, frame=1)
    scene.driver_add("tyndall.heterogeneity.amount")
    scene.view_settings.keyframe_insert("exposure", frame=1)
    lamp = bpy.data.objects["Light"]
    lamp.keyframe_insert("location", frame=1)
    bpy.context.view_layer.objects.active = lamp
    bpy.ops.tyndall.occluder_edit_add(kind="HOLES")
    lamp.data.tyndall.occluder_edits[0].noise.keyframe_insert("turn_rad", frame=1)
    lamp.data.keyframe_insert("energy", frame=1)
    lamp.data.keyframe_insert("cutoff_distance", frame=1)
    bpy.ops.tyndall.transfer_function_new()
    bpy.ops.tyndall.transfer_layer_add(kind="GRADIENT")
    function = scene.tyndall.shafts.transfer_states[0].function
    function.tyndall.layers[0].keyframe_insert("opacity", frame=1)
    ramp = function.nodes[function.tyndall.layers[0].ramp_node]
    function.keyframe_insert(f'nodes["{ramp.name}"].color_ramp.elements[0].color', frame=1)
    made = fog()
    cube("Box", made)
    shader = made.node_tree.nodes["Volume Scatter"]
    shader.inputs["Density"].keyframe_insert("default_value", frame=1)
    assert labels() == [
        "Air: Amount",
        "Air: Wind",
        "Shafts: Mix",
        f"Light: {lamp.data.bl_rna.properties['energy'].name}",
        "Make Holes: Turn",
        f"{ramp.name}: Color",
        "Gradient: Opacity",
        "Volume Scatter: Density",
    ]
    shown = drawn(ANIMATE)
    for name in ("amount", "wind_m_per_s", "turn_rad", "opacity", "default_value", "color"):
        assert name in shown


def test_keys_of_what_is_gone_are_left_out(scene: bpy.types.Scene) -> None:
    """A script removed an item and left its keys: the list shows the others."""
    lamp = bpy.data.lights["Light"]
    for _ in range(2):
        lamp.tyndall.occluder_edits.add()
        lamp.tyndall.occluder_edits[-1].keyframe_insert("size_m", frame=1)
    lamp.tyndall.occluder_edits.remove(1)
    assert len(labels()) == 1


def test_jumps_stop_at_every_key_of_the_shafts(scene: bpy.types.Scene) -> None:
    """Forwards and backwards, over all of them together, fractions of frames included; then there is none."""
    scene.tyndall.shafts.keyframe_insert("transfer_mix", frame=10)
    bpy.data.lights["Light"].keyframe_insert("energy", frame=4.5)
    scene.tyndall.heterogeneity.keyframe_insert("amount", frame=20)
    scene.frame_set(1)
    seen = []
    while bpy.ops.tyndall.jump_to_key(direction="NEXT") == {"FINISHED"}:
        seen.append(scene.frame_current_final)
    assert seen == [4.5, 10.0, 20.0]
    assert bpy.ops.tyndall.jump_to_key(direction="PREVIOUS") == {"FINISHED"}
    assert scene.frame_current_final == 10.0


def test_a_key_is_set_and_removed_at_this_frame(scene: bpy.types.Scene) -> None:
    """The diamond before each name; removing the last one ends the animation."""
    amount = scene.tyndall.heterogeneity
    amount.amount = 0.25
    amount.keyframe_insert("amount", frame=1)
    scene.frame_set(11)
    amount.amount = 0.75
    assert bpy.ops.tyndall.toggle_key(identifier=identifier("Air: Amount")) == {"FINISHED"}
    assert key_frames("Air: Amount") == (1.0, 11.0)
    scene.frame_set(1)
    assert amount.amount == 0.25
    name = identifier("Air: Amount")
    bpy.ops.tyndall.toggle_key(identifier=name)
    assert key_frames("Air: Amount") == (11.0,)
    scene.frame_set(11)
    bpy.ops.tyndall.toggle_key(identifier=name)
    assert labels() == []
    with pytest.raises(RuntimeError, match="Not keyed any more"):
        bpy.ops.tyndall.toggle_key(identifier=name)


def test_key_wind_keys_all_three_of_its_axes(scene: bpy.types.Scene) -> None:
    """Once there is a texture that it could carry."""
    assert not bpy.ops.tyndall.key_wind.poll()
    air = scene.tyndall.heterogeneity
    air.is_enabled, air.wind_m_per_s = True, (1.0, 2.0, 3.0)
    scene.frame_set(7)
    assert bpy.ops.tyndall.key_wind() == {"FINISHED"}
    (found,) = animated_properties(scene)
    assert found.key_frames == (7.0,)
    assert len(curves_at(scene, WIND_PATH)) == 3
    assert tuple(air.wind_m_per_s) == (1.0, 2.0, 3.0)


def test_holes_loop_over_the_frame_range(scene: bpy.types.Scene) -> None:
    """The frame after the last is the first again, they turn evenly, and they sway, or nothing would be seen."""
    lamp = light("SUN", (0.0, 0.0, 5.0))
    bpy.context.view_layer.objects.active = lamp
    bpy.ops.tyndall.occluder_edit_add(kind="CLOSE")
    assert not bpy.ops.tyndall.loop_holes.poll()
    bpy.ops.tyndall.occluder_edit_add(kind="HOLES")
    noise = lamp.data.tyndall.occluder_edits[-1].noise
    noise.turn_rad = 1.0
    noise.keyframe_insert("turn_rad", frame=60)
    scene.frame_start, scene.frame_end = 1, 100
    assert bpy.ops.tyndall.loop_holes() == {"FINISHED"}
    assert key_frames("Make Holes: Turn") == (1.0, 101.0)
    turns = []
    for frame in (1, 26, 51, 101):
        scene.frame_set(frame)
        turns.append(lamp.data.evaluated_get(bpy.context.evaluated_depsgraph_get()).tyndall.occluder_edits[1].noise)
        turns[-1] = turns[-1].turn_rad / (2.0 * math.pi)
    assert turns == pytest.approx([0.0, 0.25, 0.5, 1.0], abs=1e-6)
    assert noise.sway == 0.5


# Output


def test_output_has_the_passes_the_quality_and_the_last_render(scene: bpy.types.Scene) -> None:
    """What the compositor gets, how well it is found, and what it took; Blender's own buttons render."""
    shown = drawn(output.TYNDALL_PT_sidebar_output)
    assert shown[1:4] == ["use_pass_shafts", "use_pass_shafts_visibility", "use_pass_transmittance"]
    assert shown[4:] == ["Render Image", "Render Animation"]
    assert {"method", "error_target", "light_samples"} <= set(drawn(output.TYNDALL_PT_sidebar_quality))
    with pytest.raises(AssertionError):
        drawn(panels.statistics.TYNDALL_PT_sidebar_statistics)
    last_render.record(scene.name, {"stages": [{"name": "light shafts", "seconds": 0.5}]})
    assert drawn(panels.statistics.TYNDALL_PT_sidebar_statistics)[:2] == ["Light shafts", "500 ms"]


def test_the_light_that_is_edited_is_named_where_tools_work_on_it(scene: bpy.types.Scene) -> None:
    """While a light is active, it; else a choice."""
    colour = panels.colour.TYNDALL_PT_sidebar_colour
    assert drawn(colour, object=None) == ["edited_light"]
    assert drawn(colour, object=add("Lamp", bpy.data.lights.new("Lamp", "SPOT"))) == ["Lamp"]
