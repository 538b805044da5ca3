# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions of a scene: kept, undone, keyed and sent as the artist meant them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from addon import last_render, transfer_function_preview
from addon.animation_paths import curves_at
from addon.function_trees import ramp_of, set_stops
from addon.item_lists import in_order
from addon.panels import transfer_functions as panels
from addon.properties import transfer_functions as properties
from addon.properties import transfer_layers
from addon.surface_points import anchor_at
from addon.sync.images import ImageReader
from addon.sync.reports import Reports
from addon.sync.transfer_functions import RAMP_SAMPLES, read_transfer_functions
from addon.transfer_function_presets import PRESETS
from addon.transfer_states import keys_of, shares
from support.recording_layout import drawn
from support.small_scenes import cube, empty_scene, light
from tyndall import native_transfer_functions
from tyndall import transfer_functions as description
from tyndall.native_transfer_functions import compose
from tyndall.renderer import Session
from tyndall.transfer_functions import Layer, LayerKind, TransferFunction, WeightedFunction

LAYERS = "tyndall.layers"


@pytest.fixture
def function() -> bpy.types.NodeTree:
    """A new function without layers, the only one of a scene with a cube."""
    empty_scene()
    cube()
    assert bpy.ops.tyndall.transfer_function_new() == {"FINISHED"}
    return shafts().transfer_states[0].function


def shafts() -> Any:
    return bpy.context.scene.tyndall.shafts


def add_layers(*kinds: str) -> None:
    for kind in kinds:
        assert bpy.ops.tyndall.transfer_layer_add(kind=kind) == {"FINISHED"}


def names(tree: bpy.types.NodeTree) -> list[str]:
    """From bottom to top."""
    return [layer.name for layer in in_order(tree.tyndall.layers)]


def read() -> tuple[tuple[WeightedFunction, ...], tuple[str, ...]]:
    """What a render would be given, and what it would be told."""
    reports = Reports()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    functions = read_transfer_functions(depsgraph.scene_eval, depsgraph, ImageReader(), reports)
    return functions, reports.lines()


def sent() -> TransferFunction:
    """The only one, which is all of what is shown."""
    (weighted,), lines = read()
    assert weighted.weight == 1.0
    assert lines == ()
    return weighted.function


def weights() -> dict[str, float]:
    return {weighted.function.name: weighted.weight for weighted in read()[0]}


def image(name: str, side_px: int = 2) -> bpy.types.Image:
    return bpy.data.images.new(name, side_px, side_px)


# What is sent


def test_the_words_are_those_of_the_description() -> None:
    """Each choice of the artist has a meaning, and each meaning can be chosen."""
    for items, meaning in (
        (properties.AXES, description.Axis),
        (properties.USES, description.Use),
        (transfer_layers.KINDS, description.LayerKind),
        (transfer_layers.BLEND_MODES, description.BlendMode),
        (transfer_layers.SHAPES, description.GradientShape),
    ):
        assert {item[0]: item[-1] for item in items} == {member.name: member.value for member in meaning}


def test_defaults_are_those_of_the_description(function: bpy.types.NodeTree) -> None:
    """Both sides agree about a new function and a new layer; but it multiplies, so that it works in any scene."""
    add_layers("SOLID")
    made = sent()
    expected = TransferFunction(name="Transfer Function")
    assert (made.name, made.x, made.y, made.strength) == (expected.name, expected.x, expected.y, expected.strength)
    assert made.use == description.Use.MULTIPLY
    (layer,) = made.layers
    for field in fields(Layer):
        if field.name != "name":
            assert getattr(layer, field.name) == getattr(Layer(name=""), field.name), field.name


def test_all_settings_are_sent(function: bpy.types.NodeTree) -> None:
    """Each field of a function, an axis and a layer."""
    settings = function.tyndall
    settings.use, settings.strength = "REPLACE", 2.5
    settings.x.axis = "HEIGHT"
    settings.x.fits_range, settings.x.low_m, settings.x.high_m = False, -3.0, 7.0
    settings.y.axis, settings.y.mask = "MASK", image("Mask")
    add_layers("GRADIENT")
    layer = settings.layers[0]
    layer.blend_mode, layer.opacity, layer.shape = "DODGE", 0.5, "RADIAL"
    layer.start, layer.end, layer.smoothness = (0.25, 0.75), (1.5, -0.5), 0.125
    layer.colour = (0.1, 0.2, 0.3, 0.4)
    made = sent()
    assert (made.use.name, made.strength) == ("REPLACE", 2.5)
    assert (made.x.axis.name, made.x.range_m, made.x.mask) == ("HEIGHT", (-3.0, 7.0), None)
    assert (made.y.axis.name, made.y.range_m, made.y.mask.name) == ("MASK", (0.0, 0.0), "Mask")
    (sent_layer,) = made.layers
    assert (sent_layer.name, sent_layer.kind.name, sent_layer.mode.name) == ("Gradient", "GRADIENT", "DODGE")
    assert (sent_layer.opacity, sent_layer.shape.name) == (0.5, "RADIAL")
    assert (sent_layer.start, sent_layer.end, sent_layer.smoothness) == ((0.25, 0.75), (1.5, -0.5), 0.125)
    assert sent_layer.colour == pytest.approx((0.1, 0.2, 0.3, 0.4))


