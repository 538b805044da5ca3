# SPDX-License-Identifier: GPL-3.0-or-later
"""What buttons do, called as a script calls them."""

from __future__ import annotations

import ast
from pathlib import Path

import bpy
import pytest
from mathutils import Vector

from addon import last_render, operators
from addon.panels.presets import TYNDALL_PT_render_presets, shipped_presets

SESSIONS = Path(__file__).parents[1] / "window" / "sessions"
#: No session clicks them, because:
NOT_CLICKED = {
    "tyndall.paint_air_stroke": "a stroke by a script: the mouse paints through tyndall.paint_air",
    "tyndall.denoising_set_up": "grey in the window's Blender, Debian's, which has no OpenImageDenoise",
    "tyndall.denoising_remove": "the same",
}


def clicked_in_window() -> set[str]:
    """What the window's sessions promise to run by the mouse; each of them fails where its promise is not kept."""
    promises = [
        ast.literal_eval(statement.value)
        for session in SESSIONS.glob("*.py")
        for statement in ast.parse(session.read_text()).body
        if isinstance(statement, ast.Assign) and [ast.unparse(target) for target in statement.targets] == ["CLICKS"]
    ]
    return {name for promise in promises for name in promise}


def test_every_operator_is_clicked_in_blenders_window() -> None:
    """A button that nobody has seen and pressed is not finished. Nor is a promise kept about one that is gone."""
    ours = {cls.bl_idname for cls in operators.CLASSES if issubclass(cls, bpy.types.Operator)}
    assert clicked_in_window() == ours - set(NOT_CLICKED)


def bounds_m(box: bpy.types.Object) -> tuple[Vector, Vector]:
    bpy.context.view_layer.update()
    corners = [box.matrix_world @ Vector(corner) for corner in box.bound_box]
    return Vector(map(min, zip(*corners, strict=True))), Vector(map(max, zip(*corners, strict=True)))


def holds(box: bpy.types.Object, point: Vector) -> bool:
    lowest, highest = bounds_m(box)
    return all(low < value < high for low, value, high in zip(lowest, point, highest, strict=True))


def medium_of(box: bpy.types.Object) -> bpy.types.Node:
    output = box.active_material.node_tree.get_output_node("CYCLES")
    assert not output.inputs["Surface"].is_linked
    return output.inputs["Volume"].links[0].from_node


def test_fog_box_encloses_scene_camera_and_lights(scene: bpy.types.Scene) -> None:
    """One click: a closed, outward mesh with a medium and no surface, selected, drawn as wires."""
    assert bpy.ops.tyndall.add_fog_box() == {"FINISHED"}
    box = bpy.context.object
    assert box.select_get()
    assert box.display_type == "WIRE"
    for name in ("Camera", "Light", "Cube"):
        assert holds(box, bpy.data.objects[name].matrix_world.translation)
    centre = sum((vertex.co for vertex in box.data.vertices), Vector())
    assert centre.length < 1e-5
    for polygon in box.data.polygons:
        assert polygon.normal.dot(polygon.center) > 0


def test_fog_box_dims_its_diagonal_by_the_optical_depth(scene: bpy.types.Scene) -> None:
    """The density follows from the size of the scene: a hall and a valley get haze alike."""
    for scale in (0.01, 1.0, 1000.0):
        bpy.data.objects["Cube"].scale = (scale, scale, scale)
        bpy.ops.tyndall.add_fog_box(optical_depth=0.7, with_camera_and_lights=False)
        box = bpy.context.object
        lowest, highest = bounds_m(box)
        density_per_m = medium_of(box).inputs["Density"].default_value
        assert density_per_m * (highest - lowest).length == pytest.approx(0.7, rel=1e-4)
        bpy.data.objects.remove(box)


def test_a_second_fog_box_does_not_enclose_the_first(scene: bpy.types.Scene) -> None:
    """Or each click would make a larger box."""
    bpy.ops.tyndall.add_fog_box()
    first = bounds_m(bpy.context.object)
    bpy.ops.tyndall.add_fog_box()
    assert bounds_m(bpy.context.object) == first


def test_fog_box_of_an_empty_scene(scene: bpy.types.Scene) -> None:
    """Nothing to enclose: ten metres around the origin."""
    for shown in list(bpy.data.objects):
        bpy.data.objects.remove(shown)
    bpy.ops.tyndall.add_fog_box()
    assert bounds_m(bpy.context.object) == (Vector((-5, -5, -5)), Vector((5, 5, 5)))


