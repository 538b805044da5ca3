# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes that a rendered viewport can show in place of the picture."""

from __future__ import annotations

from dataclasses import dataclass

from .light_passes import LIGHT_PASSES


@dataclass(frozen=True)
class ViewportPass:
    identifier: str
    name: str
    plane: str  #: Of the film.
    description: str


VIEWPORT_PASSES = (
    ViewportPass("COMBINED", "Combined", "Combined", "The picture"),
    ViewportPass("EMISSION", "Emission", "Emit", "What glows and is seen straight"),
    ViewportPass("ENVIRONMENT", "Environment", "Env", "The world, where it is seen straight"),
    ViewportPass("AO", "Ambient Occlusion", "AO", "Share of the world that surfaces see"),
    *(
        ViewportPass(each.name.replace(" ", "_").upper(), each.name, each.plane, each.description)
        for each in LIGHT_PASSES
    ),
    ViewportPass("SHAFTS", "Shafts", "Shafts", "Light that media scatter towards the camera"),
    ViewportPass("SHAFTS_VISIBILITY", "Shafts Visibility", "Shafts Visibility", "Lit share of each ray in media"),
    ViewportPass("TRANSMITTANCE", "Transmittance", "Transmittance", "What media let through"),
    ViewportPass("POSITION", "Position", "Position", "Of surfaces, in the world"),
    ViewportPass("NORMAL", "Normal", "Normal", "Of surfaces, in the world, bumps included"),
    ViewportPass("UV", "UV", "UV", "Of the map for rendering"),
    ViewportPass("MIST", "Mist", "Mist", "0 near, 1 far, as the world's Mist Pass says"),
    ViewportPass("DENOISING_ALBEDO", "Denoising Albedo", "Denoising Albedo", "The colour that denoisers see"),
    ViewportPass("DENOISING_NORMAL", "Denoising Normal", "Denoising Normal", "The normal that denoisers see"),
)
PLANE_OF = {each.identifier: each.plane for each in VIEWPORT_PASSES}
