// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/patterns/wave.hpp"
#include "shading/patterns/checker.hpp"

namespace tyndall::patterns {
static float angle_rad(const vec3& at, const WaveConfig& config) {
    const auto axis = static_cast<int>(config.direction);
    const bool is_diagonal = config.direction == WaveConfig::Direction::Diagonal;
    if (config.kind == WaveConfig::Kind::Bands)
        return is_diagonal ? (at.x + at.y + at.z) * 10.0f : at[axis] * 20.0f;
    vec3 across = at;
    if (!is_diagonal)
        across[axis] = 0.0f;
    return glm::length(across) * 20.0f;
}

float wave(const vec3& vector, const WaveConfig& config) {
    const vec3 at = off_whole_numbers(vector * config.scale);
    float angle = angle_rad(at, config) + config.phase_rad;
    if (config.distortion != 0.0f) {
        const Octaves octaves{.detail = std::clamp(config.detail, 0.0f, most_detail),
                              .factor = std::max(config.detail_roughness, 0.0f)};
        angle += config.distortion * (fbm<3>(at * config.detail_scale, octaves, true) * 2.0f - 1.0f);
    }
    if (config.profile == WaveConfig::Profile::Sine)
        return 0.5f + 0.5f * std::sin(angle - 0.5f * pi);
    const float turns = angle / (2.0f * pi);
    if (config.profile == WaveConfig::Profile::Saw)
        return turns - std::floor(turns);
    return std::abs(turns - std::floor(turns + 0.5f)) * 2.0f;
}
} // namespace tyndall::patterns
