# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: one radiance, an equirectangular image, or a program of directions; and the medium that fills space.

A program is baked into an image, which gives the light, or one colour where it has no other; cameras see the program
itself. The suns of sky textures are lights of their own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tyndall.direction_programs import baked, baked_key
from tyndall.scene_description import Image, Medium, World

from ..shader_nodes import shader_tree
from .field_media import read_fields
from .node_graph import Socket, output_input
from .program import BLACK, WHITE, Value
from .shader_limits import followed
from .sky_suns import SkySun, sky_sun
from .value_nodes import Domain, ValueReader
from .world_nodes import WorldReader
from .world_programs import as_turned_image, image_width, linear_map
from .world_visibility import is_shown, lit_surfaces, shown_to_rays

if TYPE_CHECKING:
    import bpy

    from tyndall.scene_description import Light, Material

    from .field_media import DensityField
    from .images import ImageReader
    from .reports import Reports

_ANY_DISTANCE_M = 1e9
_KEPT_COUNT = 2  #: Of baked images: that of the last frame, and one beside it.


@dataclass(frozen=True)
class ReadWorld:
    """The world's light without the suns of its sky textures, and these."""

    world: World
    medium: Medium | None = None  #: Its index in `world` is left to the caller.
    fields: tuple[DensityField, ...] = ()  #: What else is in the world's volume, where nodes vary it.
    suns: tuple[SkySun, ...] = ()

    def sky_suns(self) -> tuple[Light, ...]:
        """As lights of the scene."""
        world = self.world
        return tuple(
            replace(
                sun.light(),
                light_group=world.light_group,
                lights_surfaces=world.lights_surfaces,
                scatters_in_media=world.scatters_in_media,
            )
            for sun in self.suns
        )


class WorldBakes:
    """Keeps the last images: a world that did not change is baked once."""

    def __init__(self) -> None:
        self._kept: dict[str, Image] = {}

    def image(self, material: Material, width: int) -> Image:
        height = max(1, width // 2)
        key = baked_key(material, width, height)
        image = self._kept.pop(key, None) or baked(material, width, height)
        self._kept[key] = image
        while len(self._kept) > _KEPT_COUNT:
            del self._kept[next(iter(self._kept))]
        return image


def occlusion_reach_m(scene: bpy.types.Scene) -> float:
    """How far Ambient Occlusion nodes look that have no distance of their own, and the pass."""
    if scene.world is None:
        return _ANY_DISTANCE_M
    return min(max(scene.world.light_settings.distance, 0.0), _ANY_DISTANCE_M)


def world_of(depsgraph: bpy.types.Depsgraph) -> bpy.types.World | None:
    """What the view layer shows of it: none without "Environment", and from 4.3 on a world of its own."""
    layer = depsgraph.view_layer_eval
    if not layer.use_sky:
        return None
    return getattr(layer, "world_override", None) or depsgraph.scene_eval.world


def read_world(
    world: bpy.types.World | None, reports: Reports, images: ImageReader, bakes: WorldBakes | None = None
) -> ReadWorld:
    """A scene without a world is black."""
    if world is None:
        return ReadWorld(World(name="no world"))
    found = _read_world(world, reports, images, bakes)
    lit = replace(found.world, lights_surfaces=lit_surfaces(world), scatters_in_media=is_shown(world, "scatter"))
    return replace(found, world=lit)


def _read_world(world: bpy.types.World, reports: Reports, images: ImageReader, bakes: WorldBakes | None) -> ReadWorld:
    tree = shader_tree(world)
    culprit = f'World "{world.name}"'
    surface, volume = (output_input(tree, name) for name in ("Surface", "Volume"))
    air: tuple[Medium | None, tuple[DensityField, ...]] = None, ()
    if volume is not None:
        air = read_fields(ValueReader(culprit, reports, images, Domain.SURFACE), volume, world.name)

    def drawn(by: WorldReader) -> Value:
        colour = BLACK if surface is None else _background(by, surface, WHITE)
        return by.program.multiply(tuple(world.color) if tree is None else colour, shown_to_rays(by, world))

    reader = WorldReader(culprit, reports, images, draws_discs=False)
    background = drawn(reader)
    material = reader.program.material(world.name, (BLACK, BLACK, background))
    if not material.program:
        return ReadWorld(World(name=world.name, radiance=material.emission), *air)
    turned = as_turned_image(reader.program, background)
    if turned is not None:
        image = World(
            name=world.name, radiance=turned.factor, image=turned.image, image_from_world=turned.image_from_world
        )
        return ReadWorld(image, *air)
    seen, has_sharp_disc = material, False
    suns: tuple[SkySun, ...] = ()
    if reader.discs:
        drawing = WorldReader(culprit, reports, images, draws_discs=True)
        seen = drawing.program.material(world.name, (BLACK, BLACK, drawn(drawing)))
        found = _suns(reader, world.name, seen, material)
        has_sharp_disc = found is None
        suns = found or ()
    width = image_width(reader.program, background, has_sharp_disc=has_sharp_disc)
    light = (bakes or WorldBakes()).image(seen if has_sharp_disc else material, width)
    if (even := _one_colour(light)) is not None:  # but for cameras: as in Cycles it has no shadow rays then
        return ReadWorld(World(name=world.name, radiance=even, seen_program=seen), *air, suns)
    return ReadWorld(World(name=world.name, radiance=WHITE, image=light, seen_program=seen), *air, suns)


def _one_colour(image: Image) -> tuple[float, float, float] | None:
    first = image.pixels[0, 0, :3]
    if not (np.isfinite(first).all() and all((row[:, :3] == first).all() for row in image.pixels)):
        return None
    red, green, blue = (float(channel) for channel in first)
    return red, green, blue


def _suns(reader: WorldReader, name: str, seen: Material, without: Material) -> tuple[SkySun, ...] | None:
    """None where a node bends the sky: its discs are part of the image then, as they are in Cycles."""
    suns: dict[tuple[float, ...], SkySun] = {}
    for index, disc in enumerate(reader.discs):
        from_world = linear_map(reader.program, disc.vector)
        if from_world is None:
            return None
        towards = np.linalg.solve(from_world, disc.towards)
        place = tuple(np.round(towards / np.linalg.norm(towards), 4))
        if place in suns:
            continue
        label = f"Sky sun of {name}" if index == 0 else f"Sky sun {index + 1} of {name}"
        sun = sky_sun(label, seen, without, towards, disc.half_angle_rad)
        if sun is not None:
            suns[place] = sun
    return tuple(suns.values())


@followed(otherwise=BLACK)
def _background(reader: ValueReader, at: Socket, weight: Value) -> Value:
    program, source = reader.program, at.source()
    if source.is_bare_shader() or weight == BLACK:
        reader.note_left_out(at)
        return BLACK
    if source.socket.type != "SHADER":
        return program.multiply(weight, reader.colour(at))
    node_type = source.node.type
    if node_type in {"BACKGROUND", "EMISSION"}:
        strength = reader.number(source.input("Strength"), 1.0)
        return program.multiply(weight, program.multiply(reader.colour(source.input("Color")), strength))
    if node_type == "ADD_SHADER":
        one, other = (_background(reader, shader, weight) for shader in source.inputs()[:2])
        return program.add(one, other)
    if node_type == "MIX_SHADER":
        share, first, second = source.inputs()[:3]
        share_of_second = program.clamp(reader.number(share))
        return program.add(
            _background(reader, first, program.multiply(weight, program.complement(share_of_second))),
            _background(reader, second, program.multiply(weight, share_of_second)),
        )
    reader.unsupported(source, "is no background: black")
    return BLACK
