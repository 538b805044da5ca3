// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/panorama.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
/// So far from ahead, on the side of `at`; upwards, as in Cycles, where that is the middle.
static vec3 at_angle(const vec2& at, float radius, float angle_rad) {
    const float aside = std::sin(angle_rad);
    return vec3(radius > 0.0f ? aside / radius * at : vec2(0.0f, aside), -std::cos(angle_rad));
}

static float angle_from_ahead(const vec3& towards) { return std::atan2(std::hypot(towards.x, towards.y), -towards.z); }

/// The nearest to `middle` of the angles that are whole periods apart.
static float near_middle(float angle_rad, float middle_rad, float period_rad) {
    return middle_rad + std::remainder(angle_rad - middle_rad, period_rad);
}

float Panorama::angle_at(float radius) const {
    const auto& k = angle_by_radius;
    return k[0] + radius * (k[1] + radius * (k[2] + radius * (k[3] + radius * k[4])));
}

float Panorama::angle_slope_at(float radius) const {
    const auto& k = angle_by_radius;
    return k[1] + radius * (2.0f * k[2] + radius * (3.0f * k[3] + radius * 4.0f * k[4]));
}

std::optional<vec3> Panorama::direction(const vec2& at) const {
    switch (kind) {
    case PanoramaKind::Equirectangular:
        return vec3(std::cos(at.y) * std::sin(at.x), std::sin(at.y), -std::cos(at.y) * std::cos(at.x));
    case PanoramaKind::FisheyeEquidistant: {
        const float radius = glm::length(at);
        if (!(radius <= rim))
            return {};
        return at_angle(at, radius, radius);
    }
    case PanoramaKind::FisheyeEquisolid:
    case PanoramaKind::MirrorBall: {
        const float radius = glm::length(at); // sin(angle / 2)
        if (!(radius <= rim))
            return {};
        const float cos_of_half = std::sqrt(std::max(1.0f - radius * radius, 0.0f));
        return vec3(2.0f * cos_of_half * at, 2.0f * radius * radius - 1.0f);
    }
    case PanoramaKind::FisheyePolynomial: {
        const float radius = glm::length(at), angle_rad = angle_at(radius);
        if (!(std::abs(angle_rad) <= rim) || !std::isfinite(angle_rad))
            return {};
        return at_angle(at, radius, angle_rad);
    }
    case PanoramaKind::EquiangularCubemapFace:
        return vec3(std::tan(at.x), std::tan(at.y), -1.0f);
    case PanoramaKind::CentralCylindrical:
        break;
    }
    return vec3(std::sin(at.x), at.y, -std::cos(at.x));
}

std::optional<vec2> Panorama::place(const vec3& towards, const vec2& low, const vec2& high) const {
    const vec2 middle = 0.5f * (low + high), aside(towards);
    const float length = glm::length(aside), distance = glm::length(towards);
    switch (kind) {
    case PanoramaKind::Equirectangular: // what is seen lies within half a turn of the middle
        return vec2(near_middle(std::atan2(towards.x, -towards.z), middle.x, 2.0f * pi),
                    std::atan2(towards.y, std::hypot(towards.x, towards.z)));
    case PanoramaKind::FisheyeEquidistant:
    case PanoramaKind::FisheyePolynomial: {
        if (length == 0.0f && !(towards.z < 0.0f))
            return {};
        const float angle_rad = angle_from_ahead(towards);
        const float reach = 2.0f * glm::length(glm::max(glm::abs(low), glm::abs(high)));
        const std::optional<float> radius =
            kind == PanoramaKind::FisheyeEquidistant ? angle_rad : radius_of(angle_rad, reach);
        if (!radius)
            return {};
        return length > 0.0f ? *radius / length * aside : vec2(0.0f, *radius);
    }
    case PanoramaKind::FisheyeEquisolid:
    case PanoramaKind::MirrorBall:
        if (!(towards.z < distance))
            return {};
        return aside / std::sqrt(2.0f * distance * (distance - towards.z));
    case PanoramaKind::EquiangularCubemapFace:
        if (!(towards.z < 0.0f))
            return {};
        return vec2(near_middle(std::atan2(towards.x, -towards.z), middle.x, pi),
                    near_middle(std::atan2(towards.y, -towards.z), middle.y, pi));
    case PanoramaKind::CentralCylindrical:
        break;
    }
    const float across = std::hypot(towards.x, towards.z);
    if (!(across > 0.0f))
        return {};
    return vec2(near_middle(std::atan2(towards.x, -towards.z), middle.x, 2.0f * pi), towards.y / across);
}

