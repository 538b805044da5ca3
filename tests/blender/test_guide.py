# SPDX-License-Identifier: GPL-3.0-or-later
"""The guide to light shafts knows every control of the tab, and shows no picture that nothing renders."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import bpy
import pytest

REPOSITORY = Path(__file__).parents[2]
GUIDE = re.sub(r"\s+", " ", (REPOSITORY / "docs/light-shafts.md").read_text())
#: By the class of a group, what no panel names: what lists keep, and what a panel is about as a whole.
NOT_NAMED = {
    "TyndallHeterogeneity": {"painted"},
    "TyndallLightShaftSettings": {"use_transfer_functions", "transfer_states", "active_transfer_state"},
    "TyndallOccluderEdit": {"order", "is_enabled", "is_solo", "kind", "noise", "target_object", "target_collection"},
    "TyndallLightSettings": {"active_occluder_edit", "light_map_fit"},
    "TyndallLightMapFit": {"views", "active_view"},
}
#: What panels call them, where that is shorter than their names.
LABELS = {
    "gobo_size_m": "Width",
    "gobo_offset_m": "Offset",
    "gobo_extension": "Extension",
    "gobo_strength": "Strength",
}


def groups() -> dict[str, bpy.types.PropertyGroup]:
    scene, light = bpy.context.scene, bpy.data.lights["Light"]
    box = bpy.data.objects.new("Box", None)
    edit = light.tyndall.occluder_edits.add()
    return {
        type(group).__name__: group
        for group in (
            scene.tyndall.heterogeneity,
            scene.tyndall.air_brush,
            scene.tyndall.shafts,
            box.tyndall.painted_air,
            edit,
            edit.noise,
            light.tyndall,
            light.tyndall.light_map_fit,
            bpy.context.view_layer.tyndall,
        )
    }


def is_named(name: str) -> bool:
    """In bold: by itself, or in a list of names."""
    return any(re.search(rf"\b{re.escape(name)}\b", bold) for bold in re.findall(r"\*\*(.+?)\*\*", GUIDE))


def test_the_guide_names_every_control(scene: bpy.types.Scene) -> None:
    """Of the medium, the edits, the colours, the air and the brush: an artist who meets one finds what it does."""
    for kind, group in groups().items():
        labels = {
            name: LABELS.get(name, rna.name)
            for name, rna in group.bl_rna.properties.items()
            if not rna.is_hidden and name not in {"rna_type", "name"} | NOT_NAMED.get(kind, set())
        }
        assert {name: label for name, label in labels.items() if not is_named(label)} == {}, kind


@pytest.mark.parametrize("shown", sorted(set(re.findall(r"\(pictures/([\w.]+)\)", GUIDE))))
def test_every_picture_of_the_guide_is_there(shown: str) -> None:
    """Light enough for a page of dozens, and no picture lies about that nothing shows."""
    path = REPOSITORY / "docs/pictures" / shown
    assert path.is_file()
    assert path.stat().st_size < 150_000


def test_the_guides_script_renders_every_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that was made by hand would go stale; one of a control that the guide does not show is left over."""
    monkeypatch.syspath_prepend(str(REPOSITORY / "examples"))
    script = importlib.import_module("guide_pictures")
    shown = set(re.findall(r"\(pictures/(\w+)\.jpg\)", GUIDE))
    assert shown <= {script.EDGES, *(picture.name for picture in script.PICTURES)}
    assert {control.name for control in script.CONTROLS} <= shown
