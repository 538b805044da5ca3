# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions: layers of colour over two parameters of a view ray (Kol 2018, section 5.4.2).

``RenderConfig.transfer_functions`` takes them; native/transfer_functions/transfer_function.hpp says what the
numbers do.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

from .scene_description import Image

Rgba = tuple[float, float, float, float]


class Axis(IntEnum):
    """A parameter of a view ray, brought to [0, 1]."""

    AVERAGE_VISIBILITY = 0  #: Lit share of its length in media, over full_visibility.
    DEPTH = 1  #: Of its first surface, along the camera's axis, over the range; the sky is 1.
    MEAN_LIT_POSITION = 2  #: Mean distance of its lit points, over the range; 0 where nothing is lit.
    LIGHT_ANGLE = 3  #: Between the ray and the way to the light, over pi: 0 looks into the light.
    OPTICAL_DEPTH = 4  #: 1 - exp(-optical depth) up to its first surface, mean over the channels.
    HEIGHT = 5  #: World Z of its first surface over the range; the sky is 1.
    MASK = 6  #: Luminance of an image over the camera's frame.


class Use(IntEnum):
    """How the function's colour C meets the radiance L of the shafts."""

    REPLACE = 0  #: strength * C
    MULTIPLY = 1  #: L * C
    TINT = 2  #: luminance(L) * C


class BlendMode(IntEnum):
    """Of a layer's colour with what lies below it, as Blender's Mix node names them."""

    MIX = 0
    DARKEN = 1
    MULTIPLY = 2
    BURN = 3
    LIGHTEN = 4
    SCREEN = 5
    DODGE = 6
    ADD = 7
    OVERLAY = 8
    SOFT_LIGHT = 9
    LINEAR_LIGHT = 10
    DIFFERENCE = 11
    EXCLUSION = 12
    SUBTRACT = 13
    DIVIDE = 14
    HUE = 15
    SATURATION = 16
    COLOR = 17
    VALUE = 18


class LayerKind(IntEnum):
    """Where a layer's colours come from."""

    SOLID = 0
    GRADIENT = 1
    DIFFUSION = 2
    IMAGE = 3


class GradientShape(IntEnum):
    """How a gradient spreads."""

    LINEAR = 0
    RADIAL = 1


@dataclass(frozen=True, kw_only=True)
class ParameterAxis:
    """What one axis of a transfer function measures."""

    axis: Axis
    #: DEPTH, MEAN_LIT_POSITION, HEIGHT: what is 0 and what is 1; equal: fitted to what the frame shows.
    range_m: tuple[float, float] = (0.0, 0.0)
    full_visibility: float = 0.0  #: AVERAGE_VISIBILITY: what is 1, [0, 1]; 0: fitted to what the frame shows.
    mask: Image | None = None  #: MASK.


@dataclass(frozen=True, kw_only=True)
class Constraint:
    """What a diffusion layer has at a place."""

    position: tuple[float, float] = (0.5, 0.5)  #: [0, 1], of the function's x and y axis.
    colour: Rgba = (1.0, 1.0, 1.0, 1.0)  #: Scene-linear, with alpha in [0, 1].
    #: World space: the parameters of this point's view ray are the position, then.
    point: tuple[float, float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class Layer:
    """One layer; fields of other kinds than its own are not read."""

    name: str
    kind: LayerKind = LayerKind.SOLID
    mode: BlendMode = BlendMode.MIX
    opacity: float = 1.0  #: [0, 1].
    colour: Rgba = (1.0, 1.0, 1.0, 1.0)  #: SOLID: scene-linear, with alpha.
    ramp: tuple[Rgba, ...] = ()  #: GRADIENT: evenly spaced over [0, 1], both ends included, scene-linear.
    shape: GradientShape = GradientShape.LINEAR
    start: tuple[float, float] = (0.0, 0.5)  #: GRADIENT: where the ramp begins; RADIAL: its middle.
    end: tuple[float, float] = (1.0, 0.5)  #: GRADIENT: where the ramp ends; RADIAL: on its rim.
    constraints: tuple[Constraint, ...] = ()  #: DIFFUSION.
    smoothness: float = 0.25  #: DIFFUSION: 0 solves Laplace's equation, larger ones bend like a plate over this length.
    image: Image | None = None  #: IMAGE: over [0, 1]^2.


@dataclass(frozen=True, kw_only=True)
class TransferFunction:
    """Layers from bottom to top; without any that has a say, the picture stays the physical one, bit for bit."""

    name: str
    x: ParameterAxis = field(default_factory=lambda: ParameterAxis(axis=Axis.AVERAGE_VISIBILITY))
    y: ParameterAxis = field(default_factory=lambda: ParameterAxis(axis=Axis.DEPTH))
    use: Use = Use.REPLACE
    strength: float = 1.0  #: REPLACE: the radiance of colour 1, W/(m^2 sr), [0, 1e6].
    layers: tuple[Layer, ...] = ()


@dataclass(frozen=True, kw_only=True)
class WeightedFunction:
    """A share of a function in what a frame shows; what the shares leave of 1 is the physical picture."""

    function: TransferFunction
    weight: float = 1.0
