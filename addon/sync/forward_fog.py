# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the world's light comes from as many directions as fog that scatters forward needs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tyndall.scene_description import SceneDescription

    from .reports import Reports

#: Directions times (1 - |g|)^2. A ball of fog in an even world, blocks of 8 x 8 pixels: 10 are 0.7 % off, 2.6 are 6 %,
#: 0.4 are 14 %, 0.03 are 58 %.
_ENOUGH, _TOO_FEW = 10.0, 5.0
_MOST = 65536  #: As the setting allows.


def note_forward_fog(description: SceneDescription, world_samples: int, reports: Reports) -> None:
    """Say what more samples of a pixel do not mend."""
    world = description.world
    lobes = [lobe for medium in description.media for lobe in medium.lobes if any(lobe.sigma_s_per_m)]
    if world_samples == 0 or not lobes or not any(world.radiance):
        return
    asymmetry = max(abs(lobe.asymmetry_g) for lobe in lobes)
    width = (1.0 - asymmetry) ** 2
    if world_samples * width >= _TOO_FEW:
        return
    wanted = math.ceil(_ENOUGH / width)
    advice = f"{wanted:,} would do" if wanted <= _MOST else "so many cannot be had"
    fog = f"fog of an anisotropy of {asymmetry:.3g}"
    reports.add(f'World "{world.name}"', f"{world_samples} World Samples are too few for {fog}: uneven light; {advice}")