def test_fog_box_ignores_what_is_infinite(scene: bpy.types.Scene) -> None:
    """A damaged mesh must not make a box without end."""
    bpy.data.objects["Cube"].location.x = float("inf")
    bpy.ops.tyndall.add_fog_box()
    lowest, highest = bounds_m(bpy.context.object)
    assert (highest - lowest).length < 100


def test_fog_box_takes_over_the_worlds_medium(scene: bpy.types.Scene) -> None:
    """The same shader with the same values, now with bounds; the world keeps its light and loses its medium."""
    tree = scene.world.node_tree
    source = tree.nodes.new("ShaderNodeVolumeScatter")
    source.inputs["Density"].default_value = 0.123
    source.inputs["Anisotropy"].default_value = -0.4
    output = tree.get_output_node("CYCLES")
    tree.links.new(source.outputs[0], output.inputs["Volume"])
    bpy.ops.tyndall.add_fog_box(replaces_world_medium=True)
    medium = medium_of(bpy.context.object)
    assert medium.bl_idname == "ShaderNodeVolumeScatter"
    assert medium.inputs["Density"].default_value == pytest.approx(0.123)
    assert medium.inputs["Anisotropy"].default_value == pytest.approx(-0.4)
    assert not output.inputs["Volume"].is_linked
    assert output.inputs["Surface"].is_linked


def test_a_mixed_medium_of_the_world_is_refused_by_name(scene: bpy.types.Scene) -> None:
    """What cannot be moved whole is not moved in part."""
    tree = scene.world.node_tree
    source = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(source.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    before = len(bpy.data.objects)
    with pytest.raises(RuntimeError, match="Add Shader"):
        bpy.ops.tyndall.add_fog_box(replaces_world_medium=True)
    assert len(bpy.data.objects) == before


def test_a_medium_of_the_world_that_nodes_feed_is_refused(scene: bpy.types.Scene) -> None:
    """A box would have the values behind the links."""
    tree = scene.world.node_tree
    source, noise = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs[0], source.inputs["Density"])
    tree.links.new(source.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    before = len(bpy.data.objects)
    with pytest.raises(RuntimeError, match="Nodes feed the world's medium"):
        bpy.ops.tyndall.add_fog_box(replaces_world_medium=True)
    assert len(bpy.data.objects) == before
    assert source.outputs[0].is_linked


def test_fog_box_can_be_undone(scene: bpy.types.Scene) -> None:
    """Undo works headless, too, once there is a step to go back to."""
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.tyndall.add_fog_box()
    bpy.ops.ed.undo_push(message="fog box")
    assert "Fog Box" in bpy.data.objects
    bpy.ops.ed.undo()
    assert "Fog Box" not in bpy.data.objects


def test_copying_statistics_needs_a_render(scene: bpy.types.Scene) -> None:
    """The button is grey before, and says why."""
    assert not bpy.ops.tyndall.copy_reports.poll()
    last_render.record(scene.name, {"stages": [], "skipped": [], "counts": {}, "reports": ["one"]})
    assert bpy.ops.tyndall.copy_reports.poll()
    assert bpy.ops.tyndall.copy_reports() == {"FINISHED"}


@pytest.mark.parametrize("preset", shipped_presets(TYNDALL_PT_render_presets), ids=lambda preset: preset.stem)
def test_shipped_presets_apply(scene: bpy.types.Scene, preset: Path) -> None:
    """Draft costs less than the defaults, Production more."""
    samples_before = scene.tyndall.pixel_samples
    bpy.ops.tyndall.preset_apply(filepath=str(preset))
    assert (scene.tyndall.pixel_samples > samples_before) == (preset.stem == "Production")


def test_own_presets_are_saved(scene: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the artist saves comes back as it was."""
    monkeypatch.setattr(bpy.utils, "user_resource", lambda *_args, path="", **_options: _made(tmp_path / path))
    monkeypatch.setattr(bpy.utils, "preset_find", lambda *_args, **_options: None)
    scene.tyndall.shafts.light_samples = 77
    bpy.ops.tyndall.render_preset_add(name="mine")
    scene.tyndall.shafts.light_samples = 1
    saved = next(tmp_path.rglob("mine.py"))
    bpy.ops.tyndall.preset_apply(filepath=str(saved))
    assert scene.tyndall.shafts.light_samples == 77


def _made(folder: Path) -> str:
    folder.mkdir(parents=True, exist_ok=True)
    return str(folder)
