// SPDX-License-Identifier: GPL-3.0-or-later
// What painting, noise and wind amount to at one moment inside of the painted box, as one number per voxel.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.3: "the noise and blending volumes can be baked into one".
// Differs:  noise that is finer than the voxels is left out: it is looked up in the mip level whose texels are as large,
//           or in both that it lies between. Levels are box-filtered, and so what is baked has the mean of the noise.
// Bound:    4 looks at the air and 4 bytes per voxel.
#pragma once
#include "core/progress.hpp"
#include "volume/air_texture.hpp"
#include <array>
#include <vector>

namespace tyndall {
/// Relative to homogeneous air, at voxel centres, x fastest: sample i of n lies at (i + 0.5) / n of the painted box.
/// Throws InvalidInput if there are no voxels, or if the box is flat, and Cancelled.
[[nodiscard]] std::vector<float> bake_air(const AirTexture& air, const std::array<std::uint32_t, 3>& size,
                                          const Progress& progress);
} // namespace tyndall