def test_a_fitted_axis_has_no_range(function: bpy.types.NodeTree) -> None:
    """Nor has one that is not in metres, whatever its switch says."""
    add_layers("SOLID")
    assert sent().y.range_m == (0.0, 0.0)
    function.tyndall.y.fits_range = False
    assert sent().y.range_m == (0.0, 100.0)
    function.tyndall.y.axis = "LIGHT_ANGLE"
    assert sent().y.range_m == (0.0, 0.0)
    axis = function.tyndall.x
    axis.full_visibility = 0.25
    assert sent().x.full_visibility == 0.0
    axis.fits_range = False
    assert sent().x.full_visibility == 0.25
    axis.axis = "DEPTH"
    assert sent().x.full_visibility == 0.0


def test_a_ramp_is_what_blender_draws(function: bpy.types.NodeTree) -> None:
    """Both ends included, scene-linear, with alpha, however it interpolates."""
    add_layers("GRADIENT")
    ramp = ramp_of(function.tyndall.layers[0])
    set_stops(ramp, [(0.25, (1.0, 0.0, 0.0, 1.0)), (0.75, (0.0, 4.0, 0.0, 0.5))])
    for interpolation in ("LINEAR", "EASE", "CONSTANT"):
        ramp.interpolation = interpolation
        ((first, *middle, last),) = [layer.ramp for layer in sent().layers]
        assert len(middle) == RAMP_SAMPLES - 2
        assert first == (1.0, 0.0, 0.0, 1.0)
        assert last == (0.0, 4.0, 0.0, 0.5)
        assert middle[126] == pytest.approx(tuple(ramp.evaluate(127 / 255)))


def test_layers_are_sent_from_bottom_to_top_without_those_that_are_off(function: bpy.types.NodeTree) -> None:
    """The list shows the topmost first: up is up."""
    add_layers("SOLID", "GRADIENT", "SOLID")
    assert [layer.name for layer in sent().layers] == ["Solid", "Gradient", "Solid.001"]
    bpy.ops.tyndall.transfer_layer_move(direction="DOWN")
    assert [layer.name for layer in sent().layers] == ["Solid", "Solid.001", "Gradient"]
    rows = [line for line in drawn(panels.TYNDALL_PT_transfer_layers) if line.startswith("row: ")]
    assert rows == ["row: Gradient", "row: Solid.001", "row: Solid"]
    function.tyndall.layers["Solid"].is_enabled = False
    assert [layer.name for layer in sent().layers] == ["Solid.001", "Gradient"]
    bpy.ops.tyndall.transfer_layer_solo(index=0)
    assert [layer.name for layer in sent().layers] == ["Solid"]


def test_a_function_that_changes_nothing_is_not_sent(function: bpy.types.NodeTree) -> None:
    """No layers, all off, mix 0, switched off: the render takes no notice, and costs nothing."""
    assert read() == ((), ())
    add_layers("SOLID")
    assert weights() == {"Transfer Function": 1.0}
    function.tyndall.layers[0].is_enabled = False
    assert read() == ((), ())
    function.tyndall.layers[0].is_enabled = True
    shafts().transfer_mix = 0.0
    assert read() == ((), ())
    shafts().transfer_mix = 1.0
    shafts().use_transfer_functions = False
    assert read() == ((), ())


@pytest.mark.parametrize("is_driven", [False, True])
def test_animated_values_are_those_of_the_frame(function: bpy.types.NodeTree, is_driven: bool) -> None:  # noqa: FBT001
    """Of a layer, of its constraint, of a ramp's stop, of the scene's mix."""
    add_layers("DIFFUSION", "GRADIENT")
    function.tyndall.active_layer = 0
    bpy.ops.tyndall.transfer_constraint_add()
    constraint, gradient = function.tyndall.layers[0].constraints[0], function.tyndall.layers[1]
    stop = ramp_of(gradient).elements[1]
    animated = (
        (gradient, "opacity", -1),
        (constraint, "position", 0),
        (stop, "color", 2),
        (shafts(), "transfer_mix", -1),
    )
    for group, name, index in animated:
        if is_driven:
            group.driver_add(name, index).driver.expression = "frame / 10"
            continue
        for frame in (1, 10):
            setattr(group, name, frame / 10) if index < 0 else getattr(group, name).__setitem__(index, frame / 10)
            owner, path = group.id_data, group.path_from_id(name)
            owner.keyframe_insert(path, index=index, frame=frame)
        for curve in curves_at(group.id_data, group.path_from_id(name)):
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
    for frame in (1, 4, 10):
        bpy.context.scene.frame_set(frame)
        ((weighted,), _lines) = read()
        lower, upper = weighted.function.layers
        assert upper.opacity == pytest.approx(frame / 10)
        assert lower.constraints[0].position == pytest.approx((frame / 10, 0.5))
        assert upper.ramp[-1][2] == pytest.approx(frame / 10)
        assert weighted.weight == pytest.approx(frame / 10)


# States over time


