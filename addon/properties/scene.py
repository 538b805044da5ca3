# SPDX-License-Identifier: GPL-3.0-or-later
"""``scene.tyndall``: sampling, pixel filter, threads, and the groups of the rooms."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty
from bpy.types import Object, PropertyGroup

from ..edited_light import is_light_of_scene
from .air_brush import TyndallAirBrush
from .heterogeneity import TyndallHeterogeneity
from .indirect import TyndallIndirectSettings
from .light_shafts import TyndallLightShaftSettings
from .over_engine import TyndallOverEngine
from .tagging import OVERRIDABLE, tag
from .voxels import TyndallVoxelizeSettings

PIXEL_FILTERS = (
    ("BOX", "Box", "Every sample within the width counts the same. Width 1 px: the average of the pixel", 0),
    ("GAUSSIAN", "Gaussian", "Soft", 1),
    ("BLACKMAN_HARRIS", "Blackman-Harris", "Sharp without ringing; the default of Cycles, too", 2),
)


class TyndallSceneSettings(PropertyGroup):
    pixel_samples: IntProperty(
        name="Samples",
        description="Rays per pixel of a final render. 1 looks through pixel centres, without antialiasing. "
        "Time grows in proportion. Shafts have little noise: 16 smooths edges well",
        min=1,
        max=65536,
        soft_max=256,
        default=16,
        update=tag,
        override=OVERRIDABLE,
    )
    noise_threshold: FloatProperty(
        name="Noise Threshold",
        description="Pixels whose noise is below this stop before they have taken all samples; edges and fine detail "
        "go on. 0.01 shows no difference; 0: every pixel takes all samples",
        min=0.0,
        max=1.0,
        soft_max=0.1,
        default=0.01,
        precision=4,
        step=0.1,
        update=tag,
        override=OVERRIDABLE,
    )
    viewport_samples: IntProperty(
        name="Viewport Samples",
        description="Rays per pixel at which the rendered viewport stops. It shows a coarse picture first, "
        "then one ray per pixel, then adds more",
        min=1,
        max=1024,
        soft_max=64,
        default=4,
        update=tag,
        override=OVERRIDABLE,
    )
    shows_viewport_work: BoolProperty(
        name="Viewport Timings",
        description="Show in the rendered viewport what its picture took, stage by stage, and what of the last one was "
        "used again",
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
    pixel_filter: EnumProperty(
        name="Filter",
        description="How the rays of a pixel and its neighbours are weighted. Costs the same whichever is chosen",
        items=PIXEL_FILTERS,
        default="BLACKMAN_HARRIS",
        update=tag,
        override=OVERRIDABLE,
    )
    filter_width_px: FloatProperty(
        name="Width",
        description="Full width of the pixel filter. Wider is softer; 0.01 with one sample shows single rays",
        min=0.01,
        max=10.0,
        soft_min=0.5,
        soft_max=4.0,
        default=1.5,
        precision=2,
        step=10,
        subtype="PIXEL",
        update=tag,
        override=OVERRIDABLE,
    )
    voxel_detail_px: FloatProperty(
        name="Level of Detail",
        description="The camera sees cubes of voxels no wider than this as one, with their mean colour and normal, and "
        "as opaque as the voxels in it are together. Far voxels flicker less and render faster; 0: it sees every voxel",
        min=0.0,
        max=64.0,
        soft_max=4.0,
        default=0.5,
        precision=2,
        step=10,
        subtype="PIXEL",
        update=tag,
        override=OVERRIDABLE,
    )
    motion_steps: IntProperty(
        name="Steps",
        description="Moments of the shutter's time at which the scene is rendered, at most one per sample. Few show "
        "copies of what moves fast side by side; as many as the pixels that it crosses show none. Each takes the time "
        "in which Blender and light shafts set up a frame. Where nothing moves there is but one",
        min=1,
        max=4096,
        soft_max=64,
        default=32,
        update=tag,
        override=OVERRIDABLE,
    )
    seed: IntProperty(
        name="Seed",
        description="Another seed gives another pattern of samples at the same quality. "
        "The same seed gives the same picture, whatever the number of threads",
        min=0,
        max=2**31 - 1,
        default=0,
        update=tag,
        override=OVERRIDABLE,
    )
    thread_count: IntProperty(
        name="Threads",
        description="Threads that render; 0 takes all of the machine. The picture does not depend on it",
        min=0,
        max=1024,
        default=0,
        update=tag,
        override=OVERRIDABLE,
    )
    texture_budget_mib: IntProperty(
        name="Textures, MiB",
        description="Memory for the images of materials. Images beyond it go to a file in Blender's temporary folder, "
        "of which the parts in use stay in memory: the picture is the same, at the cost of time. "
        "0 takes up to half of the machine's memory",
        min=0,
        max=2**30,
        soft_max=65536,
        default=0,
        update=tag,
        override=OVERRIDABLE,
    )
    shafts: PointerProperty(
        name="Light Shafts",
        description="How light that media scatter is computed",
        type=TyndallLightShaftSettings,
        update=tag,
        override=OVERRIDABLE,
    )
    heterogeneity: PointerProperty(
        name="Texture of the Air",
        description="Mist, smoke and dust in the light shafts",
        type=TyndallHeterogeneity,
        update=tag,
        override=OVERRIDABLE,
    )
    indirect: PointerProperty(
        name="Indirect Light",
        description="What surfaces see of the world and of one another",
        type=TyndallIndirectSettings,
        update=tag,
        override=OVERRIDABLE,
    )
    air_brush: PointerProperty(
        name="Air Brush",
        description="Paints the air inside of a box",
        type=TyndallAirBrush,
        override=OVERRIDABLE,
    )
    over_engine: PointerProperty(
        name="Over Any Engine",
        description="Light shafts over the picture of another engine",
        type=TyndallOverEngine,
        update=tag,
        override=OVERRIDABLE,
    )
    voxelize: PointerProperty(
        name="Voxelize",
        description="How objects become voxels",
        type=TyndallVoxelizeSettings,
        update=tag,
        override=OVERRIDABLE,
    )
    edited_light: PointerProperty(
        name="Light",
        description="Whose edits the sidebar shows while the active object is no light: choose it to go on editing "
        "while you move its occluders",
        type=Object,
        poll=is_light_of_scene,
        update=tag,
        override=OVERRIDABLE,
    )
