// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/light_cluster.hpp"
#include <cmath>

namespace tyndall::render {
LightCluster& LightCluster::operator+=(const LightCluster& other) {
    if (other.is_empty())
        return *this;
    if (is_empty())
        return *this = other;
    box.grow(other.box);
    power += other.power;
    if (other.reach_rad > reach_rad)
        reach_rad = other.reach_rad, cos_reach = other.cos_reach, sin_reach = other.sin_reach;
    // What shines on its back as on its front may be turned round.
    const float cosine = glm::dot(axis, other.axis);
    if (cosine < 0.0f && other.back == 1.0f)
        widen(-other.axis, other.cos_spread, other.sin_spread);
    else {
        if (cosine < 0.0f && back == 1.0f)
            axis = -axis;
        widen(other.axis, other.cos_spread, other.sin_spread);
    }
    back = std::max(back, other.back);
    return *this;
}

/// Of an angle in [0, 2 pi) and one in [0, pi]. Sines tell small angles apart, cosines those that differ by pi.
static bool is_at_most(float cos_angle, float sin_angle, float cos_limit, float sin_limit) {
    return sin_angle >= 0.0f && sin_limit * cos_angle >= cos_limit * sin_angle && cos_angle >= cos_limit - 1e-6f;
}

void LightCluster::widen(const vec3& other_axis, float other_cos, float other_sin) {
    if (cos_spread == -1.0f || other_cos == -1.0f) { // a rim may lie a whole turn from the other's axis
        shine_everywhere();
        return;
    }
    const float cosine = glm::dot(axis, other_axis);
    if (other_cos == 1.0f && cosine > cos_spread + 1e-6f) // most lights have one direction, and lie within
        return;
    const vec3 across = other_axis - cosine * axis;
    const float sine = glm::length(across);
    // How far the other's rim is from this axis, and this one's from the other's: of angles in [0, 2 pi).
    const float cos_rim = cosine * other_cos - sine * other_sin, sin_rim = sine * other_cos + cosine * other_sin;
    if (is_at_most(cos_rim, sin_rim, cos_spread, sin_spread))
        return;
    const float cos_back = cosine * cos_spread - sine * sin_spread, sin_back = sine * cos_spread + cosine * sin_spread;
    if (is_at_most(cos_back, sin_back, other_cos, other_sin)) {
        axis = other_axis, cos_spread = other_cos, sin_spread = other_sin;
        return;
    }
    if (!(sine > 1e-6f)) {
        if (cosine > 0.0f)
            cos_spread = cos_rim, sin_spread = sin_rim;
        else
            shine_everywhere();
        return;
    }
    // Half of an angle in (0, 3 pi), which is to be less than pi.
    const float cos_both = cos_spread * cos_rim - sin_spread * sin_rim;
    const float sin_both = sin_spread * cos_rim + cos_spread * sin_rim;
    const bool is_over_pi = sin_rim < 0.0f;
    if (is_over_pi && sin_both >= 0.0f) {
        shine_everywhere();
        return;
    }
    const float smaller = std::sqrt(std::max(0.0f, 0.5f - 0.5f * std::abs(cos_both)));
    const float larger = std::sqrt(0.5f + 0.5f * std::abs(cos_both));
    const float sign = is_over_pi || sin_both < 0.0f ? -1.0f : 1.0f;
    const float cos_half = sign * (cos_both > 0.0f ? larger : smaller);
    const float sin_half = cos_both > 0.0f ? 0.5f * std::abs(sin_both) / larger : larger;
    const float cos_turn = cos_half * cos_spread + sin_half * sin_spread;
    const float sin_turn = sin_half * cos_spread - cos_half * sin_spread;
    axis = glm::normalize(cos_turn * axis + sin_turn / sine * across);
    cos_spread = cos_half, sin_spread = sin_half;
}

float LightCluster::cost(float least_m) const {
    if (is_empty())
        return 0.0f;
    const vec3 size = box.max - box.min + vec3(least_m);
    const float area = size.x * size.y + size.y * size.z + size.z * size.x;
    float directions = 2.0f * pi * (1.0f - cos_spread);
    if (sin_spread * cos_reach + cos_spread * sin_reach >= 0.0f) {
        const float cos_twice = cos_reach * cos_reach - sin_reach * sin_reach, sin_twice = 2.0f * cos_reach * sin_reach;
        directions +=
            0.5f * pi * (2.0f * reach_rad * sin_spread - cos_spread * cos_twice + sin_spread * sin_twice + cos_spread);
    } else // their widest angle is pi
        directions += pi * (pi - std::atan2(sin_spread, cos_spread)) * sin_spread;
    return power * area * std::max(directions, 0.1f) * (1.0f + back);
}
} // namespace tyndall::render
