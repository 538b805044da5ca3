# SPDX-License-Identifier: GPL-3.0-or-later
"""A large scene must not hold up the window: reading stops, lets the window draw, and goes on from there."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import pytest

from addon.engine import reading_slices
from addon.engine.reading_slices import SLICE_S, ReadingSlices, SliceOver
from addon.sync import displaced_meshes, strands
from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.hair_scenes import furry
from support.small_scenes import add, displace, material, mesh, node
from tyndall.displacement import displaced
from tyndall.scene_description import SceneDescription


@dataclass
class Clock:
    now: float = 0.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(reading_slices, "time", made)
    return made


@pytest.mark.parametrize("part_s", [0.02, 1.0])
@pytest.mark.parametrize("again_s", [0.01, 0.1, 1.0])
def test_most_of_the_time_goes_to_what_is_new(clock: Clock, again_s: float, part_s: float) -> None:
    """Whatever each slice takes until it is where the last one was; no slice is much longer than it has to be."""
    part_count, read = round(20.0 / part_s), 0
    slices, longest_s = ReadingSlices(lambda: read), 0.0
    while read < part_count:
        started = clock.now
        slices.begin()
        try:
            clock.now += again_s
            slices.poll()
            while read < part_count:
                slices.poll()
                clock.now += part_s
                read += 1
        except SliceOver:
            longest_s = max(longest_s, clock.now - started)
    assert slices.end() == pytest.approx(clock.now)
    news_s = part_count * part_s
    assert longest_s < SLICE_S + 3.0 * again_s + 1.1 * part_s
    assert clock.now < (1.6 if part_s < again_s else 2.0) * news_s + 9.0 * again_s


def slice_count(clock: Clock, slices: ReadingSlices, part_count: int) -> int:
    """Of a change that brings nothing new in so many parts of 0.1 s."""
    for count in range(1, 20):
        slices.begin()
        try:
            for _ in range(part_count):
                clock.now += 0.1
                slices.poll()
        except SliceOver:
            continue
        slices.end()
        return count
    raise AssertionError("it never ends")


def test_changes_of_a_large_scene_are_not_read_in_vain_first(clock: Clock) -> None:
    """Once it is known how long that takes; of a small one after it, it is known anew."""
    slices = ReadingSlices(lambda: 0)
    counts = [slice_count(clock, slices, part_count) for part_count in (8, 8, 10, 1, 8)]
    assert counts[1:4] == [1, 1, 1]
    assert counts[0] == counts[4] > 2


def read_in_slices(reader: SceneReader, amid: Callable[[], bpy.types.Depsgraph]) -> tuple[SceneDescription, list[int]]:
    """A slice ends as soon as something is new; and how often each polled. ``amid``: called before each."""
    poll_counts: list[int] = []
    while len(poll_counts) < 100:
        known = reader.read_count
        poll_counts.append(0)

        def poll(known: int = known) -> None:
            poll_counts[-1] += 1
            if reader.read_count > known:
                raise SliceOver

        with contextlib.suppress(SliceOver):
            return reader.read(amid(), Reports(), poll, is_live=True), poll_counts
    raise AssertionError("it never ends")


@pytest.mark.parametrize("is_moved", [False, True])
def test_hair_is_read_in_slices(scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch, *, is_moved: bool) -> None:
    """No hair twice, within a particle system or after it; with what one read at once would have, also if it moves."""
    monkeypatch.setattr(strands, "_POLL_EVERY", 40)  # of 600
    patches = [furry(scene, "RIBBONS") for _ in range(2)]
    for patch in patches:
        patch.particle_systems[0].settings.count = 600
    depsgraph = bpy.context.evaluated_depsgraph_get()
    reader, calls = SceneReader(), itertools.count()

    def amid() -> bpy.types.Depsgraph:
        if next(calls) == 2 and is_moved:
            patches[0].location.x += 1.0
            depsgraph.update()
            reader.note_updates(depsgraph)
        return depsgraph

    description, poll_counts = read_in_slices(reader, amid)
    found = description.strand_objects
    expected = SceneReader().read(depsgraph, Reports(), lambda: None).strand_objects
    assert len(found) == 2
    for one, other in zip(found, expected, strict=True):
        assert np.array_equal(one.strands.points, other.strands.points)
        assert len(one.strands.first_points) == 600
    if not is_moved:  # hairs that are read again would be polled between again
        assert max(poll_counts[: 2 * 600 // 40]) == poll_counts[0] + 1


def test_meshes_are_displaced_in_slices(scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each mesh once, in a slice of its own, moved by its height of 1."""
    calls: list[str] = []

    def counted(shown: object, *rest: Any) -> object:
        calls.append(shown.name)
        return displaced(shown, *rest)

    monkeypatch.setattr(displaced_meshes, "displaced", counted)
    moved = material("Moved", lambda new, _: new("ShaderNodeBsdfDiffuse").outputs[0])

    def up(new: Callable[[str], bpy.types.Node], _: object) -> bpy.types.NodeSocket:
        return node(new, "ShaderNodeDisplacement", Height=1.0, Midlevel=0.0, Scale=1.0).outputs[0]

    displace(moved, up, "DISPLACEMENT")
    names = ["One", "Two", "Three"]
    for size, name in enumerate(names, 1):
        add(name, mesh(name, [(0, 0, 0), (size, 0, 0), (0, 1, 0)], [(0, 1, 2)], moved))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    description, poll_counts = read_in_slices(SceneReader(), lambda: depsgraph)
    assert sorted(calls) == sorted(names)
    assert len(poll_counts) > 2 * len(names)
    heights = [group.mesh.positions[:, 2] for group in description.instances if group.mesh.name in names]
    assert len(heights) == len(names)
    assert np.allclose(heights, 1.0)
