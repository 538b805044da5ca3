# SPDX-License-Identifier: GPL-3.0-or-later
"""Particles that instances are: told apart by what they say, and sent once each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from support.plain_scenes import placed, square, translation
from tyndall.fingerprints import fingerprint
from tyndall.instance_arrays import NO_PARTICLE, particles_of
from tyndall.moved_instances import moved_groups
from tyndall.scene_description import Instances, SceneDescription

PLAIN = placed(square(), translation(0.0, 0.0, 0.0))


def particles(*ages: float) -> NDArray[np.float32]:
    """NaN: no particle."""
    states = np.zeros((len(ages), 14), np.float32)
    states[:, 0] = np.where(np.isnan(ages), np.nan, np.arange(len(ages)))
    states[:, 2] = ages
    return states


def of(*ages: float) -> Instances:
    places = np.repeat(PLAIN.world_from_object, len(ages), axis=0)
    return replace(PLAIN, world_from_object=places, object_names=("leaf",) * len(ages), particles=particles(*ages))


def test_each_instance_points_to_its_particle() -> None:
    groups = [of(3.0, np.nan, 4.0), PLAIN, of(5.0)]
    states, indices = particles_of(groups)
    assert states[:, 2].tolist() == [3.0, 4.0, 5.0]
    assert indices.tolist() == [0, NO_PARTICLE, 1, NO_PARTICLE, 2]
    assert states.flags.c_contiguous
    assert not any(array.size for array in particles_of([PLAIN, PLAIN]))


# Seen to fail with particles left out of what is compared.
def test_an_older_particle_is_another_scene() -> None:
    young, old = (SceneDescription(instances=(of(age, np.nan), PLAIN)) for age in (3.0, 4.0))
    again = replace(young, instances=(of(3.0, np.nan), PLAIN))
    without = replace(young, instances=(replace(young.instances[0], particles=None), PLAIN))
    assert fingerprint(young) == fingerprint(again)
    assert len({fingerprint(scene) for scene in (young, old, without)}) == 3
    assert moved_groups(young, again) == [0]
    assert moved_groups(young, old) is None
    assert moved_groups(young, without) is None
