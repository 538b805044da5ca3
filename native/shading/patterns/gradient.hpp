// SPDX-License-Identifier: GPL-3.0-or-later
// The Gradient node.
// Based on: a ramp along X, a cubic step, an angle, and the distance from the unit sphere.
// Differs:  spheres are a millionth smaller, as Cycles has them: the unit sphere's surface is 0 everywhere.
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <cstdint>
#include <numbers>

namespace tyndall::patterns {
enum class Gradient : std::uint8_t {
    Linear = 0,
    Quadratic = 1,
    Easing = 2,
    Diagonal = 3,
    Radial = 4,
    QuadraticSphere = 5,
    Spherical = 6,
};
/// In [0, 1].
[[nodiscard]] inline float gradient(const vec3& at, Gradient kind) {
    const auto share = [](float value) { return std::clamp(value, 0.0f, 1.0f); };
    const auto inside_sphere = [&] { return std::max(0.999999f - glm::length(at), 0.0f); };
    switch (kind) {
    case Gradient::Linear:
        return share(at.x);
    case Gradient::Quadratic: {
        const float positive = share(at.x);
        return positive * positive;
    }
    case Gradient::Easing: {
        const float t = share(at.x);
        return t * t * (3.0f - 2.0f * t);
    }
    case Gradient::Diagonal:
        return share((at.x + at.y) * 0.5f);
    case Gradient::Radial:
        return share(std::atan2(at.y, at.x) / (2.0f * std::numbers::pi_v<float>)+0.5f);
    case Gradient::QuadraticSphere: {
        const float depth = inside_sphere();
        return depth * depth;
    }
    case Gradient::Spherical:
        return inside_sphere();
    }
    return 0.0f;
}
} // namespace tyndall::patterns
