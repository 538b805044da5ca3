# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sees and does in Blender 3.4's window. Screenshots lie in TYNDALL_SCREENSHOTS, if that is set."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

#: What Blender prints, without an exception, when a panel names something that does not exist.
COMPLAINTS = ("rna_uiItem", "unknown operator", "property not found", "can't find")


def test_every_tab_draws_without_a_complaint(play: Callable[..., Any]) -> None:
    """Panels in a real window: an exception in one, or a property that is not there, shows in the console."""
    played = play("panels")
    assert played.facts["drawn"] == ["RENDER", "OUTPUT", "VIEW_LAYER", "WORLD", "OBJECT", "MATERIAL", "DATA", "DATA"]
    assert not [line for line in played.console.splitlines() if any(text in line for text in COMPLAINTS)]
