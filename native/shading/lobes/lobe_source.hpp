// SPDX-License-Identifier: GPL-3.0-or-later
// A shader that becomes lobes at a point: which it is, and where its inputs come from.
#pragma once
#include "core/math.hpp"
#include "shading/lobes/bump_shadowing.hpp"
#include "shading/lobes/subsurface.hpp"
#include "shading/lobes/thin_film.hpp"
#include <cstdint>
#include <memory>
#include <vector>

namespace tyndall {
enum class LobeModel : std::uint8_t; // lobe_models.hpp
/// Of what Glossy, metals and what glass reflects are made of; coats and Principled have GGX.
enum class FacetDistribution : std::uint8_t {
    Ggx = 0,
    Beckmann = 1,
    AshikhminShirley = 2, ///< Of Glossy alone.
    Count = 3,
};

struct LobeSource {
    static constexpr std::uint16_t no_register = 0xffff; ///< The constant counts.
    LobeModel model{};
    /// What facets hide from one another comes back, too; scales of hair tilt what is seen without a loss.
    bool preserves_energy = false;
    SubsurfaceMethod subsurface = SubsurfaceMethod::None; ///< Of models that scatter below the surface.
    FacetDistribution distribution = FacetDistribution::Ggx;
    std::vector<Rgb> constants = {};
    std::vector<std::uint16_t> registers = {}; ///< As many.
    /// Where the unit normals are of what is diffuse, of facets, and of a coat; no_register: the point's own.
    std::uint16_t diffuse_normal = no_register, facet_normal = no_register, coat_normal = no_register;
    /// Where LobeNormals::tangent is; no_register: facets are as wide along as across.
    std::uint16_t tangent = no_register;
    /// Facets and coats that have the point's own normal, a smooth one, have it turned until a mirror would not look into
    /// the surface.
    bool turns_smooth_normals = true;
    BumpShadowing bump_shadowing = BumpShadowing::None; ///< Of what is diffuse around such a normal.
    std::shared_ptr<const FilmSpectra> film = {};       ///< Nothing: no thin film covers its facets.
    bool operator==(const LobeSource&) const = default;
};
} // namespace tyndall
