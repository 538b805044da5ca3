// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/drawn_shafts.hpp"
#include "light_shafts/scattering_lights.hpp"
#include <algorithm>

namespace tyndall::render {
namespace {
constexpr double row_s_per_triangle = 7e-8; // of a light sample's rows
constexpr double row_s_per_ray = 3e-7;      // to ask a lamp's
constexpr double ray_s = 12e-6;             // of a camera ray: its surfaces and draws
constexpr double most_times = 4.0;          // as long as that
constexpr std::uint32_t usual_strata = 16;  // of a lamp with a size, by the error target

double occluding_triangles(const SceneDescription& description) {
    double count = 0.0;
    for (const Instance& instance : description.instances)
        if (instance.casts_shadow)
            count += static_cast<double>(description.meshes[instance.mesh_index]->triangle_count());
    return count;
}
} // namespace

DrawnShafts choose_drawn(const Scene& scene, const Media& media, const light_shafts::Config& config, double ray_count) {
    const SceneDescription& description = scene.description();
    const auto is_edited = [](const Light& light) { return !light.occluder_edits.empty(); };
    if (config.method != light_shafts::Method::Epipolar || config.resolution != 0 || config.walks_maps ||
        media.is_empty() || !media.grids().is_empty() || std::ranges::any_of(scene.lights(), is_edited))
        return {};
    const double triangles = occluding_triangles(description), most_s = most_times * ray_s * ray_count;
    double lamps = 0.0, samples = 0.0;
    for (const Light& light : scene.lights())
        if (light.kind != LightKind::Sun && light.scatters_in_media && light.strength != Rgb(0.0f)) {
            lamps += 1.0;
            samples += light_shafts::has_size(light) ? std::min(config.light_samples, usual_strata) : 1;
        }
    const bool has_world = !scene.world().is_black() && !(config.attenuates_light && media.fills_world());
    return {.lamps = samples * triangles * row_s_per_triangle + lamps * row_s_per_ray * ray_count > most_s,
            .world = has_world && config.world_samples * triangles * row_s_per_triangle > most_s};
}
} // namespace tyndall::render
