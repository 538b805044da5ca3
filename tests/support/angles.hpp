// SPDX-License-Identifier: GPL-3.0-or-later
// Directions by angles, for what is told about a surface that looks up.
#pragma once
#include "core/math.hpp"
#include <cmath>
#include <numbers>

namespace tyndall::support {
inline vec3 at_angle(float degrees, float around = 0.0f) {
    const float angle = degrees * std::numbers::pi_v<float> / 180.0f;
    return {std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around), std::cos(angle)};
}
} // namespace tyndall::support