def test_a_state_shares_itself_between_two_neighbours() -> None:
    """2.4 is 60 % of the third and 40 % of the fourth; beyond the ends there is nothing else to show."""
    assert [(place, pytest.approx(share)) for place, share in shares(2.4, 5)] == [(2, 0.6), (3, 0.4)]
    assert shares(3.0, 5) == [(3, 1.0)]
    assert shares(9.0, 5) == [(4, 1.0)]
    assert shares(-1.0, 1) == [(0, 1.0)]
    assert shares(0.5, 0) == []


def keyed_states(*frames: int) -> list[str]:
    """Keys a state at each frame; names of the functions in their order."""
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        assert bpy.ops.tyndall.transfer_state_key() == {"FINISHED"}
    return [state.function.name for state in in_order(shafts().transfer_states)]


def at(frame: float) -> dict[str, float]:
    bpy.context.scene.frame_set(int(frame), subframe=frame % 1)
    return {name: pytest.approx(weight, abs=1e-6) for name, weight in weights().items()}


def make_linear() -> None:
    for key in keys_of(bpy.context.scene):
        key.interpolation = "LINEAR"


def test_keys_give_the_keyed_functions_exactly(function: bpy.types.NodeTree) -> None:
    """At its frame a state is alone, with the layers that it was given; between two, both have a share."""
    add_layers("SOLID")
    first, second = keyed_states(1, 11)
    copied = bpy.data.node_groups[second]
    copied.tyndall.layers[0].colour = (1.0, 0.0, 0.0, 1.0)
    make_linear()
    assert at(1) == {first: 1.0}
    assert at(11) == {second: 1.0}
    assert sent().layers[0].colour == (1.0, 0.0, 0.0, 1.0)
    assert at(4) == {first: 0.7, second: 0.3}
    assert at(3.5) == {first: 0.75, second: 0.25}
    shafts().transfer_mix = 0.5
    assert at(4) == {first: 0.35, second: 0.15}


def test_a_state_that_is_keyed_between_two_goes_between_them(function: bpy.types.NodeTree) -> None:
    """The keys behind it move up: on the way from one key to the next nothing else shows."""
    add_layers("SOLID")
    first, last = keyed_states(10, 30)
    order = keyed_states(20, 1)
    earliest, middle = order[0], order[2]
    assert order == [earliest, first, middle, last]
    assert [tuple(key.co) for key in keys_of(bpy.context.scene)] == [(1, 0), (10, 1), (20, 2), (30, 3)]
    make_linear()
    assert at(15) == {first: 0.5, middle: 0.5}
    assert at(25) == {middle: 0.5, last: 0.5}
    # A copy of what was shown there, with keys of its own.
    assert len(bpy.data.node_groups[middle].tyndall.layers) == 1


def test_keying_a_keyed_frame_again_shows_its_state(function: bpy.types.NodeTree) -> None:
    """Nothing is added; the state of that key is the one to edit."""
    add_layers("SOLID")
    keyed_states(1, 11)
    assert len(keyed_states(1)) == 2
    assert shafts().active_transfer_state == 0


def test_a_removed_state_takes_its_keys_along(function: bpy.types.NodeTree) -> None:
    """The others show what they showed. Its function stays in the file."""
    add_layers("SOLID")
    first, second, third = keyed_states(1, 11, 21)
    shafts().active_transfer_state = 1
    bpy.ops.tyndall.transfer_state_remove()
    assert [tuple(key.co) for key in keys_of(bpy.context.scene)] == [(1, 0), (21, 1)]
    assert at(21) == {third: 1.0}
    assert at(1) == {first: 1.0}
    assert second in bpy.data.node_groups
    for _ in range(2):
        bpy.ops.tyndall.transfer_state_remove()
    assert read() == ((), ())
    assert keys_of(bpy.context.scene) == []
    assert shafts().transfer_state == 0.0


def test_states_have_layers_of_their_own_number(function: bpy.types.NodeTree) -> None:
    """They are mixed as pictures: nothing of them needs to match."""
    add_layers("SOLID")
    first, second = keyed_states(1, 11)
    add_layers("GRADIENT", "DIFFUSION", "SOLID")
    bpy.ops.tyndall.transfer_layer_move(direction="DOWN")
    make_linear()
    bpy.context.scene.frame_set(6)
    functions, _lines = read()
    assert {one.function.name: len(one.function.layers) for one in functions} == {first: 1, second: 3}


def test_a_state_without_a_function_is_the_physical_picture(function: bpy.types.NodeTree) -> None:
    """What its share leaves is physical: shafts go over from plain to coloured."""
    add_layers("SOLID")
    bpy.ops.tyndall.transfer_state_add()
    shafts().transfer_state = 0.75
    assert weights() == {"Transfer Function": 0.25}
    assert "Physical" in drawn(panels.TYNDALL_PT_transfer_states)


def test_one_function_in_two_states_is_sent_once(function: bpy.types.NodeTree) -> None:
    """Going from it to itself shows it whole."""
    add_layers("SOLID")
    bpy.ops.tyndall.transfer_state_add()
    shafts().transfer_states[1].function = function
    shafts().transfer_state = 0.25
    assert weights() == {"Transfer Function": pytest.approx(1.0)}


