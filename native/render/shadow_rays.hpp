// SPDX-License-Identifier: GPL-3.0-or-later
// Shadow rays of points that are lit together, on their way: of direct_light.cpp and direct_light_world.cpp alone.
#pragma once
#include "render/direct_light.hpp"
#include <array>
#include <span>

namespace tyndall::render {
/// Rays of several points towards one light.
struct DirectLight::ShadowRays {
    std::array<Ray, most_points> rays;
    std::array<Rgb, most_points> arriving; ///< With nothing between, times the cosine.
    std::array<Rgb, most_points> passing;
    std::array<Rgb, most_points> reflected; ///< Towards the viewer, as `arriving`: where points have lobes.
    std::array<std::uint8_t, most_points> points;
    std::array<const Light*, most_points> lamps; ///< Of lights that are drawn; null for what glows.
    std::array<float, most_points> shares; ///< Of these: of the irradiance that is found this way, not by the cosine.
    std::array<std::uint8_t, most_points> groups;     ///< Of these: the light's group.
    std::array<const LightLinks*, most_points> links; ///< Of these.
    std::array<RayKind, most_points> kinds;           ///< Of the world's.
    std::size_t count = 0;

    void push(const Ray& ray, const Rgb& unshadowed, std::size_t point, const Rgb& by_lobes = Rgb(0.0f),
              RayKind kind = RayKind::Shadow) {
        rays[count] = ray;
        kinds[count] = kind;
        reflected[count] = by_lobes;
        arriving[count] = unshadowed;
        points[count++] = static_cast<std::uint8_t>(point);
    }
    [[nodiscard]] std::span<const Ray> all() const { return std::span(rays).first(count); }
};

[[nodiscard]] inline Ray ray_of(const AimedRays& aimed, std::size_t lane) {
    return {.origin = aimed.origin.get(lane),
            .direction = aimed.direction.get(lane),
            .near_m = 0.0f,
            .far_m = aimed.far_m[lane]};
}
} // namespace tyndall::render
