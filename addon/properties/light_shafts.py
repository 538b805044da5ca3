# SPDX-License-Identifier: GPL-3.0-or-later
"""``scene.tyndall.shafts``: how light that media scatter is computed. The media themselves are Blender's shaders."""

from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty
from bpy.types import Object, PropertyGroup

from ..edited_light import is_light_of_scene
from .tagging import EXTENSIBLE, OVERRIDABLE, tag
from .transfer_functions import TyndallTransferState

METHODS = (
    (
        "EXACT",
        "Exact",
        (
            "Cuts the occluders' triangles with the plane of every view ray and the light: no discretisation at all. "
            "The slowest; for checking the others, and for finals with few triangles"
        ),
        0,
    ),
    (
        "EPIPOLAR",
        "Epipolar",
        (
            "Rasterises the occluders' triangles into slices through the camera and the light, as finely as the error "
            "target asks for. For finals"
        ),
        1,
    ),
    (
        "SHADOW_MAP",
        "Shadow Map",
        (
            "Looks the lit parts of every view ray up in a depth map seen from the light. The fastest; "
            "edges of shafts are as sharp as the map's resolution"
        ),
        2,
    ),
)


GRID_METHODS = (
    (
        "MARCH",
        "March",
        "Steps through volumes of voxels that are as fine as the error target asks for: no noise",
        0,
    ),
    (
        "RATIO_TRACKING",
        "Ratio Tracking",
        "Random points and transmittances: right on average, with noise that more samples reduce. Checks the other",
        1,
    ),
)


class TyndallLightShaftSettings(PropertyGroup):
    method: EnumProperty(
        name="Method",
        description="How final renders find the lit parts of view rays",
        items=METHODS,
        default="EPIPOLAR",
        update=tag,
        override=OVERRIDABLE,
    )
    viewport_method: EnumProperty(
        name="Viewport",
        description="How the rendered viewport finds the lit parts of view rays",
        items=METHODS,
        default="SHADOW_MAP",
        update=tag,
        override=OVERRIDABLE,
    )
    error_target: FloatProperty(
        name="Error Target",
        description="Relative error of the frame's shafts that the resolution is picked by: "
        "0.001 is 0.1 %. Half the error costs up to twice the time and memory. Exact has none",
        min=1e-5,
        max=0.1,
        soft_min=1e-4,
        default=0.002,
        precision=5,
        step=0.1,
        update=tag,
        override=OVERRIDABLE,
    )
    resolution: IntProperty(
        name="Resolution",
        description="Rows of slices, and texels per side of the depth map. 0 picks it from the error target. "
        "Memory of the depth map grows with its square: 4096 takes 64 MB per light",
        min=0,
        max=16384,
        soft_max=8192,
        default=0,
        update=tag,
        override=OVERRIDABLE,
    )
    light_samples: IntProperty(
        name="Light Samples",
        description="Points per light that has a radius or an angle: the more, the smoother the penumbrae of its "
        "shafts. A light without a size always takes one. The viewport takes at most 8",
        min=1,
        max=65536,
        soft_max=256,
        default=64,
        update=tag,
        override=OVERRIDABLE,
    )
    world_samples: IntProperty(
        name="World Samples",
        description="Directions from which the world's light is scattered by media. "
        "0: the world lights surfaces only. The viewport takes at most 16",
        min=0,
        max=65536,
        soft_max=1024,
        default=256,
        update=tag,
        override=OVERRIDABLE,
    )
    adapts_strata: BoolProperty(
        name="Adapt to Error Target",
        description="Each light takes as many samples as the error target asks for, at most those above: a small lamp "
        "or a dim sky takes few. Off: all of them",
        default=True,
        update=tag,
        override=OVERRIDABLE,
    )
    lens_steps: IntProperty(
        name="Lens Steps",
        description="Places on the lens of a camera with depth of field from which shafts are seen, at most one per "
        "sample: their mean is blurred as surfaces are. Each takes the time in which shafts set up a frame. 1: shafts "
        "stay sharp. Of perspective cameras, in renders; without depth of field or fog it costs nothing",
        min=1,
        max=4096,
        soft_max=64,
        default=16,
        update=tag,
        override=OVERRIDABLE,
    )
    shares_strata: BoolProperty(
        name="Share between Pixels",
        description="Where a light has more samples than a pixel, neighbouring pixels take different ones and share "
        "what they find: many times faster, and blurs soft shafts by at most two pixels; so for few samples with the "
        "world's light on surfaces. Off asks for all of them in every pixel. The exact method never shares",
        default=True,
        update=tag,
        override=OVERRIDABLE,
    )
    grid_method: EnumProperty(
        name="Volumes",
        description="How light in volumes of voxels, as OpenVDB files hold them, is found",
        items=GRID_METHODS,
        default="MARCH",
        update=tag,
        override=OVERRIDABLE,
    )
    grid_error_target: FloatProperty(
        name="Volume Error Target",
        description="Relative error of the light in volumes of voxels that steps are picked by: 0.005 is 0.5 %",
        min=1e-4,
        max=0.3,
        soft_min=1e-3,
        default=0.005,
        precision=4,
        update=tag,
        override=OVERRIDABLE,
    )
    attenuates_light: BoolProperty(
        name="Attenuate on the Way",
        description="Media dim light on its way from the lamp to where it is scattered, as in Cycles. Off is faster "
        "and brighter, and keeps a sun visible in a world filled with a medium, but it is not physical",
        default=True,
        update=tag,
        override=OVERRIDABLE,
    )
    use_transfer_functions: BoolProperty(
        name="Use Transfer Functions",
        description="Recolour the shafts. Off: they are physical",
        default=True,
        update=tag,
        override=OVERRIDABLE,
    )
    transfer_mix: FloatProperty(
        name="Mix",
        description="How much of the recolouring there is: 0 is the physical picture",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=1.0,
        update=tag,
        override=OVERRIDABLE,
    )
    transfer_light: PointerProperty(
        name="Light",
        description="Whose visibility, lit parts and angle transfer functions are about. None: the strongest sun that "
        "scatters, or else all lights together",
        type=Object,
        poll=is_light_of_scene,
        update=tag,
        override=OVERRIDABLE,
    )
    transfer_states: CollectionProperty(
        name="Transfer States",
        description="Transfer functions, in the order in which the scene goes through them; most scenes have one",
        type=TyndallTransferState,
        override=EXTENSIBLE,
    )
    active_transfer_state: IntProperty(
        name="Active Transfer State",
        description="Index of the state whose function is shown",
        min=0,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    transfer_state: FloatProperty(
        name="State",
        description="Which function the shafts show: 0 is the first of the list, 2.4 is 60 % of the third and 40 % of "
        "the fourth. Keyframe it to go from one to the next",
        min=0.0,
        max=10000.0,
        default=0.0,
        step=10,
        update=tag,
        override=OVERRIDABLE,
    )