float Panorama::radius_guess(float angle_rad) const {
    constexpr int step_count = 8;
    float radius = (angle_rad - angle_by_radius[0]) / angle_by_radius[1];
    for (int step = 0; step < step_count; ++step)
        radius -= (angle_at(radius) - angle_rad) / angle_slope_at(radius);
    return radius;
}

std::optional<float> Panorama::radius_of(float angle_rad, float reach) const {
    constexpr float close_rad = 1e-5f;
    constexpr int interval_count = 64, halving_count = 24;
    if (const float guess = radius_guess(angle_rad);
        0.0f <= guess && guess <= reach && std::abs(angle_at(guess) - angle_rad) < close_rad)
        return guess;
    // A lens that turns back, or that looks to the other side: an angle below 0.
    for (int interval = 0; interval < interval_count; ++interval) {
        float near = reach * static_cast<float>(interval) / interval_count,
              far = reach * static_cast<float>(interval + 1) / interval_count;
        for (const float side : {1.0f, -1.0f}) {
            const auto is_beyond = [&](float radius) { return side * angle_at(radius) > angle_rad; };
            if (is_beyond(near) == is_beyond(far))
                continue;
            for (int halving = 0; halving < halving_count; ++halving) {
                const float half = 0.5f * (near + far);
                (is_beyond(half) == is_beyond(near) ? near : far) = half;
            }
            return side * 0.5f * (near + far);
        }
    }
    return {};
}

vec2 Panorama::beyond_rim(const vec2& at) const {
    constexpr float margin = 0.01f; // the rim itself may lie between two such places
    const float length = glm::length(at);
    const float radius =
        kind == PanoramaKind::FisheyePolynomial ? std::abs(radius_of(rim, length).value_or(length)) : rim;
    return length > 0.0f ? (1.0f + margin) * std::max(radius, 0.0f) / length * at : at;
}

vec2 Panorama::turns(const vec3& towards) const {
    const float across = std::hypot(towards.x, towards.z);
    switch (kind) {
    case PanoramaKind::Equirectangular: // a degree of longitude is narrow near the poles
        return {across, 1.0f};
    case PanoramaKind::EquiangularCubemapFace: {
        const vec2 plane = vec2(towards) / towards.z;
        const vec2 steepness = 1.0f + plane * plane; // of the tangents
        return std::abs(towards.z) * steepness * glm::sqrt(glm::max(1.0f - vec2(towards) * vec2(towards), 0.0f));
    }
    case PanoramaKind::CentralCylindrical:
        return {across, across * across};
    default:
        break;
    }
    // Outward from the middle and around it.
    const vec2 aside(towards);
    const float length = glm::length(aside), angle_rad = angle_from_ahead(towards);
    float outward = 1.0f, around = angle_rad > 0.0f ? length / angle_rad : 1.0f;
    if (kind == PanoramaKind::FisheyePolynomial) {
        const float radius = radius_guess(angle_rad);
        outward = std::abs(angle_slope_at(radius));
        around = radius > 0.0f && length > 0.0f ? length / radius : outward;
        if (!std::isfinite(outward) || !std::isfinite(around))
            outward = around = std::abs(angle_by_radius[1]);
    } else if (kind != PanoramaKind::FisheyeEquidistant) {
        constexpr float least = 0.05f; // of a mirror ball's rim, where a step turns without bound
        const float cos_of_half = std::max(std::sqrt(std::max(0.5f - 0.5f * towards.z, 0.0f)), least);
        outward = 2.0f / cos_of_half;
        around = 2.0f * cos_of_half;
    }
    const vec2 unit = length > 0.0f ? aside / length : vec2(1.0f, 0.0f);
    return {std::hypot(outward * unit.x, around * unit.y), std::hypot(outward * unit.y, around * unit.x)};
}
} // namespace tyndall
