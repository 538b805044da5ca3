# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes: which a view layer asks for, under the names of the running version, and how pixels reach them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.light_paths import COLOUR_OF, is_light, without_colour

from ..light_passes import LIGHT_PASSES
from ..sync.object_lighting import light_groups

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bpy.types import AOV, RenderEngine, RenderLayer, Scene, ViewLayer
    from numpy.typing import NDArray

_HAS_LONG_NAMES = bpy.app.version >= (5, 0, 0)


@dataclass(frozen=True)
class _Pass:
    plane: str  #: Name in the film.
    name: str  #: Name in Blender.
    channels: str
    kind: str  #: Of its socket: COLOR, VECTOR or VALUE.
    switch: str  #: Property of the view layer; with a dot, of its Tyndall settings.


def _of_cycles(plane: str, short_name: str, long_name: str, switch: str) -> _Pass:
    """Named as the running version does."""
    return _Pass(plane, long_name if _HAS_LONG_NAMES else short_name, "RGB", "COLOR", switch)


_PASSES = (
    _Pass("Combined", "Combined", "RGBA", "COLOR", ""),
    _Pass("Depth", "Depth", "Z", "VALUE", "use_pass_z"),
    _Pass("Position", "Position", "XYZ", "VECTOR", "use_pass_position"),
    _Pass("Normal", "Normal", "XYZ", "VECTOR", "use_pass_normal"),
    _Pass("Mist", "Mist", "Z", "VALUE", "use_pass_mist"),
    _Pass("Vector", "Vector", "XYZW", "VECTOR", "use_pass_vector"),
    _Pass("UV", "UV", "UVA", "VECTOR", "use_pass_uv"),
    _Pass("IndexOB", "Object Index" if _HAS_LONG_NAMES else "IndexOB", "X", "VALUE", "use_pass_object_index"),
    _Pass("IndexMA", "Material Index" if _HAS_LONG_NAMES else "IndexMA", "X", "VALUE", "use_pass_material_index"),
    *(_of_cycles(each.plane, each.plane, each.name, each.switch) for each in LIGHT_PASSES),
    _of_cycles("Shafts", "VolumeDir", "Volume Direct", "cycles.use_pass_volume_direct"),
    _of_cycles("Emit", "Emit", "Emission", "use_pass_emit"),
    _of_cycles("Env", "Env", "Environment", "use_pass_environment"),
    _of_cycles("AO", "AO", "Ambient Occlusion", "use_pass_ambient_occlusion"),
    _Pass("Shadow", "Shadow", "RGB", "COLOR", "use_pass_shadow"),
    _Pass("Shadow Catcher", "Shadow Catcher", "RGB", "COLOR", "tyndall.use_pass_shadow_catcher"),
    _Pass("Shafts", "Shafts", "RGB", "COLOR", "tyndall.use_pass_shafts"),
    _Pass("Shafts Visibility", "Shafts Visibility", "X", "VALUE", "tyndall.use_pass_shafts_visibility"),
    _Pass("Transmittance", "Transmittance", "RGB", "COLOR", "tyndall.use_pass_transmittance"),
    _Pass("Debug Sample Count", "Debug Sample Count", "X", "VALUE", "tyndall.use_pass_sample_count"),
    _Pass("Denoising Normal", "Denoising Normal", "XYZ", "VECTOR", "tyndall.use_pass_denoising_data"),
    _Pass("Denoising Albedo", "Denoising Albedo", "RGB", "COLOR", "tyndall.use_pass_denoising_data"),
    _Pass("Denoising Depth", "Denoising Depth", "Z", "VALUE", "tyndall.use_pass_denoising_data"),
)
#: Mattes by what they tell apart, with the switch of the view layer.
_MATTES = {
    "CryptoObject": "use_pass_cryptomatte_object",
    "CryptoMaterial": "use_pass_cryptomatte_material",
    "CryptoAsset": "use_pass_cryptomatte_asset",
}
_PLANE_OF = {render_pass.name: render_pass.plane for render_pass in _PASSES}


def register_passes(engine: RenderEngine, scene: Scene, view_layer: ViewLayer) -> None:
    """Tells Blender which passes a render will have, so that the compositor shows their sockets."""
    for render_pass in _enabled(view_layer):
        channels = render_pass.channels
        engine.register_pass(scene, view_layer, render_pass.name, len(channels), channels, render_pass.kind)


