# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions that are kept in files, linked from others, and made by presets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from addon.animation_paths import curves_at
from addon.function_trees import ramp_of, set_stops
from addon.sync.transfer_functions import RAMP_SAMPLES
from addon.transfer_function_presets import PRESETS
from support.small_scenes import empty_scene
from support.transfer_scene import LAYERS, add_layers, keyed_states, read, sent, shafts
from tyndall import transfer_functions as description
from tyndall.native_transfer_functions import compose

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
