# SPDX-License-Identifier: GPL-3.0-or-later
"""Make a sun object of the brightest light in the world's image, or bring the one that was made in step with it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
from bpy.types import Context, Light, Object, Operator, World
from mathutils import Matrix, Vector

from ..availability import why_no_render
from .fog_box import select_only

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: From the world's origin; a sun shines from infinity, the object only has to be at hand.
_DISTANCE_M = 10.0


def world_of(context: Context) -> World | None:
    """That of the Properties editor, or else the scene's."""
    return getattr(context, "world", None) or context.scene.world


class TYNDALL_OT_sun_from_world(Operator):
    """Make a sun object of the brightest light in the world's image: its direction, size, colour and strength.

    The image gives the rest of the light then. If there is such an object, it is brought in step with the image
    """

    bl_idname = "tyndall.sun_from_world"
    bl_label = "Make Sun from Image"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        world = world_of(context)
        reason = why_no_render()
        if world is None:
            reason = "The scene has no world"
        elif world.library is not None:
            reason = "The world is linked: make it local, or a library override"
        if reason is not None:
            cls.poll_message_set(reason)
        return reason is None

    def execute(self, context: Context) -> set[str]:
        # All panels register where the native core does not load; only what computes needs it.
        import numpy as np

        from tyndall.environment_suns import NoDominantLightError

        from ..sync.images import ImageReader
        from ..sync.reports import Reports
        from ..sync.world_suns import WorldSuns, direction_in_world
        from ..sync.worlds import read_world

        world = world_of(context)
        reports = Reports()
        evaluated = world.evaluated_get(context.evaluated_depsgraph_get())
        read_all = read_world(evaluated, reports, ImageReader())
        read = read_all.world
        if read.image is None:
            why = "; ".join(reports.lines()) or f'World "{world.name}" has no environment image'
            self.report({"ERROR"}, why)
            return {"CANCELLED"}
        if read_all.suns:  # of a sky texture
            sun = read_all.suns[0]
            irradiance, half_angle_rad, towards = np.array(sun.irradiance), sun.half_angle_rad, Vector(sun.towards)
        else:
            try:
                found, _ = WorldSuns().find(read.image, world.tyndall.sun_threshold)
            except NoDominantLightError as reason:
                self.report({"ERROR"}, f'Image "{read.image.name}" has no dominant light: {reason}')
                return {"CANCELLED"}
            irradiance = (found.irradiance * read.radiance).clip(min=0.0)
            half_angle_rad, towards = found.half_angle_rad, Vector(direction_in_world(found, read))
        if not irradiance.max() > 0.0:
            self.report({"ERROR"}, f'World "{world.name}" gives no light')
            return {"CANCELLED"}
        thing = world.tyndall.sun
        if thing is not None and (thing.library is not None or thing.data.library is not None):
            self.report({"ERROR"}, f'Its sun "{thing.name}" is linked: make it local, or choose another')
            return {"CANCELLED"}
        if thing is None or thing.name not in context.view_layer.objects:
            thing = _new_sun(context, world)
        _turn(thing, towards)
        _shine(thing.data, irradiance, half_angle_rad)
        select_only(context, thing)
        height = math.degrees(math.asin(max(-1.0, min(1.0, towards.z))))
        width = math.degrees(2 * half_angle_rad)
        self.report(
            {"INFO"}, f'"{thing.name}": {height:.1f} degrees high, {width:.2g} wide, {irradiance.max():.3g} W/m²'
        )
        return {"FINISHED"}


def _new_sun(context: Context, world: World) -> Object:
    thing = bpy.data.objects.new(f"Sun of {world.name}", bpy.data.lights.new(f"Sun of {world.name}", "SUN"))
    context.collection.objects.link(thing)
    world.tyndall.sun = thing
    world.tyndall.takes_sun = True
    return thing


def _turn(thing: Object, towards: Vector) -> None:
    """A sun shines along its -Z. One that stands at the origin is put where its arrow comes from."""
    where = thing.matrix_world.translation.copy()
    if where.length == 0.0:
        where = _DISTANCE_M * towards
    turn = towards.to_track_quat("Z", "Y").to_matrix().to_4x4()
    thing.matrix_world = Matrix.Translation(where) @ turn


def _shine(light: Light, irradiance: NDArray[np.float64], half_angle_rad: float) -> None:
    """``irradiance``: (3,), W/m^2 on a plane that faces it."""
    from ..sync.lights import irradiance_share

    light.angle = 2 * half_angle_rad
    light.energy = float(irradiance.max()) / irradiance_share(light.angle / 2)
    light.color = irradiance / irradiance.max()
    if hasattr(light, "exposure"):  # from 4.5 on
        light.exposure, light.use_temperature, light.normalize = 0.0, False, True


CLASSES = (TYNDALL_OT_sun_from_world,)
