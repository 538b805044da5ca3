# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions to start from, as small descriptions; a preset makes an ordinary function of itself.

Colours are written as they look on a screen, ``#rrggbb`` or ``#rrggbbaa``. Most multiply or tint, and so take their
brightness from the scene; the few that replace say how bright they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mathutils import Color

from .function_trees import Rgba, new_function, ramp_of, set_stops
from .item_lists import ItemList, OrderedList

if TYPE_CHECKING:
    from bpy.types import NodeTree

    from .properties.transfer_layers import TyndallTransferLayer

#: Of a gradient: over X, the average visibility, or over Y, mostly the depth.
_ALONG_X = (0.0, 0.5), (1.0, 0.5)
_ALONG_Y = (0.5, 0.0), (0.5, 1.0)

Place = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class PresetLayer:
    """What differs from a new layer of the kind that its colours make it."""

    name: str
    colour: str = ""  #: Of a solid.
    stops: tuple[tuple[float, str], ...] = ()  #: Of a gradient.
    steps: bool = False  #: Colours of a gradient end at the next stop, instead of passing into it.
    from_to: tuple[Place, Place] = _ALONG_X
    constraints: tuple[tuple[Place, str], ...] = ()  #: Of a diffusion.
    smoothness: float = 0.25
    gain: float = 1.0  #: On all colours: 2 is twice as bright.
    blend_mode: str = "MIX"
    opacity: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Preset:
    """What differs from a new function."""

    identifier: str
    name: str
    description: str
    layers: tuple[PresetLayer, ...]
    use: str = "TINT"
    strength: float = 1.0
    x: str = "AVERAGE_VISIBILITY"
    y: str = "DEPTH"


PRESETS = (
    Preset(
        identifier="SUNRISE",
        name="Sunrise",
        description="Violet shade, orange and pale gold light, rosy in the distance",
        layers=(
            PresetLayer(
                name="Light",
                stops=((0.0, "#4a4478"), (0.35, "#e0705a"), (0.7, "#ffab5c"), (1.0, "#ffe6b0")),
                gain=1.4,
            ),
            PresetLayer(
                name="Rosy Distance",
                stops=((0.2, "#ffffff"), (1.0, "#ffb9b4")),
                from_to=_ALONG_Y,
                blend_mode="MULTIPLY",
            ),
        ),
    ),
    Preset(
        identifier="EMBER",
        name="Ember",
        description="Glowing coal: dark red in half light, orange and yellow where it is full",
        layers=(
            PresetLayer(
                name="Glow",
                stops=((0.0, "#300808"), (0.3, "#a81c0c"), (0.65, "#ff6a14"), (1.0, "#ffd060")),
                gain=1.6,
            ),
        ),
    ),
    Preset(
        identifier="DEEP_SEA",
        name="Deep Sea",
        description="Green glass close by, deep blue where the water is long",
        layers=(
            PresetLayer(
                name="Water", stops=((0.0, "#8ff0d8"), (0.4, "#2fa8c8"), (1.0, "#123a8c")), from_to=_ALONG_Y, gain=1.8
            ),
            PresetLayer(name="Shade", stops=((0.0, "#5a78b0"), (0.6, "#ffffff")), blend_mode="MULTIPLY", opacity=0.8),
        ),
    ),
    Preset(
        identifier="MOONLIT",
        name="Moonlit",
        description="Day for night: cold and dim, silver where the light is full",
        layers=(PresetLayer(name="Silver", stops=((0.0, "#26386e"), (0.6, "#6c8ad0"), (1.0, "#ccdcff")), gain=0.7),),
    ),
    Preset(
        identifier="NOIR",
        name="Posterised Noir",
        description="Three greys with hard edges, on the physical brightness",
        layers=(
            PresetLayer(
                name="Greys", stops=((0.0, "#000000"), (0.2, "#6c6c6c"), (0.55, "#ffffff")), steps=True, gain=1.3
            ),
        ),
    ),
    Preset(
        identifier="ALARM",
        name="Alarm",
        description="Red, orange and yellow bands with hard edges, near black in full shade. Of strength 0.3",
        use="REPLACE",
        strength=0.3,
        layers=(
            PresetLayer(
                name="Bands",
                stops=((0.0, "#12040c"), (0.06, "#4a0014"), (0.25, "#d0021b"), (0.55, "#ff7a00"), (0.8, "#ffe14a")),
                steps=True,
            ),
            PresetLayer(
                name="Night Behind",
                stops=((0.55, "#ffffff"), (0.75, "#50508c")),
                from_to=_ALONG_Y,
                blend_mode="MULTIPLY",
            ),
        ),
    ),
    Preset(
        identifier="PASTEL_DAWN",
        name="Pastel Dawn",
        description="Rose, peach, mint and lilac that pass into each other",
        layers=(
            PresetLayer(
                name="Pastels",
                constraints=(
                    ((0.05, 0.1), "#c8b8f0"),
                    ((0.1, 0.9), "#b8e0f4"),
                    ((0.5, 0.5), "#ffd8c8"),
                    ((0.95, 0.1), "#ffe8b8"),
                    ((0.9, 0.9), "#ffc0d0"),
                ),
                smoothness=0.4,
                gain=1.25,
            ),
        ),
    ),
    Preset(
        identifier="TOXIC",
        name="Toxic",
        description="Poison green with a murky shade, sulphur yellow in full light",
        layers=(
            PresetLayer(
                name="Poison", stops=((0.0, "#183010"), (0.4, "#4ea818"), (0.8, "#b8f02c"), (1.0, "#f4ff8c")), gain=1.4
            ),
        ),
    ),
    Preset(
        identifier="SEPIA",
        name="Sepia",
        description="An old photograph: every light in one warm brown",
        layers=(PresetLayer(name="Brown", stops=((0.0, "#7e4c22"), (1.0, "#f4c078")), gain=1.35),),
    ),
    Preset(
        identifier="TEAL_ORANGE",
        name="Teal and Orange",
        description="The cinema's own: teal shade, orange light",
        layers=(
            PresetLayer(
                name="Contrast",
                stops=((0.0, "#12b0b4"), (0.4, "#84a8a0"), (0.6, "#f0a878"), (1.0, "#ff9238")),
                gain=1.4,
            ),
        ),
    ),
    Preset(
        identifier="COMIC",
        name="Comic Bands",
        description="Four flat printing inks, from indigo to lemon",
        layers=(
            PresetLayer(
                name="Inks",
                stops=((0.0, "#3a2c8c"), (0.25, "#d8347c"), (0.5, "#ff8c42"), (0.75, "#ffe95c")),
                steps=True,
                gain=1.4,
            ),
        ),
    ),
    Preset(
        identifier="CANDLE",
        name="Candle",
        description="Straw yellow towards the light, copper and red away from it",
        y="LIGHT_ANGLE",
        layers=(
            PresetLayer(
                name="Flame",
                stops=((0.0, "#ffdca0"), (0.12, "#ffae5c"), (0.4, "#e8702c"), (1.0, "#8c2c1c")),
                from_to=_ALONG_Y,
                gain=1.3,
            ),
        ),
    ),
    Preset(
        identifier="AURORA",
        name="Aurora",
        description="Green, cyan and magenta curtains, one behind the other",
        layers=(
            PresetLayer(
                name="Curtains",
                constraints=(
                    ((0.5, 0.05), "#20ffa0"),
                    ((0.1, 0.35), "#1c5cff"),
                    ((0.8, 0.4), "#60ffe0"),
                    ((0.5, 0.7), "#c83cff"),
                    ((0.9, 0.95), "#ff6cb0"),
                ),
                smoothness=0.15,
                gain=1.6,
            ),
        ),
    ),
    Preset(
        identifier="QUIET_FOREGROUND",
        name="Quiet Foreground",
        description="Colours stay; shafts in front of what is near step back, those far away get clear",
        use="MULTIPLY",
        layers=(
            PresetLayer(
                name="Distance",
                stops=((0.0, "#404040"), (0.35, "#a8a8a8"), (1.0, "#ffffff")),
                from_to=_ALONG_Y,
                gain=1.4,
            ),
        ),
    ),
    Preset(
        identifier="STAGE",
        name="Clear Beams",
        description="Colours stay; half light gets darker and full light brighter, as on a stage",
        use="MULTIPLY",
        layers=(PresetLayer(name="Contrast", stops=((0.0, "#202020"), (0.5, "#8c8c8c"), (1.0, "#ffffff")), gain=1.8),),
    ),
)


