# SPDX-License-Identifier: GPL-3.0-or-later
"""The suns of worlds, where a sun object stands for them: their light is taken out of the image or the sky."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tyndall.environment_suns import ImageSun, NoDominantLightError, find_sun, without_sun
from tyndall.linear_colours import linear_colours
from tyndall.scene_description import Image

if TYPE_CHECKING:
    from collections.abc import Mapping

    import bpy
    from mathutils import Matrix
    from numpy.typing import NDArray

    from tyndall.scene_description import World

    from .reports import Reports
    from .worlds import ReadWorld

#: Between the object and the light in the image, before a report says so.
_MOST_APART_RAD = math.radians(2.0)


class WorldSuns:
    """Keeps the last image's: it is looked through once, however often the scene is read."""

    def __init__(self) -> None:
        self._key: tuple[str, float] | None = None
        self._found: tuple[ImageSun, Image] | NoDominantLightError

    def find(self, image: Image, threshold: float) -> tuple[ImageSun, Image]:
        """Also the image without it. Raises ``NoDominantLightError``."""
        if self._key != (image.key, threshold):
            self._key = (image.key, threshold)
            self._found = _found_in(image, threshold)
        if isinstance(self._found, NoDominantLightError):
            raise self._found
        return self._found

    def take_out(
        self, original: bpy.types.World, found: ReadWorld, light_places: Mapping[str, Matrix], reports: Reports
    ) -> ReadWorld:
        """The world without the sun that an object stands for; cameras go on seeing it.

        ``light_places``: of the objects of drawn lights by name, world from object. Where there is nothing to take, or
        no object, the world is left as it is, with a report.
        """
        settings, world = original.tyndall, found.world
        if not settings.takes_sun or world.image is None:
            return found
        culprit = f'World "{original.name}"'
        thing = settings.sun
        if thing is None or thing.name not in light_places:
            what = "it has no sun object" if thing is None else f'its sun "{thing.name}" is not drawn'
            reports.add(culprit, f"its image keeps its sun: {what}")
            return found
        if found.suns:  # of sky textures, which no image has
            sun_towards, half_angle_rad = np.array(found.suns[0].towards), found.suns[0].half_angle_rad
            without = replace(found, suns=found.suns[1:])
        else:
            try:
                sun, rest = self.find(world.image, settings.sun_threshold)
            except NoDominantLightError as reason:
                reports.add(culprit, f'image "{world.image.name}" has no sun to take out: {reason}')
                return found
            sun_towards, half_angle_rad = direction_in_world(sun, world), sun.half_angle_rad
            seen = None if world.seen_program is not None else world.image
            without = replace(found, world=replace(world, image=rest, seen_image=seen))
        towards = np.array(light_places[thing.name].to_3x3().col[2].normalized())
        apart_rad = math.acos(min(1.0, max(-1.0, float(towards @ sun_towards))))
        if apart_rad > max(_MOST_APART_RAD, half_angle_rad):
            reports.add(
                culprit,
                f'its sun "{thing.name}" stands {math.degrees(apart_rad):.0f} degrees beside its image\'s: update it',
            )
        return without


def _found_in(image: Image, threshold: float) -> tuple[ImageSun, Image] | NoDominantLightError:
    colours = linear_colours(image)
    try:
        sun = find_sun(colours, threshold)
    except NoDominantLightError as reason:
        return reason
    pixels = np.ones((*colours.shape[:2], 4), np.float32)
    pixels[..., :3] = without_sun(colours, sun)
    return sun, Image(key=f"{image.key} {threshold}", name=image.name, pixels=pixels, is_srgb=False)


def direction_in_world(sun: ImageSun, world: World) -> NDArray[np.float64]:
    """Unit vector towards a sun of the world's image, (3,)."""
    towards: NDArray[np.float64] = world.image_from_world.T @ sun.direction
    return towards / np.linalg.norm(towards)
