// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/world.hpp"

namespace tyndall::support {
/// Rows from below.
inline std::shared_ptr<const EnvironmentImage> environment_image(std::uint32_t width, std::uint32_t height,
                                                                 const std::vector<Rgb>& colours) {
    std::vector<vec4> pixels;
    for (const Rgb& colour : colours)
        pixels.emplace_back(colour, 1.0f);
    return std::make_shared<const EnvironmentImage>("sky", width, height, std::move(pixels));
}
} // namespace tyndall::support