def wanted_planes(view_layer: ViewLayer) -> frozenset[str]:
    """The planes of the film that the view layer's passes show; of mattes, all of a kind under its name."""
    shown = {render_pass.plane for render_pass in _switched_on(view_layer)}
    colours = {COLOUR_OF[plane] for plane in shown & COLOUR_OF.keys()}
    return frozenset(shown | colours).union(matte_kinds(view_layer))


def matte_kinds(view_layer: ViewLayer) -> list[str]:
    """What the view layer's Cryptomattes tell apart."""
    return [kind for kind, switch in _MATTES.items() if getattr(view_layer, switch)]


def valid_aovs(view_layer: ViewLayer) -> list[AOV]:
    """Those whose names no other pass has."""
    return [aov for aov in view_layer.aovs if aov.is_valid]


def matte_ranks(view_layer: ViewLayer) -> int:
    """How many names a pixel's mattes tell apart; two have a place in a pass."""
    return min(16, view_layer.pass_cryptomatte_depth)


def film_exposure(scene: Scene) -> float:
    """What Cycles multiplies its light by on the film, before any view of it; its add-on keeps it."""
    of_cycles = getattr(scene, "cycles", None)
    return 1.0 if of_cycles is None else of_cycles.film_exposure


def exposed(rgba: NDArray[np.float32], exposure: float) -> NDArray[np.float32]:
    """(height, width, channels) of light; alpha, if it has any, stays."""
    if exposure == 1.0:
        return rgba
    result = rgba.copy()
    result[..., :3] *= exposure
    return result


def write(layer: RenderLayer, planes: Mapping[str, NDArray[np.float32]], exposure: float = 1.0) -> None:
    """Copies planes, (height, width, channels) from bottom to top, into a layer of Blender's result.

    One call for all passes: ``pass.rect = array`` takes 0.9 to 2.2 s for a full HD pass, this takes 0.004 s.
    """
    shown = {name: exposed(plane, exposure) if is_light(name) else plane for name, plane in planes.items()}
    for name in shown.keys() & COLOUR_OF.keys():
        shown[name] = without_colour(shown[name], planes[COLOUR_OF[name]])
    layer.passes.foreach_set("rect", np.concatenate([_pixels(render_pass, shown) for render_pass in layer.passes]))


def _pixels(render_pass: bpy.types.RenderPass, planes: Mapping[str, NDArray[np.float32]]) -> NDArray[np.float32]:
    plane = planes.get(_PLANE_OF.get(render_pass.name, render_pass.name))
    height, width, _ = planes["Combined"].shape
    if plane is None:  # a pass that another engine left switched on
        return np.zeros(height * width * render_pass.channels, np.float32)
    return np.ascontiguousarray(plane, np.float32).reshape(-1)


def _enabled(view_layer: ViewLayer) -> list[_Pass]:
    names = (
        f"{kind}{index:02d}" for kind in matte_kinds(view_layer) for index in range((matte_ranks(view_layer) + 1) // 2)
    )
    # Lower case keeps lossy compression of OpenEXR off: it would break ids.
    mattes = [_Pass(name, name, "rgba", "COLOR", "") for name in names]
    aovs = [
        _Pass(aov.name, aov.name, "RGBA" if aov.type == "COLOR" else "X", aov.type, "")
        for aov in valid_aovs(view_layer)
    ]
    return [*_switched_on(view_layer), *mattes, *aovs, *_of_light_groups(view_layer)]


def _of_light_groups(view_layer: ViewLayer) -> list[_Pass]:
    """Named as Cycles does; and the shafts of each where those of all are asked for."""
    kinds = ["Combined", "Shafts"] if _is_on(view_layer, "tyndall.use_pass_shafts") else ["Combined"]
    names = (f"{kind}_{group}" for group in light_groups(view_layer) for kind in kinds)
    return [_Pass(name, name, "RGB", "COLOR", "") for name in names]


def _switched_on(view_layer: ViewLayer) -> list[_Pass]:
    return [render_pass for render_pass in _PASSES if _is_on(view_layer, render_pass.switch)]


def _is_on(view_layer: ViewLayer, switch: str) -> bool:
    if not switch:
        return True
    group, _, name = switch.rpartition(".")
    owner = getattr(view_layer, group, None) if group else view_layer  # Cycles may be switched off
    return bool(getattr(owner, name, False))
