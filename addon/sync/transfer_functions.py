# SPDX-License-Identifier: GPL-3.0-or-later
"""The transfer functions that a frame shows, each with its share: keys and drivers have their values at this frame.

What cannot be used as it is meant is left out, with one report that names function, layer and culprit.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from tyndall.transfer_functions import (
    Axis,
    BlendMode,
    Constraint,
    GradientShape,
    Layer,
    LayerKind,
    ParameterAxis,
    TransferFunction,
    Use,
    WeightedFunction,
)

from ..function_trees import Rgba, ramp_of
from ..item_lists import having_a_say, in_order
from ..properties.transfer_functions import RANGED_AXES
from ..surface_points import anchor_of, follow
from ..transfer_states import shares
from .images import without_pixels

if TYPE_CHECKING:
    from collections.abc import Iterator

    import bpy

    from tyndall.scene_description import Image

    from ..properties.transfer_functions import ParameterAxis as AxisSettings
    from ..properties.transfer_layers import TyndallTransferConstraint, TyndallTransferLayer
    from .images import ImageReader
    from .reports import Reports

#: Of a ramp, ends included: the size of the function's picture.
RAMP_SAMPLES = 256


class _CannotBeUsed(Exception):  # noqa: N818  said to the artist, not raised to a caller
    pass


def read_transfer_functions(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, images: ImageReader, reports: Reports
) -> tuple[WeightedFunction, ...]:
    """``scene`` may be evaluated, or the original. ``images`` are those of functions alone, kept from frame to frame.

    Values are evaluated ones; pointers are the originals': evaluated ones may outlive what they point to.
    """
    images.start_frame()
    try:
        return tuple(_read(scene, FunctionReader(depsgraph, images, reports), depsgraph))
    finally:
        images.end_frame()


def _read(scene: bpy.types.Scene, reader: FunctionReader, depsgraph: bpy.types.Depsgraph) -> Iterator[WeightedFunction]:
    shafts = scene.evaluated_get(depsgraph).tyndall.shafts
    if not shafts.use_transfer_functions:
        return
    states = in_order(scene.original.tyndall.shafts.transfer_states)
    weights: dict[bpy.types.NodeTree, float] = {}
    for place, share in shares(shafts.transfer_state, len(states)):
        function, weight = states[place].function, share * shafts.transfer_mix
        if function is not None and weight > 0.0:
            weights[function] = weights.get(function, 0.0) + weight
    for tree, weight in weights.items():
        function = reader.read(tree)
        if function.layers:
            yield WeightedFunction(function=function, weight=weight)


class FunctionReader:
    """Reads functions of one frame; one that changes nothing has no layers."""

    def __init__(
        self,
        depsgraph: bpy.types.Depsgraph,
        images: ImageReader,
        reports: Reports,
        *,
        follows_surfaces: bool = True,
    ) -> None:
        """Without ``follows_surfaces``, constraints are where they were picked."""
        self._depsgraph = depsgraph
        self._follows_surfaces = follows_surfaces
        self._images = images
        self._reports = reports

    def read(self, tree: bpy.types.NodeTree) -> TransferFunction:
        """``tree`` is the original."""
        function = self.read_without_layers(tree)
        if function is None:
            return TransferFunction(name=tree.name)
        return replace(function, layers=self._layers(tree))

    def read_without_layers(self, tree: bpy.types.NodeTree) -> TransferFunction | None:
        """None: it cannot be used, for the reason that is in the reports."""
        culprit = _culprit(tree)
        settings, original = tree.evaluated_get(self._depsgraph).tyndall, tree.tyndall
        try:
            x = self._axis(settings.x, original.x, "x", culprit)
            y = self._axis(settings.y, original.y, "y", culprit)
        except _CannotBeUsed as reason:
            self._reports.add(culprit, f"left out: {reason}")
            return None
        return TransferFunction(name=tree.name, x=x, y=y, use=Use[settings.use], strength=settings.strength)

    def _axis(self, axis: AxisSettings, original: AxisSettings, name: str, culprit: str) -> ParameterAxis:
        mask = None
        range_m, full_visibility = (0.0, 0.0), 0.0
        if axis.axis == "MASK":
            if original.mask is None:
                raise _CannotBeUsed(f"its {name} axis has no mask image")
            mask = self._image(original.mask, f"the mask of its {name} axis", culprit)
        elif axis.axis == "AVERAGE_VISIBILITY":
            full_visibility = 0.0 if axis.fits_range else axis.full_visibility
        elif axis.axis in RANGED_AXES and not axis.fits_range:
            range_m = axis.low_m, axis.high_m
            if range_m[0] >= range_m[1]:
                self._reports.add(culprit, f"the range of its {name} axis is empty: fitted to the frame instead")
                range_m = 0.0, 0.0
        return ParameterAxis(axis=Axis[axis.axis], range_m=range_m, full_visibility=full_visibility, mask=mask)

    def _image(self, image: bpy.types.Image, what: str, culprit: str) -> Image:
        if (reason := without_pixels(image)) is not None:
            raise _CannotBeUsed(f"{what}, {reason}")
        return self._images.read(image, self._reports, culprit)

    def _layers(self, tree: bpy.types.NodeTree) -> tuple[Layer, ...]:
        original_of = _originals(tree.evaluated_get(self._depsgraph).tyndall.layers, tree.tyndall.layers)
        layers = []
        for layer in having_a_say(original_of):
            culprit = f'{_culprit(tree)}, layer "{layer.name}"'
            try:
                layers.append(self._layer(layer, original_of[layer], culprit))
            except _CannotBeUsed as reason:
                self._reports.add(culprit, f"left out: {reason}")
        return tuple(layers)

    def _layer(self, layer: TyndallTransferLayer, original: TyndallTransferLayer, culprit: str) -> Layer:
        image = None
        constraints: tuple[Constraint, ...] = ()
        if layer.kind == "IMAGE":
            if original.image is None:
                raise _CannotBeUsed("it has no image")
            image = self._image(original.image, "its picture", culprit)
        elif layer.kind == "DIFFUSION":
            if not original.constraints:
                raise _CannotBeUsed("it has no constraints")
            original_of = _originals(layer.constraints, original.constraints)
            constraints = tuple(self._constraint(*pair, culprit) for pair in original_of.items())
        return Layer(
            name=layer.name,
            kind=LayerKind[layer.kind],
            mode=BlendMode[layer.blend_mode],
            opacity=layer.opacity,
            colour=tuple(layer.colour),
            ramp=_ramp(layer) if layer.kind == "GRADIENT" else (),
            shape=GradientShape[layer.shape],
            start=tuple(layer.start),
            end=tuple(layer.end),
            constraints=constraints,
            smoothness=layer.smoothness,
            image=image,
        )

    def _constraint(
        self, constraint: TyndallTransferConstraint, original: TyndallTransferConstraint, culprit: str
    ) -> Constraint:
        """One whose surface is gone stays where it was picked."""
        point = None
        if constraint.is_tracked and self._follows_surfaces:
            try:
                point = self._followed(constraint, original.tracked_object, culprit)
            except _CannotBeUsed as reason:
                self._reports.add(f'{culprit}, constraint "{constraint.name}"', f"stays where it was picked: {reason}")
        return Constraint(position=tuple(constraint.position), colour=tuple(constraint.colour), point=point)

    def _followed(
        self, constraint: TyndallTransferConstraint, thing: bpy.types.Object | None, culprit: str
    ) -> tuple[float, float, float]:
        if thing is None:
            raise _CannotBeUsed("its object is not set, or deleted")
        if self._depsgraph.scene not in thing.users_scene:  # one that was deleted lives on in our pointer
            raise _CannotBeUsed(f'its object "{thing.name}" is not in the scene')
        followed = follow(anchor_of(constraint), thing.evaluated_get(self._depsgraph))
        if followed is None:
            raise _CannotBeUsed(f'its object "{thing.name}" has no surface any more')
        if followed.is_by_place:
            self._reports.add(
                f'{culprit}, constraint "{constraint.name}"',
                f'object "{thing.name}" has other triangles than when it was picked: followed by its place',
            )
        return followed.world_point


def _originals(evaluated: Any, originals: Any) -> dict[Any, Any]:  # noqa: ANN401  collections of one type
    """Of each evaluated item; by name, where a script has added some or removed them and tagged nothing."""
    if len(evaluated) == len(originals):
        return dict(zip(evaluated, originals, strict=True))
    return {item: originals[item.name] for item in evaluated if item.name in originals}


def _culprit(tree: bpy.types.NodeTree) -> str:
    return f'Transfer function "{tree.name}"'


def _ramp(layer: TyndallTransferLayer) -> tuple[Rgba, ...]:
    ramp = ramp_of(layer)
    if ramp is None:
        raise _CannotBeUsed(f'its ramp, node "{layer.ramp_node}", was removed or renamed')
    return tuple(tuple(ramp.evaluate(index / (RAMP_SAMPLES - 1))) for index in range(RAMP_SAMPLES))
