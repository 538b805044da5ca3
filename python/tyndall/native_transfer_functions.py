# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions, as the native side takes them, and as pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import _native
from .native_textures import build_texture
from .scene_description import Extension, Image, TextureUse

if TYPE_CHECKING:
    from collections.abc import MutableMapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from .transfer_functions import Constraint, Layer, ParameterAxis, TransferFunction, WeightedFunction

    #: Native images by the keys of those they were made of.
    Textures = MutableMapping[str, _native.Texture]


def build_weighted_functions(
    functions: Sequence[WeightedFunction],
    origin_in_world: NDArray[np.float64],
    textures: Textures,
    reports: list[str],
) -> list[_native.WeightedFunction]:
    """The native functions; a layer or a function that cannot be used is left out with a report, the others stay.

    ``origin_in_world``, (3,): what the points of constraints become relative to. ``textures`` is looked into by the
    images' keys, and holds those that are in use afterwards.
    """
    builder = _Builder(origin_in_world, textures, reports)
    built = []
    for weighted in functions:
        try:
            built.append(_native.WeightedFunction(builder.function(weighted.function), weighted.weight))
        except _native.InvalidInput as error:
            reports.append(f'Transfer function "{weighted.function.name}" is left out: {error}')
    for key in textures.keys() - builder.used:
        del textures[key]
    return built


def compose(function: TransferFunction, size: int) -> NDArray[np.float32]:
    """The function's picture, float32 ``(size, size, 4)``: scene-linear RGB multiplied with alpha, rows bottom to top.

    Texel ``[j, i]`` holds it at ((i + 1/2) / size, (j + 1/2) / size); constraints are where their positions say. 0
    everywhere where no layer has a say. Raises ``InvalidInput``, which names the first layer that cannot be used.
    """
    builder = _Builder((0.0, 0.0, 0.0), {}, None)
    return _native.compose_transfer_function(builder.function(function), size, _native.Progress())


class _Builder:
    """Makes native parts, each image once. Without ``reports``, the first that cannot be used raises InvalidInput."""

    def __init__(
        self, origin_in_world: NDArray[np.float64] | Sequence[float], textures: Textures, reports: list[str] | None
    ) -> None:
        self._origin_in_world = origin_in_world
        self._textures = textures
        self._reports = reports
        self.used: set[str] = set()

    def function(self, function: TransferFunction) -> _native.TransferFunction:
        layers = []
        for layer in function.layers:
            try:
                layers.append(self._layer(layer))
            except _native.InvalidInput as error:
                if self._reports is None:
                    raise
                self._reports.append(f'Transfer function "{function.name}": {error}; the layer is left out')
        return _native.TransferFunction(
            name=function.name,
            x=self._axis(function.x),
            y=self._axis(function.y),
            use=int(function.use),
            strength=function.strength,
            layers=layers,
        )

    def _axis(self, axis: ParameterAxis) -> _native.ParameterAxis:
        return _native.ParameterAxis(
            axis=int(axis.axis),
            range_m=axis.range_m,
            full_visibility=axis.full_visibility,
            mask=self._texture(axis.mask),
        )

    def _layer(self, layer: Layer) -> _native.TransferLayer:
        try:
            image = self._texture(layer.image)
        except _native.InvalidInput as error:
            raise _native.InvalidInput(f'layer "{layer.name}": {error}') from None
        return _native.TransferLayer(
            name=layer.name,
            kind=int(layer.kind),
            mode=int(layer.mode),
            opacity=layer.opacity,
            colour=layer.colour,
            ramp=layer.ramp,
            shape=int(layer.shape),
            start=layer.start,
            end=layer.end,
            constraints=[self._constraint(constraint) for constraint in layer.constraints],
            smoothness=layer.smoothness,
            image=image,
        )

    def _constraint(self, constraint: Constraint) -> _native.Constraint:
        point = constraint.point
        if point is not None:
            x, y, z = (float(c - o) for c, o in zip(point, self._origin_in_world, strict=True))
            point = (x, y, z)
        return _native.Constraint(position=constraint.position, colour=constraint.colour, point=point)

    def _texture(self, image: Image | None) -> _native.Texture | None:
        if image is None:
            return None
        self.used.add(image.key)
        if image.key not in self._textures:
            reports = self._reports if self._reports is not None else []
            self._textures[image.key] = build_texture(
                TextureUse(image=image, extension=Extension.EXTEND), reports, in_memory=True
            )
        return self._textures[image.key]
