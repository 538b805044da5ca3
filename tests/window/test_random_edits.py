# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits at random, undo, renders and files that close amid them: no crash, no hang, and nothing is lost in silence."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

SHORT, ALL = range(4), range(200)
IN_ONE_BLENDER = 20  #: Sequences.


def play_seeds(play: Callable[..., Any], first: int, last: int, timeout_s: float) -> None:
    """A crash or a hang fails in ``play``, and so does an exception in the console."""
    played = play("random_edits", timeout_s=timeout_s, settings={"TYNDALL_EDIT_SEEDS": f"{first} {last}"})
    assert played.facts["seeds"] == [first, last]
    assert not played.facts["silent"]


def test_a_few_random_edits(play: Callable[..., Any]) -> None:
    play_seeds(play, SHORT[0], SHORT[-1], 300.0)


@pytest.mark.long
@pytest.mark.parametrize("first", ALL[::IN_ONE_BLENDER])
def test_two_hundred_random_edits(play: Callable[..., Any], first: int) -> None:
    play_seeds(play, first, first + IN_ONE_BLENDER - 1, 1200.0)
