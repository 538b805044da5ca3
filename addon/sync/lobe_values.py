# SPDX-License-Identifier: GPL-3.0-or-later
"""A shader with lobes on its way to tyndall.scene_description.Lobes: what is known now, and what a program tells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tyndall.scene_description import (
    BumpShadowing,
    FacetDistribution,
    FilmSpectra,
    LobeModel,
    Lobes,
    SubsurfaceMethod,
)

from .program import BLACK, Term, Value

if TYPE_CHECKING:
    from collections.abc import Callable


@dataclass(frozen=True)
class LobeNormals:
    """Unit normals of a shader's lobes; None: the point's own."""

    diffuse: Value | None = None
    facets: Value | None = None
    coat: Value | None = None
    bump_shadowing: BumpShadowing = BumpShadowing.NONE
    turns_smooth_ones: bool = True  #: See tyndall.scene_description.Lobes.

    def all(self) -> tuple[Value | None, Value | None, Value | None]:
        return self.diffuse, self.facets, self.coat


@dataclass(frozen=True)
class Facets:
    """How those of a shader's gloss lie."""

    distribution: FacetDistribution = FacetDistribution.GGX
    tangent: Term | None = None  #: See tyndall.scene_description.Lobes; None: they are as wide along as across.


@dataclass(frozen=True)
class Film:
    """A thin film over a shader's facets."""

    spectra: FilmSpectra
    thickness_nm: Value
    ior: Value


@dataclass(frozen=True)
class LobeValues:
    """A shader with lobes, see tyndall.scene_description.Lobes."""

    model: LobeModel
    inputs: tuple[Value, ...]
    preserves_energy: bool = False
    normals: LobeNormals = LobeNormals()
    subsurface: SubsurfaceMethod = SubsurfaceMethod.NONE
    facets: Facets = Facets()
    film: Film | None = None

    def _all_inputs(self) -> tuple[Value, ...]:
        return self.inputs if self.film is None else (*self.inputs, self.film.thickness_nm, self.film.ior)

    def terms(self) -> list[Term]:
        values = (*self._all_inputs(), *self.normals.all(), self.facets.tangent)
        return [value for value in values if isinstance(value, Term)]

    def constant(self, register_of: Callable[[Term], int]) -> Lobes:
        def normal(value: Value | None) -> int:
            return register_of(value) if isinstance(value, Term) else -1

        (diffuse, facets, coat), inputs = self.normals.all(), self._all_inputs()
        return Lobes(
            model=self.model,
            inputs=tuple(BLACK if isinstance(value, Term) else value for value in inputs),
            registers=tuple(register_of(value) if isinstance(value, Term) else -1 for value in inputs),
            preserves_energy=self.preserves_energy,
            normals=(normal(diffuse), normal(facets), normal(coat)),
            bump_shadowing=self.normals.bump_shadowing,
            subsurface=self.subsurface,
            distribution=self.facets.distribution,
            tangent=-1 if self.facets.tangent is None else register_of(self.facets.tangent),
            turns_smooth_normals=self.normals.turns_smooth_ones,
            film=None if self.film is None else self.film.spectra,
        )
