# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials in native memory."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from . import _native
from .surface_operations import build_op

if TYPE_CHECKING:
    from .scene_description import FilmSpectra, Gloss, Material


def build_material(material: Material, textures: list[_native.Texture]) -> _native.Material:
    """One ``textures`` per use of an image. Raises InvalidInput that says what cannot be."""
    return _native.Material(
        name=material.name,
        has_surface=material.has_surface,
        diffuse=material.diffuse,
        transparent=material.transparent,
        emission=material.emission,
        program=[build_op(op) for op in material.program],
        diffuse_register=material.diffuse_register,
        transparent_register=material.transparent_register,
        emission_register=material.emission_register,
        held_out=material.held_out,
        held_out_register=material.held_out_register,
        textures=textures,
        uv_maps=material.uv_maps,
        tables=material.tables,
        gloss=None if material.gloss is None else _build_gloss(material.gloss),
        lobes=[
            _native.Lobes(
                model=int(lobes.model),
                preserves_energy=lobes.preserves_energy,
                constants=lobes.inputs,
                registers=lobes.registers,
                normals=lobes.normals,
                bump_shadowing=int(lobes.bump_shadowing),
                subsurface=int(lobes.subsurface),
                distribution=int(lobes.distribution),
                tangent=lobes.tangent,
                turns_smooth_normals=lobes.turns_smooth_normals,
                film=None if lobes.film is None else _build_film(lobes.film),
            )
            for lobes in material.lobes
        ],
        medium=material.medium,
    )


@lru_cache(maxsize=4)
def _build_film(film: FilmSpectra) -> _native.FilmSpectra:
    """The same for all materials: two are equal where their films are one."""
    return _native.FilmSpectra(film.seen, film.reach_nm, film.fades_below_nm, film.covers_metals)


def _build_gloss(gloss: Gloss) -> _native.Gloss:
    return _native.Gloss(
        constant=(gloss.facing, gloss.edge, gloss.coat, gloss.coated),
        registers=gloss.registers,
        mirror_ior=gloss.mirror_ior,
        coat_ior=gloss.coat_ior,
    )
