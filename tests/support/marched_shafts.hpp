// SPDX-License-Identifier: GPL-3.0-or-later
// Brute force for light shafts: it knows nothing of intervals, pieces, steps or columns.
#pragma once
#include "light_shafts/light_shafts.hpp"

namespace tyndall::support {
using light_shafts::ViewRay;

/// Single scattering along a ray by the midpoint rule, each point asked alone. Lights without a size.
inline Rgb march(const Scene& scene, const ViewRay& ray, int steps, bool attenuates_light = true) {
    Progress progress;
    const Media media(scene, progress);
    const double step_m = (double{ray.far_m} - ray.near_m) / steps;
    glm::dvec3 sum(0.0);
    for (int step = 0; step < steps; ++step) {
        const auto t = static_cast<float>(ray.near_m + (step + 0.5) * step_m);
        const vec3 point = ray.origin + t * ray.direction;
        std::vector<MediumSegment> here;
        media.segments({.origin = point, .direction = ray.direction, .far_m = 1e-3f}, here);
        if (here.empty())
            continue;
        const Rgb to_camera =
            media.transmittance({.origin = ray.origin, .direction = ray.direction, .near_m = ray.near_m, .far_m = t});
        for (std::uint32_t index = 0; index < scene.lights().size(); ++index) {
            const LightSample light = sample_light(scene.lights()[index], index, vec3(0.5f));
            Ray to_light{.origin = point, .direction = light.towards_light};
            Rgb irradiance = light.strength;
            if (!light.is_directional) {
                const vec3 way = light.position - point;
                to_light.far_m = glm::length(way);
                to_light.direction = way / to_light.far_m;
                irradiance = intensity_w_per_sr(light, -to_light.direction) / (to_light.far_m * to_light.far_m);
            }
            const float cosine = glm::dot(ray.direction, to_light.direction);
            Rgb phase = media.scatter_per_m_sr(here[0].set, cosine);
            media.grids().for_each_density(point, [&](const GridField& field, float density) {
                MediumSet alone;
                alone.insert(field.medium);
                phase += density * field.density_scale * media.scatter_per_m_sr(alone, cosine);
            });
            const Rgb to_the_light = attenuates_light ? media.transmittance(to_light) : Rgb(1.0f);
            sum += glm::dvec3(irradiance * phase * to_camera * to_the_light * scene.shadow_transmittance(to_light));
        }
    }
    return Rgb(sum * step_m);
}
} // namespace tyndall::support
