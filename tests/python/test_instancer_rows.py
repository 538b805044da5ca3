# SPDX-License-Identifier: GPL-3.0-or-later
"""What instancers give to instances: a row each, sent once, and part of what tells scenes apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from support.plain_scenes import placed, square, translation
from tyndall.fingerprints import fingerprint
from tyndall.instance_arrays import NO_ROW, instancer_values_of
from tyndall.moved_instances import moved_groups
from tyndall.scene_description import Instances, SceneDescription

PLAIN = placed(square(), translation(0.0, 0.0, 0.0))


def of(*values: float, count: int = 1) -> Instances:
    """An instance for each, which has it as often as that."""
    given = np.repeat(np.array(values, np.float32), 4 * count).reshape(-1, count, 4)
    places = np.repeat(PLAIN.world_from_object, len(values), axis=0)
    return replace(PLAIN, world_from_object=places, object_names=("leaf",) * len(values), instancer_values=given)


def test_each_instance_points_to_its_row() -> None:
    values, rows = instancer_values_of([of(3.0, 4.0, count=2), PLAIN, of(5.0, count=2)])
    assert values[:, 0, 0].tolist() == [3.0, 4.0, 5.0]
    assert values.shape == (3, 2, 4)
    assert rows.tolist() == [0, 1, NO_ROW, 2]
    assert values.flags.c_contiguous
    assert not any(array.size for array in instancer_values_of([PLAIN, PLAIN]))


# Seen to fail with these values left out of what is compared.
def test_another_value_is_another_scene() -> None:
    first, other = (SceneDescription(instances=(of(value, 1.0), PLAIN)) for value in (3.0, 4.0))
    again = replace(first, instances=(of(3.0, 1.0), PLAIN))
    without = replace(first, instances=(replace(first.instances[0], instancer_values=None), PLAIN))
    assert fingerprint(first) == fingerprint(again)
    assert len({fingerprint(scene) for scene in (first, other, without)}) == 3
    assert moved_groups(first, again) == [0]
    assert moved_groups(first, other) is None
    assert moved_groups(first, without) is None