def test_a_copied_function_has_keys_of_its_own(function: bpy.types.NodeTree) -> None:
    """A copy of a datablock shares its action: keys of one would be keys of both."""
    add_layers("SOLID")
    layer = function.tyndall.layers[0]
    layer.keyframe_insert("opacity", frame=1)
    keyed_states(1, 11)
    copied = shafts().transfer_states[1].function
    copied.tyndall.layers[0].opacity = 0.25
    copied.tyndall.layers[0].keyframe_insert("opacity", frame=1)
    assert curves_at(function, f"{LAYERS}[0].opacity")[0].evaluate(1) == 1.0
    assert curves_at(copied, f"{LAYERS}[0].opacity")[0].evaluate(1) == 0.25
    assert sent().layers[0].opacity == pytest.approx(0.25)


# Constraints that follow a surface


def track(function: bpy.types.NodeTree, thing: bpy.types.Object, local_point: tuple[float, float, float]) -> Any:
    """A constraint on the object's surface, as picking makes it."""
    add_layers("DIFFUSION")
    bpy.ops.tyndall.transfer_constraint_add()
    constraint = function.tyndall.layers[0].constraints[0]
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    is_found, point, _normal, polygon = evaluated.closest_point_on_mesh(local_point)
    assert is_found
    anchor = anchor_at(evaluated, polygon, point)
    constraint.is_tracked, constraint.tracked_object = True, thing
    constraint.triangle_index, constraint.triangle_count = anchor.triangle_index, anchor.triangle_count
    constraint.triangle_weights, constraint.local_point = anchor.weights, anchor.local_point
    return constraint


def followed() -> tuple[float, float, float] | None:
    return sent().layers[0].constraints[0].point


POINT = (0.3, -0.6, 1.0)


def test_a_constraint_follows_its_object(function: bpy.types.NodeTree) -> None:
    """Moved, turned and scaled: in world space."""
    box = bpy.data.objects["Cube"]
    track(function, box, POINT)
    assert followed() == pytest.approx(POINT, abs=1e-6)
    box.location, box.rotation_euler, box.scale = (1, 2, 3), (0.4, 0.5, 0.6), (1, 2, 0.5)
    bpy.context.view_layer.update()
    assert followed() == pytest.approx(
        tuple(box.matrix_world @ bpy.context.scene.cursor.location.__class__(POINT)), abs=1e-5
    )


def test_a_constraint_follows_a_deformed_surface(function: bpy.types.NodeTree) -> None:
    """A shape key pulls the top of the cube up by one metre on one side: the point rises by its share."""
    box = bpy.data.objects["Cube"]
    box.shape_key_add(name="Basis")
    key = box.shape_key_add(name="Tilt")
    for corner in key.data:
        if corner.co.z > 0.0 and corner.co.x > 0.0:
            corner.co.z += 1.0
    key.value = 0.0
    bpy.context.view_layer.update()
    track(function, box, POINT)
    key.value = 1.0
    bpy.context.view_layer.update()
    assert followed() == pytest.approx((0.3, -0.6, 1.0 + 0.65), abs=1e-5)
    key.value = 0.0
    key.keyframe_insert("value", frame=1)
    key.value = 1.0
    key.keyframe_insert("value", frame=11)
    bpy.context.scene.frame_set(11)
    assert followed() == pytest.approx((0.3, -0.6, 1.65), abs=1e-5)


def test_a_subdivided_surface_holds_its_constraint_by_place(function: bpy.types.NodeTree) -> None:
    """The triangle is another one now: one line says so."""
    box = bpy.data.objects["Cube"]
    track(function, box, POINT)
    modifier = box.modifiers.new("Subdivision", "SUBSURF")
    modifier.subdivision_type, modifier.levels, modifier.show_viewport = "SIMPLE", 1, True
    box.location.x = 5.0
    bpy.context.view_layer.update()
    ((weighted,), lines) = read()
    assert weighted.function.layers[0].constraints[0].point == pytest.approx((5.3, -0.6, 1.0), abs=1e-5)
    culprit = 'Transfer function "Transfer Function", layer "Diffusion", constraint "Colour"'
    assert lines == (f'{culprit}: object "Cube" has other triangles than when it was picked: followed by its place',)


def test_a_tracked_constraint_survives_save_and_reload(function: bpy.types.NodeTree, tmp_path: Path) -> None:
    track(function, bpy.data.objects["Cube"], POINT)
    path = str(tmp_path / "tracked.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.data.objects["Cube"].location.z = 2.0
    bpy.context.view_layer.update()
    assert followed() == pytest.approx((0.3, -0.6, 3.0), abs=1e-6)


def _delete(thing: bpy.types.Object) -> None:
    bpy.data.objects.remove(thing)


def _unlink(thing: bpy.types.Object) -> None:
    bpy.context.scene.collection.objects.unlink(thing)


def _empty_mesh(thing: bpy.types.Object) -> None:
    thing.data.clear_geometry()


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (_delete, "its object is not set, or deleted"),
        (_unlink, 'its object "Cube" is not in the scene'),
        (_empty_mesh, 'its object "Cube" has no surface any more'),
    ],
)
def test_a_constraint_whose_surface_is_gone_stays_where_it_was_picked(
    function: bpy.types.NodeTree, damage: Callable[[bpy.types.Object], None], reason: str
) -> None:
    """One line names function, layer, constraint and culprit; the layer is used."""
    constraint = track(function, bpy.data.objects["Cube"], POINT)
    constraint.position = (0.25, 0.75)
    damage(bpy.data.objects["Cube"])
    bpy.context.view_layer.update()
    ((weighted,), lines) = read()
    (made,) = weighted.function.layers[0].constraints
    assert (made.position, made.point) == ((0.25, 0.75), None)
    culprit = 'Transfer function "Transfer Function", layer "Diffusion", constraint "Colour"'
    assert lines == (f"{culprit}: stays where it was picked: {reason}",)


