# SPDX-License-Identifier: GPL-3.0-or-later
"""``light.tyndall.occluder_edits``: what is done to the occluders before a light, for the air's sake or for all."""

from __future__ import annotations

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty
from bpy.types import Collection, Image, Object, PropertyGroup

from .list_items import SwitchedItem
from .tagging import OVERRIDABLE, tag, tag_pointer

KINDS = (
    (
        "CLOSE",
        "Fill Holes",
        (
            "Holes up to a size vanish for the air: leaves become one shade, and a thicket of thin shafts a few broad "
            "ones. Costs one filter of the light's depth map"
        ),
        "SNAP_FACE",
        0,
    ),
    (
        "EPIPOLAR_CLOSE",
        "Fill Holes Along View",
        (
            "The same along the light's planes through the camera only: no dark halo in mid-air around what it closes. "
            "The cheaper of the two; depends on where the camera is"
        ),
        "VIEW_CAMERA",
        1,
    ),
    (
        "SILHOUETTE",
        "Draw Out Silhouettes",
        (
            "Occluders grow away from the camera, behind what it sees of them: shafts around them get clear and dark "
            "enough to read. Depends on where the camera is"
        ),
        "MOD_OUTLINE",
        2,
    ),
    (
        "HOLES",
        "Make Holes",
        (
            "Noise cuts holes, so that light falls through in new shafts: through solid walls, too. Surfaces keep "
            "their shadows, unless asked otherwise"
        ),
        "MOD_NOISE",
        3,
    ),
)
#: Of new edits: short enough for a row of the sidebar's list.
KIND_NAMES = {
    "CLOSE": "Fill Holes",
    "EPIPOLAR_CLOSE": "Fill Along View",
    "SILHOUETTE": "Silhouettes",
    "HOLES": "Make Holes",
}
KIND_ICONS = {identifier: icon for identifier, _label, _description, icon, _number in KINDS}
SHAPES = (
    ("DISC", "Disc", "Round holes up to this diameter, and slits up to this width, vanish", "MESH_CIRCLE", 0),
    ("SQUARE", "Square", "Square holes up to this side; the fastest, and leaves square corners", "MESH_PLANE", 1),
)
TARGETS = (
    ("ALL", "Everything", "Whatever casts a shadow", "WORLD", 0),
    ("OBJECT", "Object", "One object, and what it instances", "OBJECT_DATA", 1),
    ("COLLECTION", "Collection", "All objects of a collection and of those in it", "OUTLINER_COLLECTION", 2),
)
MASK_CHANNELS = (
    ("LUMINANCE", "Luminance", "Where the image is brighter than mid grey, as the Image Editor shows it", 0),
    ("ALPHA", "Alpha", "Where the image is more than half opaque", 1),
)
#: What an edit can be of: all that may have a mesh, and all that may instance one.
TARGET_TYPES = frozenset({"MESH", "CURVE", "SURFACE", "META", "FONT", "EMPTY"})


def is_target(_edit: PropertyGroup, thing: Object) -> bool:
    return thing.type in TARGET_TYPES


