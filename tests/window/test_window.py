# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sees and does in Blender 3.4's window. Screenshots lie in TYNDALL_SCREENSHOTS, if that is set."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

REPOSITORY = Path(__file__).parents[2]
BLENDER = "/usr/bin/blender"

#: What Blender prints, without an exception, when a panel names something that does not exist.
COMPLAINTS = ("rna_uiItem", "unknown operator", "property not found", "can't find")

#: Without the rounded corners that Blender draws over an area.
INSIDE = slice(20, -20), slice(20, -20)


def rms(difference: np.ndarray) -> float:
    return float(np.sqrt(np.mean(difference[INSIDE] ** 2)))


def test_every_tab_draws_without_a_complaint(play: Callable[..., Any]) -> None:
    """Panels in a real window: an exception in one, or a property that is not there, shows in the console."""
    played = play("panels")
    assert played.facts["drawn"] == ["RENDER", "OUTPUT", "VIEW_LAYER", "WORLD", "OBJECT", "MATERIAL", "DATA", "DATA"]
    assert not [line for line in played.console.splitlines() if any(text in line for text in COMPLAINTS)]


def test_the_viewport_shows_the_rendered_picture(play: Callable[..., Any]) -> None:
    """On the screen, at its place and the right way up; it follows the scene, answers while it renders, and goes."""
    played = play("viewport")
    facts = played.facts
    x, y, width, height = facts["region"]
    rgba = np.load(played.folder / "picture.npy")
    assert rgba.shape == (height, width, 4)
    with Image.open(played.folder / "viewport.png") as screenshot:
        screen = np.asarray(screenshot.convert("RGB"), np.float32)
    top = facts["window_height"] - y - height
    seen = screen[top : top + height, x : x + width][::-1]  # Blender counts rows from below
    expected = np.clip(rgba[..., :3], 0.0, 1.0) * 255.0
    assert expected.std() > 10.0, "an empty picture would prove nothing"
    # Rounding and dithering take a step; the screen's filter a little more along edges. A picture that is off by a
    # single pixel is further away, whichever way it is shifted.
    assert np.quantile(np.abs(seen - expected)[INSIDE], 0.95) <= 1.0
    shifts = [np.roll(expected, by, axis) for by in (-1, 1) for axis in (0, 1)]
    assert all(rms(seen - expected) < 0.25 * rms(seen - shifted) for shifted in shifts)

    assert facts["red_over_blue"] > 3.0
    assert facts["red_over_blue of DIFFUSE_COLOR"] == pytest.approx(1.0, abs=0.2)
    assert facts["red_over_blue of COMBINED"] == facts["red_over_blue"]
    # A light changed: nothing was walked again, and no other light was asked.
    assert facts["work"]["surfaces: passes walked"] == 0
    # The window's own bound, whatever the machine does: a fraction of what it would be if it waited for the picture.
    assert facts["longest_gap_s"] < 0.25 * facts["picture_s"]
    assert facts["pictures_while_turning"] > 3
    assert facts["threads_before"] == 1
    assert facts["threads_after"] == 0


def test_the_viewport_follows_local_view(play: Callable[..., Any]) -> None:
    """The / key isolates what is selected; fog counts as every other object does, and so do lamps."""
    levels = play("local_view").facts["levels"]
    assert levels["whole"] == levels["whole again"]
    assert levels["without the fog"] == levels["fog hidden by its eye"] != levels["whole"]
    assert levels["lamp alone"] < min(levels["fog and lamp alone"], levels["without the fog"])


def test_the_viewport_looks_through_a_fisheye(play: Callable[..., Any]) -> None:
    """Its circle is as large as the lens says, also when nothing but its field of view has changed.

    Of a lens without a height the view tells, for as long as it is looked through.
    """
    facts = play("fisheye").facts
    for name, field_rad in (("fisheye", 3.0), ("narrow", 1.5)):
        radius_px = 2 * 12.0 * np.sin(field_rad / 4) * facts["width_over_sensor"]
        assert facts["shares"][name] == pytest.approx(np.pi * radius_px**2 / facts["region_px"], rel=0.03)
    assert facts["refusal"] == 'Camera "Camera": its panorama\'s least and largest latitude or longitude are equal'
    assert facts["shares"]["no camera"] > 0.9