# What cannot be used


def _no_image(layer: Any) -> None:
    layer.kind = "IMAGE"


def _missing_image(layer: Any) -> None:
    layer.kind, layer.image = "IMAGE", image("Lost")
    layer.image.source, layer.image.filepath = "FILE", "//nowhere.png"


def _deleted_image(layer: Any) -> None:
    layer.kind, layer.image = "IMAGE", image("Gone")
    bpy.data.images.remove(bpy.data.images["Gone"])


def _no_constraints(layer: Any) -> None:
    layer.kind = "DIFFUSION"


def _renamed_ramp(layer: Any) -> None:
    layer.kind = "GRADIENT"
    layer.id_data.nodes[layer.ramp_node].name = "Other"


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (_no_image, "it has no image"),
        (_missing_image, 'its picture, image "Lost", is missing or has no pixels (//nowhere.png)'),
        (_deleted_image, "it has no image"),
        (_no_constraints, "it has no constraints"),
        (_renamed_ramp, 'its ramp, node "Solid", was removed or renamed'),
    ],
)
def test_a_layer_that_cannot_be_used_is_left_out_by_name(
    function: bpy.types.NodeTree, damage: Callable[[Any], None], reason: str
) -> None:
    """One line names function, layer and culprit; the other layers are used."""
    add_layers("SOLID", "SOLID")
    damage(function.tyndall.layers[0])
    ((weighted,), lines) = read()
    assert [layer.name for layer in weighted.function.layers] == ["Solid.001"]
    assert lines == (f'Transfer function "Transfer Function", layer "Solid": left out: {reason}',)


def test_a_function_whose_axis_has_no_mask_is_left_out(function: bpy.types.NodeTree) -> None:
    """Its colours would be anywhere. The others stay."""
    add_layers("SOLID")
    function.tyndall.x.axis = "MASK"
    assert read() == ((), ('Transfer function "Transfer Function": left out: its x axis has no mask image',))


def test_an_empty_range_is_fitted_and_said(function: bpy.types.NodeTree) -> None:
    add_layers("SOLID")
    axis = function.tyndall.y
    axis.fits_range, axis.low_m, axis.high_m = False, 5.0, 5.0
    ((weighted,), lines) = read()
    assert weighted.function.y.range_m == (0.0, 0.0)
    assert lines == (
        'Transfer function "Transfer Function": the range of its y axis is empty: fitted to the frame instead',
    )


def test_a_deleted_function_leaves_the_physical_picture(function: bpy.types.NodeTree) -> None:
    add_layers("SOLID")
    bpy.data.node_groups.remove(function)
    assert read() == ((), ())
    assert drawn(panels.TYNDALL_PT_transfer_functions)


# Keys and drivers


def keyed(tree: bpy.types.NodeTree) -> None:
    """Three layers; the second and third have a key on their opacity, the third a driver on its smoothness."""
    add_layers("SOLID", "GRADIENT", "DIFFUSION")
    for index in (1, 2):
        layer = tree.tyndall.layers[index]
        layer.opacity = index / 4
        layer.keyframe_insert("opacity", frame=1)
    tree.tyndall.layers[2].driver_add("smoothness").driver.expression = "frame / 2"
    bpy.ops.tyndall.transfer_constraint_add()


def values_by_name() -> dict[str, tuple[float, float]]:
    bpy.context.scene.frame_set(1)
    return {layer.name: (layer.opacity, layer.smoothness) for layer in sent().layers}


def test_keys_and_drivers_stay_with_their_layers(function: bpy.types.NodeTree) -> None:
    """After moves, and after the removal of a layer before them."""
    keyed(function)
    at_first = values_by_name()
    assert at_first["Gradient"][0] == 0.25
    assert at_first["Diffusion"] == pytest.approx((0.5, 0.5))
    bpy.ops.tyndall.transfer_layer_move(direction="DOWN")
    assert values_by_name() == at_first
    function.tyndall.active_layer = 0
    bpy.ops.tyndall.transfer_layer_remove()
    del at_first["Solid"]
    assert values_by_name() == at_first
    function.tyndall.active_layer = 0
    bpy.ops.tyndall.transfer_layer_remove()
    assert values_by_name() == {"Diffusion": pytest.approx((0.5, 0.5))}
    assert not function.nodes, "the gradient's ramp went with it"


