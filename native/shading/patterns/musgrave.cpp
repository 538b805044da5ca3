// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/patterns/musgrave.hpp"
#include "shading/patterns/coordinates.hpp"

namespace tyndall::patterns {
float musgrave(const vec3& vector, const MusgraveConfig& config) {
    const float lacunarity = std::max(config.lacunarity, 1e-5f);
    const Octaves octaves{.detail = std::clamp(config.detail, 0.0f, most_detail),
                          .factor = std::pow(lacunarity, -std::max(config.dimension, 1e-5f)),
                          .lacunarity = lacunarity,
                          .offset = config.offset,
                          .gain = config.gain};
    return with_dimensions(config.dimensions, [&]<int N>() {
        return fractal_noise<N>(config.fractal, coordinates<N>(vector, config.w) * config.scale, octaves, 0);
    });
}
} // namespace tyndall::patterns