def test_a_render_in_the_window_equals_the_headless_one(play: Callable[..., Any]) -> None:
    """F12 and ``blender -b`` give the same bits; Esc ends a render that would take hours."""
    played = play("render")
    assert played.facts["first"] == "complete"
    assert not played.facts["ended_before_escape"]
    assert played.facts["second"] == "cancel"
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(played.folder)}
    comparison = subprocess.run(
        [
            *(BLENDER, "--background", "--factory-startup", "--python-exit-code", "1"),
            *("--python", str(REPOSITORY / "tests/support/headless_comparison.py"), "--", str(played.folder)),
        ],
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert comparison.returncode == 0, comparison.stdout + comparison.stderr
    facts = json.loads((played.folder / "comparison.json").read_text())
    assert facts["contrast"] > 0.01, "an empty picture would prove nothing"
    assert facts["largest_difference"] == 0.0


def test_each_button_of_the_occluder_edits_does_what_it_says(play: Callable[..., Any]) -> None:
    """In the sidebar, by the mouse; Ctrl-Z takes the last one back."""
    played = play("occluder_edits")
    assert played.facts["lists"] == {
        "add": ["Fill Holes"],
        "duplicate": ["Fill Holes", "Fill Holes.001"],
        "up": ["Fill Holes.001", "Fill Holes"],
        "eye": ["Fill Holes.001 off", "Fill Holes"],
        "down": ["Fill Holes", "Fill Holes.001 off"],
        "solo": ["Fill Holes", "Fill Holes.001 off solo"],
        "remove": ["Fill Holes"],
        "undo": ["Fill Holes", "Fill Holes.001 off solo"],
        "redo": ["Fill Holes"],
    }
    assert not [line for line in played.console.splitlines() if any(text in line for text in COMPLAINTS)]


def test_each_button_of_the_transfer_functions_does_what_it_says(play: Callable[..., Any]) -> None:
    """In the sidebar, by the mouse; picks in the 3D view and on the render; Ctrl-Z and Ctrl-Shift-Z."""
    played = play("transfer_functions", screen_px=(800, 1000))
    copy = "Transfer Function.001: "
    assert played.facts["steps"] == {
        "choose": ["physical"],
        "undo choose": [],
        "new": ["Transfer Function: "],
        "copy": [copy],
        "preset": ["Ember: Glow"],
        "undo preset": [copy],
        "add": [f"{copy}Diffusion"],
        "duplicate": [f"{copy}Diffusion, Diffusion.001"],
        "down": [f"{copy}Diffusion.001, Diffusion"],
        "eye": [f"{copy}Diffusion.001, Diffusion off"],
        "up": [f"{copy}Diffusion off, Diffusion.001"],
        "solo": [f"{copy}Diffusion off, Diffusion.001 solo"],
        "remove": [f"{copy}Diffusion off"],
        "undo remove": [f"{copy}Diffusion off, Diffusion.001 solo"],
        "redo remove": [f"{copy}Diffusion off"],
        "paint": [f"{copy}Diffusion off, Painted"],
        "undo paint": [f"{copy}Diffusion off"],
        "constraint": [f"{copy}Diffusion off *"],
        "remove constraint": [f"{copy}Diffusion off"],
        "undo remove constraint": [f"{copy}Diffusion off *"],
        "eye again": [f"{copy}Diffusion *"],
        "pick in the view": [f"{copy}Diffusion * * *"],
        "pick on the render": [f"{copy}Diffusion * * * *"],
        "undo pick": [f"{copy}Diffusion * * *"],
        "key": [f"{copy}Diffusion * * *"],
        "key again": [f"{copy}Diffusion * * *", "Transfer Function.002: Diffusion * * *"],
        "add state": [f"{copy}Diffusion * * *", "Transfer Function.002: Diffusion * * *", "physical"],
        "remove state": [f"{copy}Diffusion * * *", "Transfer Function.002: Diffusion * * *"],
        "undo remove state": [f"{copy}Diffusion * * *", "Transfer Function.002: Diffusion * * *", "physical"],
        "redo remove state": [f"{copy}Diffusion * * *", "Transfer Function.002: Diffusion * * *"],
    }
    assert played.facts["tracked"] == ["Cube"] * 3
    assert played.facts["keys"] == [[1.0, 0.0], [50.0, 1.0]]
    assert not [line for line in played.console.splitlines() if any(text in line for text in COMPLAINTS)]


def test_strokes_are_painted_over_the_picture_and_fitted(play: Callable[..., Any]) -> None:
    """In the sidebar and an Image Editor, by the mouse; Esc stops a fit, and Ctrl-Z takes its gobo away."""
    played = play("light_map_fit", screen_px=(1000, 900))
    assert 0.1 < played.facts["painted"] < 0.6
    assert played.facts["stopped"]
    assert played.facts["steps"] == [32, 64]
    assert np.allclose(played.facts["reddest"], (1.0, 0.0, 0.0), atol=0.02)
    assert played.facts["views"] == [2, 1]
    assert played.facts["gobo"] == [True, False, True]  # without the further steps, without the fit, with it again
    assert not [line for line in played.console.splitlines() if any(text in line for text in COMPLAINTS)]


def test_the_air_is_painted_with_the_mouse(play: Callable[..., Any]) -> None:
    """In the 3D view: strokes, each a step of undo; F and its companions; the plane slides, the view still turns."""
    facts = play("paint_air", screen_px=(900, 600)).facts
    painted = {step: np.array(means) for step, means in facts["painted"].items()}
    assert facts["begun"]
    assert 0.0 < painted["erase"][0] < painted["stroke"][0] < 0.05
    assert painted["undo stroke"][0] == 0.0
    for step in ("undo erase", "redo stroke"):
        assert np.array_equal(painted[step], painted["stroke"])
    assert 0.5 < painted["smooth"][0] / painted["stroke"][0] != 1.0
    assert np.array_equal(painted["outside"], painted["smooth"])
    assert painted["amount"][1] > 0.0
    assert painted["by tool"][2] > 0.0
    assert np.array_equal(painted["reload"], painted["by tool"])

    dials = facts["brush"]
    for name in ("radius_m", "opacity", "hardness"):
        before, during, after = dials[name]
        assert before != during == after, name
    before, during, after = dials["depth"]
    assert before == after != during
    assert abs(dials["]"] - 1.25) < 1e-5
    assert facts["still painting"]

    middle, away, back, surface = facts["depths"]
    assert abs(middle - 0.5) < 1e-3
    assert abs(away - middle - 6 / 40) < 1e-3
    assert abs(away - back - 2 / 40) < 1e-3
    assert surface < middle
    assert facts["turned_rad"] > 0.1
    for end in ("Esc", "another tool", "reload"):
        assert not facts[f"painting after {end}"]


def test_the_tab_goes_from_the_medium_to_the_output(play: Callable[..., Any]) -> None:
    """Its steps in their order, and each button of those that are no lists: haze, the lamp's view, keys, presets."""
    played = play("sidebar", screen_px=(1000, 1200))
    steps = played.facts["steps"]
    assert steps["fog box"] == steps["select"] == [["Fog Box"], ["Fog Box"]]
    assert steps["depth map"] == "Lamp depth after"
    assert steps["loop wind"] != [1.0, 0.1, 0.0]
    states, wind = {"Shafts: State": [1.0]}, {"Air: Wind": [1.0]}
    holes = {"Make Holes: Turn": [1.0, 251.0]}
    assert steps["key colours"] == states
    assert steps["key wind"] == wind | states
    assert steps["loop holes"] == steps["undo remove key"] == wind | states | holes
    assert steps["remove key"] == steps["redo remove key"] == states | holes
    assert (steps["next key"], steps["previous key"]) == (251, 1)
    assert steps["save preset"] == ["render"]
    assert steps["preset"] == 32
    assert steps["copy"]["reports"] == ['Material "Gold": Glossy is drawn as Diffuse']
    assert not [line for line in played.console.splitlines() if any(text in line for text in COMPLAINTS)]


def test_the_air_is_textured_and_goes_to_a_file_and_back(play: Callable[..., Any]) -> None:
    """By the mouse: presets, a box, what is done to all of it; through Blender's file browser, twice."""
    played = play("air", screen_px=(1000, 1100))
    steps = played.facts["steps"]
    assert steps["preset"] == pytest.approx([5.0, 0.2, 0.05, 0.0])
    assert steps["save preset"] == ["air"]
    assert steps["box"] == "Painted Air"
    assert steps["fill"] == [0.25, None, None]
    assert (steps["flip"], steps["undo flip"], steps["redo flip"]) == (True, False, True)
    assert steps["resample"] == [96, 96, 96]
    assert steps["bake"][1:] == [-1.0, None], "noise and paint are one intensity, and the air adds none of its own"
    assert steps["undo bake"] == [pytest.approx(0.4375), None, None]
    assert steps["clear"] == [None, None, None]
    assert steps["to file"]
    assert steps["is shown"]
    assert steps["from file"]
    assert not [line for line in played.console.splitlines() if any(text in line for text in COMPLAINTS)]


def test_light_shafts_go_over_cycles_in_the_window(play: Callable[..., Any]) -> None:
    """By the mouse: set up, fog left to them, off and on, removed and brought back; F12, Ctrl-F12, Esc."""
    played = play("over_engine", screen_px=(1000, 900))
    both = [".Scene Light Shafts", "Scene"]
    assert played.facts["steps"] == {
        "set up": [True, both, []],
        "leave fog": [True, both, [False]],
        "off": [False, both, [True]],
        "on": [True, both, [False]],
        "remove": [False, ["Scene"], []],
        "undo": [True, both, [False]],
    }
    shafts, own = played.facts["levels"]
    assert 0.8 < shafts / own < 1.2, "both have fog"
    assert shafts != own
    assert played.facts["frames"] == 8
    assert played.facts["ends"] == ["complete", "complete", "complete", "cancel"]
    assert not [line for line in played.console.splitlines() if any(text in line for text in COMPLAINTS)]


def test_a_sun_is_made_of_the_world_s_image_by_its_button(play: Callable[..., Any]) -> None:
    """Made, undone, redone, and updated: one object all the time."""
    facts = play("world_sun", screen_px=(900, 700)).facts
    assert facts["made"] == facts["redone"] == facts["updated"] == ["Sun of World"]
    assert facts["undone"] == []
    assert facts["takes_sun"]


def test_a_mesh_becomes_voxels_in_the_window(play: Callable[..., Any]) -> None:
    """By the mouse: Esc stops it; it is undone and redone; files come in and go out, and a mesh is made.

    The view shows the voxels in their colours.
    """
    played = play("voxels", screen_px=(1000, 900))
    facts = played.facts
    with Image.open(played.folder / "voxels_made.png") as screenshot:
        shown = np.asarray(screenshot.convert("RGB"), int)
    for channel in (0, 1):
        is_hue = shown[..., channel] > 80 + np.delete(shown, channel, axis=2).max(axis=2)
        assert is_hue[300:600, 200:600].sum() > 300
    assert facts["stopped"] == facts["undone"] == []
    assert facts["made"] == facts["redone"] == ["Cube Voxels"]
    assert facts["imported"] == ["Cube Voxels", "Cube_Voxels", "Cube_Voxels.001"]
    assert facts["written"] == ["Cube_Voxels.vox", "Cube_Voxels_002.vdb"]
    assert facts["mesh"] > 10_000


def test_materials_worlds_and_lamps_have_previews(play: Callable[..., Any]) -> None:
    """As icons, which are those of Cycles but for its bounces; the artist's scene knows nothing of them."""
    played = play("previews")

    def icon(name: str, engine: str = "TYNDALL") -> np.ndarray:
        return np.load(played.folder / f"{name} by {engine}.npy")

    for name in ("plastic", "lamp"):
        ours, theirs = icon(name), icon(name, "CYCLES")
        assert ours.std() > 0.1, "an empty picture would prove nothing"
        assert np.abs(ours - theirs).mean() < 0.015
    red, green, blue, _ = icon("world")[64, 64]
    assert red < green < blue
    assert icon("half there")[..., 2].mean() > icon("half there")[..., 0].mean() > 0.05
    assert icon("rough metal")[..., 0].max() > 0.9  # the lamp in it
    assert played.facts["recorded"] is None
    assert played.facts["kept"] == 0
    assert played.facts["failed"] is None
