// SPDX-License-Identifier: GPL-3.0-or-later
// Evaluation of a material's surface program at a point: a short list of operations on colour registers.
#pragma once
#include "shading/program_point.hpp"
#include "shading/transparent_operations.hpp"
#include <span>

namespace tyndall {
struct Lobe; // lobes/lobe.hpp
/// Registers a program may name: 0 to 63, so that the live ones fit into one word.
inline constexpr std::size_t surface_register_count = 64;

/// Throws InvalidInput that names the material: a register, texture or UV map out of range, a non-finite constant.
void validate(const Material& material);

/// The closures of a validated material. uvs[i] is the value of material.uv_map_names[i] at the point. Appends its lobes
/// to `lobes`; without such a list they count as diffuse.
[[nodiscard]] SurfaceClosures evaluate(const Material& material, const ProgramPoint& point, std::span<const vec2> uvs,
                                       std::vector<Lobe>* lobes = nullptr);

/// SurfaceClosures::transparent alone. `operations` are the same material's.
[[nodiscard]] Rgb evaluate_transparent(const Material& material, const TransparentOperations& operations,
                                       const ProgramPoint& point, std::span<const vec2> uvs);
/// The same where every image has this value, and nothing but images and the facing is read.
[[nodiscard]] Rgb evaluate_transparent(const Material& material, const TransparentOperations& operations,
                                       const vec4& image_value, bool is_backface);

/// What an operation reads of images, UV maps or its point, at each of several points.
struct Answer {
    std::uint16_t place = 0; ///< In Material::program.
    std::span<const Rgb> values;
};
/// What a register holds in the end at each of several points; throws InvalidInput where an operation reads more than
/// operands and tables, and has no answer, or one for another number of points.
void run_on_answers(const Material& material, std::uint16_t result, std::span<const Answer> answers,
                    std::span<Rgb> values);

/// SurfaceClosures::transparent may differ between channels; false only if it never does.
[[nodiscard]] bool has_coloured_transparency(const Material& material);

/// No light passes, whatever the program reads: shadow rays may stop without looking.
[[nodiscard]] bool is_opaque_everywhere(const Material& material);
/// All light passes: there is no surface, or one that is transparent by a constant.
[[nodiscard]] bool is_transparent_everywhere(const Material& material);
/// What a material whose emission is constant emits as a light; see ProgramPoint. No more than 1e18.
[[nodiscard]] Rgb constant_emission(const Material& material);
/// No light is emitted, whatever the program reads.
[[nodiscard]] bool glows_nowhere(const Material& material);
} // namespace tyndall
