// SPDX-License-Identifier: GPL-3.0-or-later
// Shaders made into lobes, Lambert's share, and what passes, for one direction of view.
// Based on: Burley, Physically Based Shading at Disney, SIGGRAPH 2012 course notes (the principled shader up to Blender
//           3.x); from 4.0 on its layers: each leaves to those below what its albedo is short of 1; Kulla and Conty,
//           SIGGRAPH 2017 course notes (what facets hide from one another).
// Differs:  anisotropic facets are as wide along as across; glass is what it reflects, and for the rest transparent, but
//           for the three models that bend rays: for light these are the same, to rays that are followed a Lobe::Kind::Bent.
#pragma once
#include "shading/lobes/lobe.hpp"
#include "shading/lobes/lobe_source.hpp"
#include <array>
#include <string>

namespace tyndall {
struct ShadingPoint;
struct SurfaceClosures;

/// Each with its inputs after the first, which is the share of the surface that it has; numbers have three equal
/// channels.
enum class LobeModel : std::uint8_t {
    OrenNayar3 = 0,   ///< Up to Blender 3.x: colour, roughness.
    OrenNayar = 1,    ///< colour, roughness.
    Translucent = 2,  ///< colour.
    Glossy3 = 3,      ///< Shadowing and masking apart: colour, roughness.
    Glossy = 4,       ///< colour, roughness.
    MetalF82 = 5,     ///< straight, roughness, edge tint.
    Conductor = 6,    ///< n, roughness, k.
    Glass3 = 7,       ///< What it reflects, and less of what is transparent: colour, roughness, index.
    Glass = 8,        ///< colour, roughness, index.
    Velvet = 9,       ///< colour, sigma.
    DiffuseToon = 10, ///< colour, size, smooth.
    GlossyToon = 11,  ///< colour, size, smooth.
    /// base, metallic, roughness, specular, specular tint, sheen, sheen tint, clearcoat, clearcoat roughness,
    /// transmission, index.
    Principled3 = 12,
    /// base, metallic, roughness, specular level, specular tint, transmission, index, coat, coat roughness, coat index,
    /// coat tint, diffuse roughness, emission.
    Principled = 13,
    Lambert = 14,         ///< Around a normal of its own: colour.
    PrincipledSheen = 15, ///< As Principled; the sheen's colour by its share of the surface, its roughness.
    Sheen = 16,           ///< colour, roughness.
    /// Principled Hair: colour, and of HairOfMelanin the tint, or absorption; melanin, redness, roughness, radial roughness,
    /// coat, index, offset in radians, the hair's number, how much that makes the colour and the roughness differ, along.
    HairOfColour = 17,
    HairOfMelanin = 18,
    HairOfAbsorption = 19,
    /// Hair BSDF: colour, offset in radians, roughness along, and around, along.
    HairReflection = 20,
    HairTransmission = 21,
    /// Sharp: colour of what it reflects, and of what it lets in; what Fresnel's share is multiplied by where the surface is
    /// seen straight; index.
    BentGlass3 = 22, ///< The first colour changes so towards the edge, and the rest that is let in does not.
    BentGlass = 23,  ///< Up to 1 at the edge, and the rest is let in.
    Refraction = 24, ///< Reflects nothing, and lets in all that is not totally reflected: colour, index.
    Subsurface = 25, ///< By the source's method: colour, radius, width of its facets, index, anisotropy.
    /// As PrincipledSheen; of what is diffuse the share that is below the surface, radius, index of skin, anisotropy.
    PrincipledSubsurface = 26,
    /// As Principled3; that share, by which the radius is multiplied, too, radius, index, anisotropy, and the colour of both.
    Principled3Subsurface = 27,
};
/// Rays go on behind it, elsewhere.
[[nodiscard]] constexpr bool bends_rays(LobeModel model) {
    return model == LobeModel::BentGlass3 || model == LobeModel::BentGlass || model == LobeModel::Refraction;
}
/// After them those of a thin film, where the source has one: its thickness in nanometres, its index.
[[nodiscard]] constexpr bool can_have_film(LobeModel model) {
    return model == LobeModel::MetalF82 || model == LobeModel::Conductor || model == LobeModel::Glass ||
           model == LobeModel::BentGlass || model == LobeModel::Principled || model == LobeModel::PrincipledSheen ||
           model == LobeModel::PrincipledSubsurface;
}
inline constexpr std::size_t most_lobe_inputs = 22, film_input_count = 2;
inline constexpr std::size_t principled_emission = 13; ///< Which of its inputs that is, with and without a sheen.
/// It is one of those whose layers dim what glows below them.
[[nodiscard]] constexpr bool has_emission(LobeModel model) {
    return model == LobeModel::Principled || model == LobeModel::PrincipledSheen ||
           model == LobeModel::PrincipledSubsurface;
}
using LobeInputs = std::array<Rgb, most_lobe_inputs>;
/// Unit normals of a shader's lobes at a point; zero: the point's own.
struct LobeNormals {
    vec3 diffuse{0.0f}, facets{0.0f}, coat{0.0f};
    vec3 outgoing{0, 0, 1}; ///< Unit, to the viewer: what own normals are seen at.
    /// Along which facets of Glossy, metals and Principled are wide, in any angle to their normal: its length is the root of
    /// how much wider than across. Zero, or along the normal: as wide along as across.
    vec3 tangent{0.0f};
};
/// How many inputs a model has, its share included; 0: there is no such model.
[[nodiscard]] std::size_t input_count(LobeModel model);
/// Throws InvalidInput that names the material; which registers there are is not looked at.
void validate(const LobeSource& source, const std::string& material_name);
/// Those that a shader reads, for inputs and normals.
[[nodiscard]] std::vector<std::uint16_t> registers_of(const LobeSource& source);

/// Adds what a shader does to the closures; its lobes to `lobes`, or, where there is no such list, to Lambert's share.
void add_lobes(const LobeSource& source, const LobeInputs& inputs, const ShadingPoint& point, SurfaceClosures& closures,
               Lobes* lobes, const LobeNormals& normals = {});
} // namespace tyndall
