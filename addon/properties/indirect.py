# SPDX-License-Identifier: GPL-3.0-or-later
"""``scene.tyndall.indirect``: what surfaces see of the world and of one another."""

from bpy.props import BoolProperty, FloatProperty, IntProperty
from bpy.types import PropertyGroup

from .tagging import OVERRIDABLE, tag


class TyndallIndirectSettings(PropertyGroup):
    has_ambient_occlusion: BoolProperty(
        name="Ambient Occlusion",
        description="The world lights surfaces as if nothing stood farther away than the distance: rooms get its "
        "light, and corners and creases stay dark. Off: walls keep all of the world's light out, as they do in nature. "
        "Costs nothing",
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
    ambient_distance_m: FloatProperty(
        name="Distance",
        description="What stands farther away than this hides nothing of the world, nor in the pass Ambient Occlusion, "
        "which without the option above looks as far as the world says (as in Cycles). 0: any distance",
        min=0.0,
        max=1e9,
        soft_max=100.0,
        default=2.0,
        subtype="DISTANCE",
        update=tag,
        override=OVERRIDABLE,
    )
    ambient_samples: IntProperty(
        name="Pass Samples",
        description="Rays of the pass Ambient Occlusion per render sample. The picture itself has as many as its noise "
        "asks for",
        min=1,
        max=1024,
        soft_max=64,
        default=4,
        update=tag,
        override=OVERRIDABLE,
    )
    has_bounce: BoolProperty(
        name="Color Bleeding",
        description="Surfaces catch the light that lamps and world throw on other surfaces, and what these emit: one "
        "bounce, as Cycles with one, by rough gloss, too. With Ambient Occlusion, of what stands within its distance. "
        "Two to ten times the time of a picture without air",
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
    bounce_samples: IntProperty(
        name="Rays",
        description="Rays that gather light per render sample. 0: as many as the noise that they would leave is worth; "
        "the noise threshold does the rest",
        min=0,
        max=1024,
        soft_max=64,
        default=0,
        update=tag,
        override=OVERRIDABLE,
    )
    has_mirrors: BoolProperty(
        name="Mirrors",
        description="Polished surfaces (Glossy, Metallic and Principled shaders) mirror the scene, the lit air and the "
        "world. Off: they show lamps and the world alone, as do rougher ones. Mirrors throw no light",
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
    mirror_depth: IntProperty(
        name="Depth",
        description="Mirrors that are seen in mirrors. The next one shows the world and what glows alone",
        min=1,
        max=64,
        soft_max=8,
        default=2,
        update=tag,
        override=OVERRIDABLE,
    )
    mirror_roughness: FloatProperty(
        name="Roughness Up To",
        description="Shaders up to this roughness mirror, and bend what is seen through them, sharply; rougher ones "
        "are drawn as without the option, and reported",
        min=0.0,
        max=1.0,
        default=0.1,
        update=tag,
        override=OVERRIDABLE,
    )
    has_refraction: BoolProperty(
        name="Refraction",
        description="What cameras and mirrors see through glass and water (Glass, Refraction and Principled shaders) "
        "is bent, these mirror by Fresnel's equations, and lamps with a size show in mirrors and glass. Off: it is "
        "seen straight through them. The light of lamps passes straight either way, and light shafts are seen behind "
        "panes, but not behind other glass",
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
    refraction_depth: IntProperty(
        name="Refraction Depth",
        description="Surfaces that bend what is seen through them, one after another: two for a pane or a ball, four "
        "for a filled glass. The next one shows the world and what glows alone. What glass mirrors, within it too, "
        "counts among the mirrors",
        min=1,
        max=64,
        soft_max=24,
        default=12,
        update=tag,
        override=OVERRIDABLE,
    )