def make_preset(identifier: str) -> NodeTree:
    """A new function, as the preset describes it."""
    preset = next(preset for preset in PRESETS if preset.identifier == identifier)
    tree = new_function(preset.name)
    function = tree.tyndall
    function.use, function.strength = preset.use, preset.strength
    function.x.axis, function.y.axis = preset.x, preset.y
    layers = OrderedList(function, "layers", "active_layer")
    for described in preset.layers:
        _make_layer(layers.add(described.name), described)
    return tree


def _make_layer(layer: TyndallTransferLayer, described: PresetLayer) -> None:
    layer.blend_mode, layer.opacity = described.blend_mode, described.opacity
    if described.stops:
        layer.kind = "GRADIENT"
        layer.start, layer.end = described.from_to
        ramp = ramp_of(layer)
        ramp.interpolation = "CONSTANT" if described.steps else "LINEAR"
        set_stops(ramp, [(place, _scene_linear(colour, described.gain)) for place, colour in described.stops])
    elif described.constraints:
        layer.kind, layer.smoothness = "DIFFUSION", described.smoothness
        constraints = ItemList(layer, "constraints", "active_constraint")
        for position, colour in described.constraints:
            constraint = constraints.add("Colour")
            constraint.position, constraint.colour = position, _scene_linear(colour, described.gain)
    else:
        layer.kind, layer.colour = "SOLID", _scene_linear(described.colour, described.gain)


def _scene_linear(colour: str, gain: float) -> Rgba:
    red, green, blue, alpha = (int(f"{colour[1:]}ff"[at : at + 2], 16) / 255.0 for at in (0, 2, 4, 6))
    linear = Color((red, green, blue)).from_srgb_to_scene_linear() * gain
    return linear.r, linear.g, linear.b, alpha
