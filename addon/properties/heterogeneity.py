# SPDX-License-Identifier: GPL-3.0-or-later
"""``scene.tyndall.heterogeneity``: the texture of the air, by which light shafts are multiplied."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty
from bpy.types import Object, PropertyGroup

from ..painted_air import is_box
from .tagging import OVERRIDABLE, tag

#: Of a scene's wind and of its noise's scale, for keys.
WIND_PATH = "tyndall.heterogeneity.wind_m_per_s"
SCALE_PATH = "tyndall.heterogeneity.scale_m"

WEIGHTINGS = (
    (
        "LIT_PARTS",
        "Lit Parts",
        "What stands in the light shows, as it scatters there: wisps lie within the shafts. The physical choice",
        0,
    ),
    (
        "WHOLE_RAY",
        "Whole Ray",
        (
            "What lies anywhere along the view shows, in light or in shade: a calmer, flatter pattern that does not "
            "change where shafts end"
        ),
        1,
    ),
)
UPSAMPLINGS = (
    ("1", "Full", "Every pixel looks for itself", 1),
    ("2", "2 x 2", "Four pixels share a look at the air: a quarter of the time", 2),
    ("4", "4 x 4", "Sixteen pixels share one: soft mist hardly changes, fine grain does", 4),
    ("8", "8 x 8", "For broad drifts of mist", 8),
    ("16", "16 x 16", "The fastest; only the broadest forms are left", 16),
)


def may_be_painted(_settings: PropertyGroup, thing: Object) -> bool:
    return is_box(thing)


class TyndallHeterogeneity(PropertyGroup):
    is_enabled: BoolProperty(
        name="Texture the Air",
        description="Mist, smoke or dust structure the light shafts, as if the air were not the same everywhere. Off: "
        "it is, and costs nothing",
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
    amount: FloatProperty(
        name="Amount",
        description="How much texture there is: 0 is even air, 1 is all noise. The brightness of the shafts as a whole "
        "stays the same",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=1.0,
        update=tag,
        override=OVERRIDABLE,
    )
    intensity: FloatProperty(
        name="Intensity",
        description="Brightness of the shafts: 0 takes them away, 1 leaves them as they are, 2 doubles them. To tone "
        "them down in one place only, paint the air",
        min=0.0,
        max=1000.0,
        soft_max=4.0,
        default=1.0,
        step=5,
        update=tag,
        override=OVERRIDABLE,
    )
    level: FloatProperty(
        name="Softness",
        description="Takes the fine structure away: each step of 1 removes what is half as large as the rest. 0 keeps "
        "all grain, 4 leaves broad drifts, at 8 the air is even",
        min=0.0,
        max=8.0,
        default=0.0,
        step=10,
        update=tag,
        override=OVERRIDABLE,
    )
    scale_m: FloatProperty(
        name="Scale",
        description="Size of the largest wisps. Some metres are banks of mist, some centimetres are smoke of a "
        "cigarette; as large as the whole scene, one part is simply hazier than another",
        subtype="DISTANCE",
        unit="LENGTH",
        min=1e-4,
        max=1e6,
        soft_min=0.05,
        soft_max=100.0,
        default=2.0,
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    octaves: IntProperty(
        name="Octaves",
        description="Layers of finer structure, each of half the size of the one before: 1 has soft blobs, 3 clouds, "
        "5 smoke with fine threads. Rendering takes the same time",
        min=1,
        max=8,
        default=5,
        update=tag,
        override=OVERRIDABLE,
    )
    persistence: FloatProperty(
        name="Persistence",
        description="How strong each finer layer is: below 0.4 mist is smooth, above 0.6 it is grainy like dust",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=0.5,
        update=tag,
        override=OVERRIDABLE,
    )
    contrast: FloatProperty(
        name="Contrast",
        description="How far the air goes from thin to thick. Above 2 there are holes without any, and dense wisps; "
        "the shafts as a whole stay as bright as they were",
        min=0.0,
        max=10.0,
        soft_max=5.0,
        default=1.0,
        update=tag,
        override=OVERRIDABLE,
    )
    seed: IntProperty(
        name="Seed",
        description="Deals other wisps of the same kind",
        min=0,
        max=2**31 - 1,
        default=0,
        update=tag,
        override=OVERRIDABLE,
    )
    weighting: EnumProperty(
        name="Seen Along",
        description="Which part of the air along the view its texture is taken from",
        items=WEIGHTINGS,
        default="LIT_PARTS",
        update=tag,
        override=OVERRIDABLE,
    )
    step_count: IntProperty(
        name="Steps",
        description="Looks at the air along each view ray. Too few make fine grain in deep air crawl when it moves; "
        "time grows in proportion. 64 is enough for all but the finest",
        min=1,
        max=4096,
        soft_min=8,
        soft_max=512,
        default=64,
        update=tag,
        override=OVERRIDABLE,
    )
    upsampling: EnumProperty(
        name="Resolution",
        description="Pixels that share a look at the air in final renders; edges of what stands in it stay sharp",
        items=UPSAMPLINGS,
        default="1",
        update=tag,
        override=OVERRIDABLE,
    )
    viewport_upsampling: EnumProperty(
        name="Viewport",
        description="Pixels that share a look at the air in rendered viewports; edges of what stands in it stay sharp",
        items=UPSAMPLINGS,
        default="4",
        update=tag,
        override=OVERRIDABLE,
    )
    wind_m_per_s: FloatVectorProperty(
        name="Wind",
        description="Carries the texture along, at so many metres per second. Keyframe it, and gusts push the mist on "
        "from where it is, without a jump",
        subtype="VELOCITY",
        unit="VELOCITY",
        size=3,
        soft_min=-10.0,
        soft_max=10.0,
        default=(0.0, 0.0, 0.0),
        step=10,
        update=tag,
        override=OVERRIDABLE,
    )
    offset_m: FloatVectorProperty(
        name="Offset",
        description="Moves the texture to where it looks best; the wind carries it on from there",
        subtype="TRANSLATION",
        unit="LENGTH",
        size=3,
        default=(0.0, 0.0, 0.0),
        step=10,
        update=tag,
        override=OVERRIDABLE,
    )
    painted: PointerProperty(
        name="Painted Air",
        description="The box in which amount, softness and intensity are painted",
        type=Object,
        poll=may_be_painted,
        update=tag,
        override=OVERRIDABLE,
    )
