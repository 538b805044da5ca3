# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions of a scene: what of them is sent, and what cannot be used."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import bpy
import pytest

from addon.animation_paths import curves_at
from addon.function_trees import ramp_of, set_stops
from addon.panels import transfer_functions as panels
from addon.properties import transfer_functions as properties
from addon.properties import transfer_layers
from addon.sync.transfer_functions import RAMP_SAMPLES
from support.recording_layout import drawn
from support.transfer_scene import add_layers, image, read, sent, shafts, weights
from tyndall import transfer_functions as description
from tyndall.transfer_functions import Layer, TransferFunction

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


def test_a_script_need_not_name_what_it_adds(function: bpy.types.NodeTree) -> None:
    """Layers, constraints and states without names and turns: as they were added."""
    for colour in ((1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0)):
        function.tyndall.layers.add().colour = colour
    layer = function.tyndall.layers.add()
    layer.kind = "DIFFUSION"
    for place in (0.25, 0.75):
        layer.constraints.add().position = (place, place)
    function.update_tag()
    first, second, third = sent().layers
    assert (first.colour, second.colour) == ((1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0))
    assert [constraint.position for constraint in third.constraints] == [(0.25, 0.25), (0.75, 0.75)]
    for _ in range(2):
        shafts().transfer_states.add().function = function
    shafts().transfer_state = 1.5
    assert weights() == {"Transfer Function": 1.0}
    assert len([line for line in drawn(panels.TYNDALL_PT_transfer_states) if line == "50%"]) == 2
    shafts().active_transfer_state = 1
    bpy.ops.tyndall.transfer_state_remove()
    assert len(shafts().transfer_states) == 2


def test_a_layer_that_a_script_removes_is_gone_at_once(function: bpy.types.NodeTree) -> None:
    """Although that tags nothing, and the evaluated function still has it."""
    add_layers("SOLID", "SOLID")
    bpy.context.view_layer.update()
    function.tyndall.layers.remove(0)
    assert [layer.name for layer in sent().layers] == ["Solid.001"]


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
