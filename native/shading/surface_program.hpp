// SPDX-License-Identifier: GPL-3.0-or-later
// Evaluation of a material's surface program at a point: a short list of operations on colour registers.
#pragma once
#include "shading/program_point.hpp"
#include <span>

namespace tyndall {
/// Registers a program may name: 0 to 63, so that the live ones fit into one word.
inline constexpr std::size_t surface_register_count = 64;

/// Throws InvalidInput that names the material: a register, texture or UV map out of range, a non-finite constant.
void validate(const Material& material);

/// The closures of a validated material. uvs[i] is the value of material.uv_map_names[i] at the point.
[[nodiscard]] SurfaceClosures evaluate(const Material& material, const ProgramPoint& point, std::span<const vec2> uvs);

/// SurfaceClosures::transparent alone: runs only the operations that it depends on, for shadow rays.
[[nodiscard]] Rgb evaluate_transparent(const Material& material, const ProgramPoint& point, std::span<const vec2> uvs);

/// The same where every image has this value.
[[nodiscard]] Rgb evaluate_transparent(const Material& material, const vec4& image_value, bool is_backface);
/// Operations of the program that SurfaceClosures::transparent depends on, in their order.
[[nodiscard]] std::vector<const SurfaceOp*> operations_of_transparent(const Material& material);
/// SurfaceClosures::transparent may differ between channels; false only if it never does.
[[nodiscard]] bool has_coloured_transparency(const Material& material);

/// No light passes, whatever the program reads: shadow rays may stop without looking.
[[nodiscard]] bool is_opaque_everywhere(const Material& material);
/// All light passes: there is no surface, or one that is transparent by a constant.
[[nodiscard]] bool is_transparent_everywhere(const Material& material);
/// No light is emitted, whatever the program reads.
[[nodiscard]] bool glows_nowhere(const Material& material);
} // namespace tyndall
