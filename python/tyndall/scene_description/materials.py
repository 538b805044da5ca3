# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces: programs, and the lobes, gloss and displacement that they feed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from .arrays import Rgb
from .images import Extension, Image, Interpolation


class Code(IntEnum):
    """Operations of a surface program; native/shading/material.hpp says what each computes."""

    CONSTANT = 0
    TEXTURE = 1
    TEXTURE_ALPHA = 2
    MULTIPLY = 3
    ADD = 4
    SUBTRACT = 5
    MIX = 6
    CLAMP = 7
    AVERAGE = 8
    BACKFACING = 9
    UV = 10
    MATH = 11
    VECTOR_MATH = 12
    MAP_RANGE = 13
    VECTOR_ROTATE = 14
    AFFINE = 15
    CURVE = 20
    HUE_SATURATION = 21
    GAMMA = 22
    BLEND = 23
    COMBINE = 24
    SEPARATE = 25
    INPUT = 30
    FRESNEL = 31
    LAYER_WEIGHT = 32
    NORMAL_MAP = 33
    BUMP = 34
    NOISE = 40
    VORONOI = 41
    WAVE = 42
    MAGIC = 43
    GRADIENT = 44
    CHECKER = 45
    BRICK = 46
    MUSGRAVE = 47
    WHITE_NOISE = 48
    GABOR = 49
    IMAGE_AT = 60
    IMAGE_ALPHA_AT = 61
    ENVIRONMENT_AT = 62
    PHOTOMETRY = 63
    AMBIENT_OCCLUSION = 70
    BEVEL = 71


@dataclass(frozen=True, kw_only=True, eq=False)
class TextureUse:
    """One image as one node uses it."""

    image: Image
    extension: Extension = Extension.REPEAT
    interpolation: Interpolation = Interpolation.LINEAR


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceOp:
    """One step of a surface program: ``register[out] = code(register[a], …, register[f])``."""

    code: Code
    out: int
    a: int = 0
    b: int = 0
    c: int = 0
    d: int = 0
    e: int = 0
    f: int = 0
    option: int = 0  #: Which of the operation's kinds.
    selector: int = 0  #: Which of its results.
    texture: int = 0  #: Into Material.textures.
    uv_map: int = 0  #: Into Material.uv_maps.
    table: int = 0  #: Into Material.tables.
    shift: int = 0  #: Where positions and UV maps are read: 0 at the point, 1 and 2 half a pixel beside it.
    value: Rgb = (0.0, 0.0, 0.0)
    uv_matrix: tuple[float, ...] = (1, 0, 0, 0, 1, 0, 0, 0, 1)  #: 3x3, row by row, applied to (u, v, 1).


@dataclass(frozen=True, kw_only=True, eq=False)
class Gloss:
    """What mirrors of a surface: shares of what comes along the mirrored ray. Weights already carry mix factors."""

    facing: Rgb = (0.0, 0.0, 0.0)  #: Seen straight; constants, used while the material's program is empty.
    edge: Rgb = (0.0, 0.0, 0.0)  #: At a grazing angle. A plain mirror has the same here; a metal 1.
    coat: Rgb = (0.0, 0.0, 0.0)  #: Weight of a clear layer, which mirrors by Fresnel's equations.
    coated: Rgb = (0.0, 0.0, 0.0)  #: Diffuse colour below that layer, in the light that it lets in.
    registers: tuple[int, int, int, int] = (0, 0, 0, 0)  #: Of these four.
    mirror_ior: float = 0.0  #: By which facing rises to edge: as a dielectric of that index, or, for 0, as metals.
    coat_ior: float = 1.5  #: Of the clear layer, at least 1.


class LobeModel(IntEnum):
    """A shader that is more than a diffuse share; its inputs are listed in native/shading/lobes/lobe_source.hpp."""

    OREN_NAYAR_3 = 0
    OREN_NAYAR = 1
    TRANSLUCENT = 2
    GLOSSY_3 = 3
    GLOSSY = 4
    METAL_F82 = 5
    CONDUCTOR = 6
    GLASS_3 = 7
    GLASS = 8
    VELVET = 9
    DIFFUSE_TOON = 10
    GLOSSY_TOON = 11
    PRINCIPLED_3 = 12
    PRINCIPLED = 13
    LAMBERT = 14
    PRINCIPLED_SHEEN = 15
    SHEEN = 16
    HAIR_OF_COLOUR = 17
    HAIR_OF_MELANIN = 18
    HAIR_OF_ABSORPTION = 19
    HAIR_REFLECTION = 20
    HAIR_TRANSMISSION = 21
    BENT_GLASS_3 = 22
    BENT_GLASS = 23
    REFRACTION = 24
    SUBSURFACE = 25
    PRINCIPLED_SUBSURFACE = 26
    PRINCIPLED_3_SUBSURFACE = 27


