# SPDX-License-Identifier: GPL-3.0-or-later
"""A render of the light shafts alone, to be laid over another engine's picture of the same frame.

Surfaces end view rays and cast shafts, but are black and cost no light; the film shows what the air gives, and its
alpha says that the frame was rendered.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from bpy.types import Depsgraph, Scene
    from numpy.typing import NDArray

    from tyndall.renderer import Film, RenderConfig


def master_of(depsgraph: Depsgraph) -> Scene | None:
    """The evaluated scene that this one renders light shafts for; None: it renders for itself."""
    master = depsgraph.scene.original.tyndall.over_engine.master
    return None if master is None else master.evaluated_get(depsgraph)


def air_config(config: RenderConfig) -> RenderConfig:
    """The world lights the air; what the camera sees of it is the other engine's."""
    from tyndall.renderer import IndirectConfig

    return replace(config, film_transparent=True, indirect=IndirectConfig(), keeps_light_groups=False)


def marked_as_rendered(film: Film) -> Film:
    """Alpha 1 everywhere: where the compositor finds 0, it leaves the picture as it is."""
    combined = film.planes["Combined"].copy()
    combined[..., 3] = 1.0
    return replace(film, planes={**film.planes, "Combined": combined})


def nothing(width_px: int, height_px: int) -> dict[str, NDArray[np.float32]]:
    """Planes that leave the other picture as it is."""
    return {"Combined": np.zeros((height_px, width_px, 4), np.float32)}
