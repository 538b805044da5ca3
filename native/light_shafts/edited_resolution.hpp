// SPDX-License-Identifier: GPL-3.0-or-later
// How fine the depth map of an edited light has to be: what a frame needs depends on its occluders, on what its edits
// leave of them, and on the air, so that it is measured.
// Based on: Richardson 1911: what changes from one resolution to its double tells the error of either.
// Differs:  texels that lie otherwise make another draw of errors, not the same ones with another sign: of a change d the
//           finer map has between d / sqrt(5), first order, and d / sqrt(2), none. It is taken to have d / sqrt(3), and to
//           fall with the resolution to the power of 3/4; a forest of leaves has 0.7 to 0.9.
// Error:    of a pilot: the target was kept to a quarter of it in all that was tried.
// Bound:    two maps, of a fourth and an eighth of what the error target may ask for at most, and 4,096 rays.
#pragma once
#include "light_shafts/prepared_lights.hpp"
#include <functional>

namespace tyndall::light_shafts {
/// The error target of one light sample's map that asks for `texels` per side, and the other way round.
[[nodiscard]] float error_target_of_map(float texels);
[[nodiscard]] float texels_of_map(float error_target);
/// No map has more texels per side unless an artist asks.
inline constexpr float most_texels_of_map = 8192.0f;

/// An edited light sample by a map of so many texels per side, neither more nor less.
using MakeEdited = std::function<std::unique_ptr<const Visibility>(std::uint32_t texels)>;
/// The error target that `beam` is to be prepared with, whose texels keep the light's relative RMS error within
/// `error_target` as far as `rays`, clipped to the media, can tell; never below it. Where they get no light, or where
/// 2,048 texels are enough anyway, it is error_target.
[[nodiscard]] float measured_error_target(const PreparedLights& prepared, const Beam& beam,
                                          std::span<const ViewRay> rays, float error_target, const MakeEdited& make);
} // namespace tyndall::light_shafts
