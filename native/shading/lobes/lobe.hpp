// SPDX-License-Identifier: GPL-3.0-or-later
// What a surface sends back of light from one direction, beside Lambert's share: a few lobes at a point, each ready for
// any direction. Formulas are apart, one file per model.
#pragma once
#include "core/math.hpp"
#include "shading/lobes/bump_shadowing.hpp"
#include "shading/lobes/subsurface.hpp"
#include "shading/lobes/thin_film.hpp"
#include <cstdint>
#include <vector>

namespace tyndall {
struct Lobe {
    enum class Kind : std::uint8_t {
        Lambert, ///< Around a normal of its own; else it is among SurfaceClosures.
        OrenNayar,
        Burley,
        BurleyRetro, ///< Of Burley's what comes back the way it came: what is left where his Lambert's share goes inside.
        BurleySheen,
        Sheen,
        DiffuseToon,
        Velvet,
        GlossyToon,
        Ggx,
        Clearcoat,
        GgxAlongTangent, ///< This and the next two: see framed_facets.hpp.
        Beckmann,
        AshikhminShirley,
        Bent,       ///< Sharp glass: no lobe of a LobeSet, but rays that go on. See take_apart().
        Subsurface, ///< Below the surface: no lobe of a LobeSet, but where light leaves it elsewhere. See take_apart().
        Fibre,      ///< One of a Principled Hair's: `normal` is along the fibre, as in the two below. See fibre.hpp.
        FibreReflection,
        FibreTransmission,
    };
    /// How a microfacet reflects: all of it; from `a` to `b` as a dielectric of index `ior` rises from its own share to 1;
    /// from `a` as metals do, darkened by `b` (see fresnel_f82); as a conductor of index a + i b.
    enum class Fresnel : std::uint8_t { None, Dielectric, F82, Conductor };
    Kind kind = Kind::Ggx;
    Fresnel fresnel = Fresnel::None;
    /// As up to Blender 3.x. Ggx, Beckmann: shadowing and masking are apart. Fibre: its tilt is of the light's angle,
    /// not the viewer's.
    /// Subsurface: a Principled BSDF's, where light that comes in flat is dimmed.
    bool is_separable = false;
    BumpShadowing bump_shadowing = BumpShadowing::None; ///< With a normal of its own.
    SubsurfaceMethod subsurface = SubsurfaceMethod::None;
    /// Of facets: width, (0, 1], where `tangent` says that there are two the root of their product. OrenNayar: its A.
    /// Burley: roughness. Velvet: 1 / sigma^2. Toon: angle of full light.
    /// Sheen: its a. Subsurface: width of the facets that refract. Fibre: variance along. Its others: width along.
    float alpha = 1.0f;
    /// Of facets: before it was made as wide as directions can be drawn. Subsurface: its anisotropy.
    float own_alpha = 1.0f;
    /// OrenNayar: its B. Sheen: its b. Toon: angle over which light fades. Fibre: scale around, 0: even. Its others: width
    /// around. Bent: of what lies behind, over that of the viewer's side.
    float ior = 1.5f;
    float sampling = 0.0f; ///< Share of directions that are drawn for it; shares need not add up to 1.
    Rgb weight{0.0f};
    /// Of `fresnel`. Bent: a is what the mirrored ray's light counts, as `weight` does the bent one's. OrenNayar: b is what
    /// scatters on between facets. Subsurface: a is what subsurface::mean_free_path() says, b its albedo. Fibre: a is
    /// sine and cosine of its tilt, and phi of its middle, b is fibre::inverse_integrals. Its others: a.x is the angle
    /// by which their middle is off.
    Rgb a{0.0f}, b{1.0f};
    vec3 normal{0.0f};  ///< Its own, unit; zero: the point's.
    ThinFilm film = {}; ///< Of `fresnel`, which it changes: not of None.
    /// Of framed facets, across the normal: its length is the root of how much wider they are along it than across
    /// it. Zero: they are as wide along as across.
    vec3 tangent{0.0f};

    /// Cycles counts it among what is diffuse.
    [[nodiscard]] bool is_diffuse() const { return kind <= Kind::Velvet; }
    /// Bumps shadow it.
    [[nodiscard]] bool is_matte() const { return kind <= Kind::DiffuseToon; }
    /// It is seen from every side.
    [[nodiscard]] bool is_broad() const { return is_matte() && kind != Kind::BurleySheen && kind != Kind::Velvet; }
    [[nodiscard]] bool is_toon() const { return kind == Kind::DiffuseToon || kind == Kind::GlossyToon; }
    [[nodiscard]] bool is_of_facets() const { return kind >= Kind::Ggx && kind <= Kind::AshikhminShirley; }
    [[nodiscard]] bool is_anisotropic() const { return tangent != vec3(0.0f); }
    [[nodiscard]] bool is_framed() const { return kind >= Kind::GgxAlongTangent && kind <= Kind::AshikhminShirley; }
    /// It is lit from all around, whatever side is seen, and has a direction along the fibre in place of a normal.
    [[nodiscard]] bool is_of_fibre() const { return kind >= Kind::Fibre; }
    [[nodiscard]] bool has_own_normal() const { return normal != vec3(0.0f) && !is_of_fibre(); }
};
using Lobes = std::vector<Lobe>;

/// Moves those that bend rays from `lobes` to the end of `bent`, and what lies below the surface to that of `below`; most
/// points have neither.
void take_apart(Lobes& lobes, Lobes& bent, Lobes& below);
} // namespace tyndall