def test_keys_stay_with_their_constraints(function: bpy.types.NodeTree) -> None:
    """Collections in collections: only those of this layer count down."""
    add_layers("DIFFUSION", "DIFFUSION")
    for layer in (0, 1):
        function.tyndall.active_layer = layer
        for _ in range(2):
            bpy.ops.tyndall.transfer_constraint_add()
        constraint = function.tyndall.layers[layer].constraints[1]
        constraint.position = (0.25, 0.25 + layer / 2)
        constraint.keyframe_insert("position", index=1, frame=1)
    function.tyndall.active_layer, function.tyndall.layers[1].active_constraint = 1, 0
    bpy.ops.tyndall.transfer_constraint_remove()
    assert len(curves_at(function, f"{LAYERS}[0].constraints[1].position")) == 1
    assert len(curves_at(function, f"{LAYERS}[1].constraints[0].position")) == 1
    bpy.context.scene.frame_set(1)
    assert [layer.constraints[-1].position for layer in sent().layers] == [(0.25, 0.25), (0.25, 0.75)]


# What is kept


def test_functions_survive_save_and_reload(function: bpy.types.NodeTree, tmp_path: Path) -> None:
    """Layers, ramps, constraints, axes, keys; a function that no scene uses, too."""
    add_layers("GRADIENT", "DIFFUSION")
    bpy.ops.tyndall.transfer_constraint_add()
    set_stops(ramp_of(function.tyndall.layers[0]), [(0.0, (1, 0, 0, 1)), (1.0, (0, 0, 1, 1))])
    keyed_states(1, 11)
    before = read()
    bpy.ops.tyndall.transfer_state_remove()
    path = str(tmp_path / "functions.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert len(bpy.data.node_groups) == 2
    shafts().transfer_states[0].function = bpy.data.node_groups["Transfer Function.001"]
    bpy.context.scene.frame_set(1)
    assert read() == before


def _load(path: Path, *, link: bool) -> bpy.types.NodeTree:
    with bpy.data.libraries.load(str(path), link=link) as (_there, here):
        here.node_groups = ["Transfer Function"]
    return here.node_groups[0]


@pytest.fixture
def library(function: bpy.types.NodeTree, tmp_path: Path) -> Path:
    """A file with a function of two layers; an empty scene is open."""
    add_layers("SOLID", "GRADIENT")
    function.tyndall.layers[1].keyframe_insert("opacity", frame=1)
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    empty_scene()
    bpy.ops.tyndall.transfer_state_add()
    return path


def test_an_appended_function_brings_its_layers_ramps_and_keys(library: Path) -> None:
    shafts().transfer_states[0].function = _load(library, link=False)
    assert [(layer.name, len(layer.ramp)) for layer in sent().layers] == [("Solid", 0), ("Gradient", RAMP_SAMPLES)]
    assert len(curves_at(shafts().transfer_states[0].function, f"{LAYERS}[1].opacity")) == 1


def test_a_linked_function_is_shared_and_its_override_is_changed(library: Path, tmp_path: Path) -> None:
    """A value and an added layer survive; inherited layers cannot be removed."""
    linked = _load(library, link=True)
    shafts().transfer_states[0].function = linked
    assert [layer.name for layer in sent().layers] == ["Solid", "Gradient"]
    assert not bpy.ops.tyndall.transfer_layer_add.poll()
    override = linked.override_create(remap_local_usages=True)
    shafts().transfer_states[0].function = override
    override.tyndall.layers[0].colour = (0.0, 1.0, 0.0, 1.0)
    override.tyndall.active_layer = 1
    add_layers("DIFFUSION")
    bpy.ops.tyndall.transfer_constraint_add()
    path = str(tmp_path / "override.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    tree = shafts().transfer_states[0].function
    assert tree.override_library is not None
    assert [layer.name for layer in sent().layers] == ["Solid", "Gradient", "Diffusion"]
    assert sent().layers[0].colour == (0.0, 1.0, 0.0, 1.0)
    tree.tyndall.active_layer = 0
    with pytest.raises(RuntimeError, match='"Solid" comes from the library'):
        bpy.ops.tyndall.transfer_layer_remove()
    tree.tyndall.active_layer = 2
    assert bpy.ops.tyndall.transfer_layer_remove() == {"FINISHED"}


# The lists


def test_names_are_unique_within_their_list(function: bpy.types.NodeTree) -> None:
    """Library overrides find an item by its name; so does the artist."""
    add_layers("SOLID", "SOLID", "DIFFUSION")
    function.tyndall.layers[1].name = "Solid"
    assert names(function) == ["Solid", "Solid.001", "Diffusion"]
    function.tyndall.layers[1].name = ""
    assert names(function)[1] == "Layer"
    for _ in range(2):
        bpy.ops.tyndall.transfer_constraint_add()
    assert [constraint.name for constraint in function.tyndall.layers[2].constraints] == ["Colour", "Colour.001"]


def test_a_duplicate_has_its_own_ramp_and_constraints(function: bpy.types.NodeTree) -> None:
    """All settings but the name; what is done to it is not done to the original."""
    add_layers("GRADIENT")
    ramp = ramp_of(function.tyndall.layers[0])
    set_stops(ramp, [(0.0, (1, 0, 0, 1)), (0.5, (0, 1, 0, 0.5)), (1.0, (0, 0, 1, 1))])
    ramp.interpolation = "CONSTANT"
    bpy.ops.tyndall.transfer_layer_duplicate()
    original, copied = sent().layers
    assert copied.ramp == original.ramp
    ramp_of(function.tyndall.layers[1]).elements[0].color = (0, 0, 0, 1)
    original, copied = sent().layers
    assert copied.ramp[0] != original.ramp[0]

    add_layers("DIFFUSION")
    bpy.ops.tyndall.transfer_constraint_add()
    function.tyndall.layers[2].constraints[0].position = (0.125, 0.875)
    bpy.ops.tyndall.transfer_layer_duplicate()
    assert [layer.constraints[0].position for layer in sent().layers[2:]] == [(0.125, 0.875)] * 2
    assert function.tyndall.layers[3].constraints[0].name == "Colour"


def test_operators_ask_for_what_they_need(function: bpy.types.NodeTree) -> None:
    """A function, a layer, a diffusion layer, a constraint."""
    assert bpy.ops.tyndall.transfer_layer_add.poll()
    assert not bpy.ops.tyndall.transfer_layer_remove.poll()
    add_layers("SOLID")
    assert not bpy.ops.tyndall.transfer_constraint_add.poll()
    add_layers("DIFFUSION")
    assert bpy.ops.tyndall.transfer_constraint_add.poll()
    assert not bpy.ops.tyndall.transfer_constraint_remove.poll()
    shafts().transfer_states[0].function = None
    assert not bpy.ops.tyndall.transfer_layer_add.poll()
    assert bpy.ops.tyndall.transfer_state_remove() == {"FINISHED"}
    assert not bpy.ops.tyndall.transfer_state_key.poll()


OPERATORS: dict[str, Callable[[], set[str]]] = {
    "new": bpy.ops.tyndall.transfer_function_new,
    "preset": lambda: bpy.ops.tyndall.transfer_function_preset(preset="EMBER"),
    "layer add": lambda: bpy.ops.tyndall.transfer_layer_add(kind="GRADIENT"),
    "layer remove": bpy.ops.tyndall.transfer_layer_remove,
    "layer duplicate": bpy.ops.tyndall.transfer_layer_duplicate,
    "layer move": lambda: bpy.ops.tyndall.transfer_layer_move(direction="DOWN"),
    "layer solo": bpy.ops.tyndall.transfer_layer_solo,
    "constraint add": bpy.ops.tyndall.transfer_constraint_add,
    "constraint remove": bpy.ops.tyndall.transfer_constraint_remove,
    "state add": bpy.ops.tyndall.transfer_state_add,
    "state remove": bpy.ops.tyndall.transfer_state_remove,
    "state key": bpy.ops.tyndall.transfer_state_key,
}


def state() -> list[Any]:
    """All that an operator may change."""
    found: list[Any] = [(one.order, one.function and one.function.name) for one in shafts().transfer_states]
    found += [tuple(key.co) for key in keys_of(bpy.context.scene)]
    for tree in bpy.data.node_groups:
        found += [tree.name, sorted(tree.nodes.keys())]
        for layer in tree.tyndall.layers:
            found += [layer.name, layer.order, layer.is_solo, layer.constraints.keys()]
            found.append(len(curves_at(tree, layer.path_from_id("opacity"))))
    return found


@pytest.mark.parametrize("operator", OPERATORS)
def test_every_operator_is_undone_and_redone(function: bpy.types.NodeTree, operator: str) -> None:
    """Lists, ramps and keys as they were."""
    keyed(function)
    bpy.context.preferences.edit.use_global_undo = True
    before = state()
    bpy.ops.ed.undo_push(message="before")
    assert OPERATORS[operator]() == {"FINISHED"}
    after = state()
    bpy.ops.ed.undo_push(message=operator)
    assert after != before
    bpy.ops.ed.undo()
    assert state() == before
    bpy.ops.ed.redo()
    assert state() == after


# What is shown


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("SOLID", {"colour"}),
        ("GRADIENT", {"color_ramp", "shape", "start", "end"}),
        ("DIFFUSION", {"smoothness", "colour", "position", "is_tracked"}),
        ("IMAGE", {"image"}),
    ],
)
def test_only_settings_that_the_layer_reads_are_shown(
    function: bpy.types.NodeTree, kind: str, settings: set[str]
) -> None:
    add_layers(kind)
    if kind == "DIFFUSION":
        bpy.ops.tyndall.transfer_constraint_add()
    shown = set(drawn(panels.TYNDALL_PT_transfer_layers))
    all_settings = {"colour", "color_ramp", "shape", "start", "end", "smoothness", "position", "is_tracked", "image"}
    assert shown & all_settings == settings
    assert {"kind", "blend_mode", "opacity"} <= shown
    assert set(drawn(panels.TYNDALL_PT_sidebar_transfer_layers)) == shown