class BumpShadowing(IntEnum):
    """What bumps take from light that comes in flat; see native/shading/lobes/bump_shadowing.hpp."""

    NONE = 0
    SMOOTH = 1
    FACETS = 2


class SubsurfaceMethod(IntEnum):
    """How light gets from where it is seen to where it came in; see native/shading/lobes/subsurface.hpp."""

    NONE = 0
    PROFILE = 1
    COSINE_WALK = 2
    COSINE_SKIN_WALK = 3
    REFRACTED_WALK = 4
    SKIN_WALK = 5


class FacetDistribution(IntEnum):
    """How the normals of microfacets spread; see native/shading/lobes/lobe_source.hpp."""

    GGX = 0
    BECKMANN = 1
    ASHIKHMIN_SHIRLEY = 2


@dataclass(frozen=True, kw_only=True, eq=False)
class FilmSpectra:
    """What the channels see of light that went a longer way; see native/shading/lobes/thin_film.hpp."""

    #: (n, 6), at even steps from no way to ``reach_nm``: red, green and blue of the cosine, then of the sine.
    seen: NDArray[np.float32]
    reach_nm: float
    fades_below_nm: float = 1.0  #: Thinner films have an index between theirs and that of air.
    covers_metals: bool = True  #: Of Principled: its metal has the film, too.


@dataclass(frozen=True, kw_only=True, eq=False)
class Lobes:
    """What one shader of a surface does beside Material's results. The first input is its share of the surface."""

    model: LobeModel
    inputs: tuple[Rgb, ...]  #: Numbers have three equal channels.
    registers: tuple[int, ...]  #: Of each input; below 0 the input itself counts.
    preserves_energy: bool = False  #: What microfacets hide from one another comes back, too.
    #: Registers of unit normals: of what is diffuse, of microfacets, of a coat; below 0 the point's own.
    normals: tuple[int, int, int] = (-1, -1, -1)
    bump_shadowing: BumpShadowing = BumpShadowing.NONE  #: Of what is diffuse around such a normal.
    subsurface: SubsurfaceMethod = SubsurfaceMethod.NONE  #: Of models that scatter below the surface.
    distribution: FacetDistribution = FacetDistribution.GGX
    #: Register of what facets are wide along, as long as the root of how much wider than across; below 0: nothing.
    tangent: int = -1
    #: Of microfacets and coats without a normal of their own: until a mirror would not look into the surface.
    turns_smooth_normals: bool = True
    #: A thin film over its facets, whose thickness in nanometres and index are the last two inputs.
    film: FilmSpectra | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Material:
    """A surface program with three results, or three constants; and the medium inside, if any."""

    name: str
    has_surface: bool = True  #: False: light and view pass through (a fog box).
    diffuse: Rgb = (0.8, 0.8, 0.8)  #: Constants, used while ``program`` is empty.
    transparent: Rgb = (0.0, 0.0, 0.0)
    emission: Rgb = (0.0, 0.0, 0.0)
    held_out: float = 0.0  #: Share that is cut out of what cameras see: neither light nor cover.
    program: tuple[SurfaceOp, ...] = ()
    diffuse_register: int = 0
    transparent_register: int = 0
    emission_register: int = 0
    held_out_register: int | None = None  #: None: a program that holds out nothing.
    textures: tuple[TextureUse, ...] = ()
    uv_maps: tuple[str, ...] = ()  #: Names the program reads; "" is the active one.
    tables: tuple[NDArray[np.float32], ...] = ()  #: (steps, 4) each, RGBA over [0, 1].
    gloss: Gloss | None = None  #: What it mirrors; None: nothing.
    lobes: tuple[Lobes, ...] = ()
    #: Passes that it fills, by name: what programs of their own emit.
    aovs: tuple[tuple[str, Material], ...] = ()
    displacement: Displacement | None = None  #: Sync has moved the meshes by it already.
    medium: int = -1  #: Into SceneDescription.media; -1: none.


@dataclass(frozen=True, kw_only=True, eq=False)
class Displacement:
    """How a material moves the vertices of its meshes, see displacement.py."""

    program: Material  #: What it emits is by how much, in the world.
    keeps_normals: bool = False  #: Those of before: a bump makes the surface's.
