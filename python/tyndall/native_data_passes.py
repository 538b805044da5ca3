# SPDX-License-Identifier: GPL-3.0-or-later
"""What passes tell beside light, as the native side takes it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _native
from .mattes import MATTE_NAMES

if TYPE_CHECKING:
    from .render_config import DataConfig


def build_data_passes(
    data: DataConfig,
    passes: list[str],
    aov_programs: Mapping[str, Mapping[Any, Any]],
    neighbours: tuple[Any, Any] | None,
) -> _native.DataPasses:
    """Of the passes of these names. Raises ``InvalidInput`` for a name that is none."""
    return _native.DataPasses(
        passes=passes,
        matte_ranks=data.matte_ranks,
        asset_of=dict(data.asset_of),
        material_alias=MATTE_NAMES,
        material_index=dict(data.material_index),
        mist=(data.mist_start_m, data.mist_depth_m, data.mist_exponent),
        aovs=[(name, is_colour, aov_programs.get(name, {})) for name, is_colour in data.aovs],
        neighbours=neighbours,
    )
