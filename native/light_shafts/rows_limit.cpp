// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/rows_limit.hpp"
#include "light_shafts/scattering_lights.hpp"

namespace tyndall::light_shafts {
static constexpr double row_s_per_triangle = 7e-8; // of a light sample's rows
static constexpr double row_s_per_ray = 3e-7;      // to ask a lamp's

static double occluding_triangles(const SceneDescription& description) {
    double count = 0.0;
    for (const Instance& instance : description.instances)
        if (instance.casts_shadow)
            count += static_cast<double>(description.meshes[instance.mesh_index]->triangle_count());
    return count;
}

LeftLights find_left(const Scene& scene, const Media& media, const Config& config, const StrataCounts& counts) {
    const RowsLimit& limit = config.rows_limit;
    const double s_per_sample = occluding_triangles(scene.description()) * row_s_per_triangle;
    double lamps_s = 0.0;
    for (std::size_t index = 0; index < scene.lights().size(); ++index)
        if (const Light& light = scene.lights()[index];
            light.kind != LightKind::Sun && light.scatters_in_media && light.strength != Rgb(0.0f))
            lamps_s += counts.of_light[index] * s_per_sample + row_s_per_ray * limit.ray_count;
    const bool has_world = !scene.world().is_black() && !(config.attenuates_light && media.fills_world());
    return {.lamps = lamps_s > limit.most_s, .world = has_world && counts.of_world * s_per_sample > limit.most_s};
}
} // namespace tyndall::light_shafts