def test_a_scene_without_functions_says_how_to_begin(function: bpy.types.NodeTree) -> None:
    bpy.ops.tyndall.transfer_state_remove()
    shown = drawn(panels.TYNDALL_PT_sidebar_transfer_functions)
    assert "New from Preset" in shown
    assert not panels.TYNDALL_PT_transfer_layers.poll(bpy.context)


def test_only_transfer_functions_are_offered(function: bpy.types.NodeTree) -> None:
    """Not the node groups of shaders."""
    group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    offered = [tree for tree in (function, group) if properties.is_transfer_function(shafts().transfer_states[0], tree)]
    assert offered == [function]


# The small picture


@pytest.fixture
def composed(monkeypatch: pytest.MonkeyPatch) -> list[TransferFunction]:
    """Every function that a picture is made of, in turn."""
    seen: list[TransferFunction] = []

    def spy(made: TransferFunction, size: int) -> np.ndarray:
        seen.append(made)
        return compose(made, size)

    monkeypatch.setattr(native_transfer_functions, "compose", spy)
    return seen


def shown_pixels(tree: bpy.types.NodeTree) -> np.ndarray:
    bpy.context.view_layer.update()
    transfer_function_preview.picture_of(tree, bpy.context.view_layer.depsgraph)
    shown = transfer_function_preview._previews._shown[tree.name_full]  # noqa: SLF001
    return np.array(shown.picture.image_pixels_float).reshape(128, 128, 4)


