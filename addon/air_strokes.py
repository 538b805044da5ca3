# SPDX-License-Identifier: GPL-3.0-or-later
"""A stroke of the scene's brush in a painted box, from its first place to what is kept of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .painted_air import read_volume, why_not_editable, world_from_unit, write_volume

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from bpy.types import Object
    from numpy.typing import NDArray

    from tyndall.air_brush import AirBrush

    from .properties.air_brush import TyndallAirBrush


def brush_of(settings: TyndallAirBrush, mode: str = "") -> AirBrush:
    """``mode``: another than the settings'."""
    from tyndall.air_brush import AirBrush

    return AirBrush(
        mode=mode or settings.mode,
        value=getattr(settings, settings.volume.lower()),
        radius_m=settings.radius_m,
        depth_m=settings.radius_m * settings.depth,
        hardness=settings.hardness,
        opacity=settings.opacity,
        pressure_sizes=settings.pressure_sizes,
        pressure_fades=settings.pressure_fades,
    )


class BoxStroke:
    """In one volume of a box."""

    def __init__(self, box: Object, settings: TyndallAirBrush, normal: Sequence[float], mode: str = "") -> None:
        """``normal``: of the plane that is painted on. Raises ValueError, which says why nothing can be painted."""
        import numpy as np

        from tyndall.air_brush import Stroke
        from tyndall.air_tiles import VOLUME_KINDS

        if (reason := why_not_editable(box)) is not None:
            raise ValueError(reason)
        self.name: str = settings.volume.lower()
        self._stroke = Stroke(
            volume_to_paint(box, self.name),
            VOLUME_KINDS[self.name],
            np.array(world_from_unit(box)),
            np.array(normal, np.float64),
            brush_of(settings, mode),
        )

    def move_to(self, place_m: Sequence[float], pressure: float = 1.0) -> bool:
        """Go on to a place in the world. False: nothing of the way is in the box."""
        import numpy as np

        return self._stroke.move_to(np.array(place_m, np.float64), pressure)

    @property
    def values(self) -> NDArray[np.float32]:
        """The volume, with the stroke so far."""
        return self._stroke.values

    def keep(self, box: Object) -> bool:
        """Write it into the box. False: it has met nothing, and nothing is written."""
        if not self._stroke.touched:
            return False
        write_volume(box, self.name, self._stroke.values, self._stroke.touched)
        return True


def volume_to_paint(box: Object, name: str) -> NDArray[np.float32]:
    """What is painted in it, or an even one."""
    import numpy as np

    from tyndall.air_tiles import VOLUME_KINDS

    values = read_volume(box, name)
    if values is not None:
        return values
    return np.full(tuple(reversed(box.tyndall.painted_air.resolution)), VOLUME_KINDS[name].neutral, np.float32)
