# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of light by what sends it to the camera, and of its colour: those that Cycles has by the same names."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LightPass:
    plane: str  #: Of the film; the pass's name, too, up to Blender 4.5.
    kind: str  #: What sends the light.
    part: str  #: Which of it.
    description: str

    @property
    def name(self) -> str:
        """Of the pass from Blender 5.0 on."""
        return f"{self.kind} {self.part}"

    @property
    def switch(self) -> str:
        """Of the view layer."""
        return f"use_pass_{self.kind}_{self.part}".lower()


LIGHT_PASSES = tuple(
    LightPass(short_kind + short_part, kind, part, description)
    for short_kind, kind in (("Diff", "Diffuse"), ("Gloss", "Glossy"), ("Trans", "Transmission"))
    for short_part, part, description in (
        ("Dir", "Direct", "Light that comes straight from lamps, world and what glows, without the surface's colour"),
        ("Ind", "Indirect", "Light that has met other surfaces before, without the surface's colour"),
        ("Col", "Color", "Share of even light that the surface sends to the camera"),
    )
)