def test_the_small_picture_shows_the_function(function: bpy.types.NodeTree) -> None:
    """As a screen shows it: sRGB, from left to right along X; a checkerboard where it is transparent."""
    add_layers("GRADIENT")
    set_stops(ramp_of(function.tyndall.layers[0]), [(0.0, (0, 0, 0, 1)), (1.0, (0.5, 1, 1, 1))])
    shown = shown_pixels(function)
    assert shown[:, 0] == pytest.approx(np.tile([0, 0, 0, 1], (128, 1)), abs=0.06)
    assert shown[:, -1] == pytest.approx(np.tile([0.735, 1, 1, 1], (128, 1)), abs=0.01)
    function.tyndall.layers[0].opacity = 0.0
    shown = shown_pixels(function)
    assert len(np.unique(shown[..., :3])) == 2
    assert (shown[..., 3] == 1.0).all()


def test_the_small_picture_is_made_when_the_function_changes(
    function: bpy.types.NodeTree, composed: list[TransferFunction]
) -> None:
    """Not when a panel draws, nor when anything else changes."""
    add_layers("GRADIENT", "IMAGE")
    function.tyndall.layers[1].image = image("Picture")
    shown_pixels(function)
    shown_pixels(function)
    bpy.data.objects["Cube"].location.x += 1.0
    shown_pixels(function)
    function.tyndall.layers[0].opacity = 1.0
    shown_pixels(function)
    assert len(composed) == 1
    function.tyndall.layers[0].opacity = 0.5
    shown_pixels(function)
    ramp_of(function.tyndall.layers[0]).elements[0].color = (1, 0, 0, 1)
    shown_pixels(function)
    assert [made.layers[0].opacity for made in composed] == [1.0, 0.5, 0.5]
    assert composed[2].layers[0].ramp[0] == (1.0, 0.0, 0.0, 1.0)


def test_the_small_picture_follows_keys(function: bpy.types.NodeTree, composed: list[TransferFunction]) -> None:
    add_layers("SOLID")
    layer = function.tyndall.layers[0]
    for frame in (1, 2):
        layer.opacity = frame / 2
        layer.keyframe_insert("opacity", frame=frame)
    for frame in (1, 2):
        bpy.context.scene.frame_set(frame)
        shown_pixels(function)
    assert [made.layers[0].opacity for made in composed] == [0.5, 1.0]


# Presets


@pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.identifier)
def test_each_preset_makes_a_picture(function: bpy.types.NodeTree, preset: Any) -> None:
    """It composes without a report, is no single grey, and one that replaces says how bright it is."""
    assert bpy.ops.tyndall.transfer_function_preset(preset=preset.identifier) == {"FINISHED"}
    made = sent()
    picture = compose(made, 64)
    assert np.isfinite(picture).all()
    assert picture[..., :3].std(axis=(0, 1)).max() > 0.01
    if made.use == description.Use.REPLACE:
        assert f"strength {made.strength:g}" in preset.description


def test_there_are_a_dozen_presets_for_any_scene() -> None:
    """Those take their brightness from the scene; names and descriptions tell all of them apart."""
    assert sum(preset.use != "REPLACE" for preset in PRESETS) >= 12
    for texts in zip(*((preset.identifier, preset.name, preset.description) for preset in PRESETS), strict=True):
        assert len(set(texts)) == len(PRESETS)


# What a change costs


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


def test_a_render_is_asked_for_what_the_scene_shows(function: bpy.types.NodeTree, monkeypatch: Any) -> None:
    """The final render's settings hold the functions, and its reports what was left out of them."""
    add_layers("SOLID", "IMAGE")
    seen: list[Any] = []
    render = Session.render

    def spy(session: Session, camera: Any, config: Any, *arguments: Any) -> Any:
        seen.append(config)
        return render(session, camera, config, *arguments)

    monkeypatch.setattr(Session, "render", spy)
    lamp = light("SPOT", (0, 0, 5))
    shafts().transfer_light = lamp
    bpy.ops.render.render()
    bpy.data.objects.remove(lamp)
    bpy.ops.render.render()
    config, without_lamp = seen
    assert (config.reference_light, without_lamp.reference_light) == ("Spot", "")
    assert [one.function.layers[0].kind for one in config.transfer_functions] == [LayerKind.SOLID]
    lines = last_render.statistics_of(bpy.context.scene.name)["reports"]
    assert any('layer "Image": left out: it has no image' in line for line in lines)
