// SPDX-License-Identifier: GPL-3.0-or-later
// A density grid in a scene. The coefficients and the emission of its medium are those at density 1.
#pragma once
#include "volume/density_grid.hpp"
#include <memory>
#include <string>

namespace tyndall {
struct VolumeInstance {
    std::string name; ///< Of the object, for reports.
    std::shared_ptr<const DensityGrid> grid;
    std::uint32_t channel = 0;      ///< Of the grid.
    std::uint32_t medium_index = 0; ///< Into SceneDescription::media.
    mat4 world_from_local{1.0f};    ///< Affine; may mirror. In the scene's space.
    float density_scale = 1.0f;     ///< Multiplies the grid's densities, [0, 1e9].
};
} // namespace tyndall