class TyndallHoleNoise(PropertyGroup):
    scale_m: FloatProperty(
        name="Scale",
        description="Size of the noise's coarsest features; holes are about half as large",
        subtype="DISTANCE",
        unit="LENGTH",
        min=1e-4,
        max=1e6,
        soft_min=0.01,
        soft_max=100.0,
        default=1.0,
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    octaves: IntProperty(
        name="Octaves",
        description="Layers of noise, each of twice the frequency of the one before: the more, the more ragged the "
        "holes. Time grows in proportion",
        min=1,
        max=12,
        soft_max=8,
        default=3,
        update=tag,
        override=OVERRIDABLE,
    )
    persistence: FloatProperty(
        name="Persistence",
        description="Amplitude of each octave as a share of the one before: 0 is smooth, 1 is all grain",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=0.5,
        update=tag,
        override=OVERRIDABLE,
    )
    probability: FloatProperty(
        name="Holes",
        description="Share of the occluders' area that becomes holes",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=0.3,
        update=tag,
        override=OVERRIDABLE,
    )
    sway: FloatProperty(
        name="Sway",
        description="How far the noise moves its own lookup, in units of its scale: holes get stretched, and turning "
        "makes them drift and change their form. 0 stands still",
        min=0.0,
        max=100.0,
        soft_max=2.0,
        default=0.0,
        step=10,
        update=tag,
        override=OVERRIDABLE,
    )
    turn_rad: FloatProperty(
        name="Turn",
        description="Turns the noise that moves the lookup: animate it to have holes drift. A whole turn is a loop "
        "without a seam. Needs some sway",
        subtype="ANGLE",
        unit="ROTATION",
        default=0.0,
        update=tag,
        override=OVERRIDABLE,
    )
    seed: IntProperty(
        name="Seed",
        description="Another seed makes other holes of the same kind",
        min=0,
        max=2**31 - 1,
        default=0,
        update=tag,
        override=OVERRIDABLE,
    )


class TyndallOccluderEdit(SwitchedItem, PropertyGroup):
    UNNAMED = "Edit"

    kind: EnumProperty(
        name="Kind",
        description="What is done to the occluders",
        items=KINDS,
        default="CLOSE",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    shape: EnumProperty(
        name="Shape",
        description="Of the largest hole that vanishes",
        items=SHAPES,
        default="DISC",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    size_m: FloatProperty(
        name="Size",
        description="Fill Holes: the largest holes that vanish. Draw Out Silhouettes: by how much occluders grow. "
        "Of a lamp's edits, measured at the distance below",
        subtype="DISTANCE",
        unit="LENGTH",
        min=0.0,
        max=1e6,
        soft_max=10.0,
        default=0.5,
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    distance_m: FloatProperty(
        name="At Distance",
        description="Sizes are measured this far from the lamp; as its light spreads, they grow in proportion",
        subtype="DISTANCE",
        unit="LENGTH",
        min=1e-4,
        max=1e6,
        soft_min=0.1,
        soft_max=100.0,
        default=5.0,
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    noise: PointerProperty(name="Noise", type=TyndallHoleNoise, update=tag, override=OVERRIDABLE)
    affects_surfaces: BoolProperty(
        name="Light Surfaces",
        description="Surfaces see this edit, too, so that a floor agrees with the air above it: light falls through "
        "holes that are made, and what is filled or drawn out casts a shadow",
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
    target: EnumProperty(
        name="Affects",
        description="Which occluders are edited. Those with the same edits are closed together",
        items=TARGETS,
        default="ALL",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    target_object: PointerProperty(
        name="Object",
        description="The occluder to edit. Of an instancer, what it instances: all instances of that",
        type=Object,
        poll=is_target,
        update=tag_pointer,
        override=OVERRIDABLE,
    )
    target_collection: PointerProperty(
        name="Collection",
        description="Its objects, those of the collections in it, and what they instance",
        type=Collection,
        update=tag_pointer,
        override=OVERRIDABLE,
    )
    mask_image: PointerProperty(
        name="Mask",
        description="A picture in the light's space: the edit works where it is set, and not outside of it. Sun: "
        "around the light's origin, upright along its axes. Spot: as wide as its cone. Point: all directions",
        type=Image,
        update=tag_pointer,
        override=OVERRIDABLE,
    )
    mask_channel: EnumProperty(
        name="Channel",
        description="What of the image is the mask",
        items=MASK_CHANNELS,
        default="LUMINANCE",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    mask_size_m: FloatProperty(
        name="Width",
        description="Of the mask before a sun; its height follows from the image",
        subtype="DISTANCE",
        unit="LENGTH",
        min=1e-4,
        max=1e6,
        soft_min=0.1,
        soft_max=1000.0,
        default=10.0,
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )


#: In the order of registration: a group before the group that holds it.
CLASSES = (TyndallHoleNoise, TyndallOccluderEdit)
