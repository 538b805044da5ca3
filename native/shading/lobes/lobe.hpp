// SPDX-License-Identifier: GPL-3.0-or-later
// What a surface sends back of light from one direction, beside Lambert's share: a few lobes at a point, each ready for
// any direction. Formulas are apart, one file per model.
#pragma once
#include "core/math.hpp"
#include "shading/lobes/bump_shadowing.hpp"
#include <cstdint>
#include <vector>

namespace tyndall {
struct Lobe {
    enum class Kind : std::uint8_t {
        Lambert, ///< Around a normal of its own; else it is among SurfaceClosures.
        OrenNayar,
        Burley,
        BurleySheen,
        Sheen,
        DiffuseToon,
        Velvet,
        GlossyToon,
        Ggx,
        Clearcoat,
    };
    /// How a microfacet reflects: all of it; from `a` to `b` as a dielectric of index `ior` rises from its own share to 1;
    /// from `a` as metals do, darkened by `b` (see fresnel_f82); as a conductor of index a + i b.
    enum class Fresnel : std::uint8_t { None, Dielectric, F82, Conductor };
    Kind kind = Kind::Ggx;
    Fresnel fresnel = Fresnel::None;
    bool is_separable = false;                          ///< Ggx: shadowing and masking are apart, as up to Blender 3.x.
    BumpShadowing bump_shadowing = BumpShadowing::None; ///< With a normal of its own.
    /// Ggx, Clearcoat: width, (0, 1]. OrenNayar: its A. Burley: roughness. Velvet: 1 / sigma^2. Toon: angle of full light.
    /// Sheen: its a.
    float alpha = 1.0f;
    float own_alpha = 1.0f; ///< Ggx, Clearcoat: before it was made as wide as directions can be drawn.
    float ior = 1.5f;       ///< OrenNayar: its B. Sheen: its b. Toon: angle over which light fades.
    float sampling = 0.0f;  ///< Share of directions that are drawn for it; shares need not add up to 1.
    Rgb weight{0.0f};
    Rgb a{0.0f}, b{1.0f}; ///< Of `fresnel`. OrenNayar: b is what scatters on between facets.
    vec3 normal{0.0f};    ///< Its own, unit; zero: the point's.

    /// Cycles counts it among what is diffuse.
    [[nodiscard]] bool is_diffuse() const { return kind <= Kind::Velvet; }
    /// It is seen from every side, and bumps shadow it.
    [[nodiscard]] bool is_matte() const { return kind <= Kind::DiffuseToon; }
    [[nodiscard]] bool has_own_normal() const { return normal != vec3(0.0f); }
};
using Lobes = std::vector<Lobe>;
} // namespace tyndall
