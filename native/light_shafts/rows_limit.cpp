// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/rows_limit.hpp"
#include "light_shafts/forward_fog.hpp"
#include "light_shafts/light_shafts.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
static constexpr double row_s_per_triangle = 7e-8; // of a light sample's rows
static constexpr double row_s_of_strands = 0.08;   // of a light sample's rows, whose texels ask for strands ray by ray
static constexpr double row_s_per_ray = 3e-7;      // to ask a lamp's

static double occluding_triangles(const SceneDescription& description) {
    double count = 0.0;
    for (const Instance& instance : description.instances)
        if (instance.casts_shadow)
            count += static_cast<double>(description.meshes[instance.mesh_index]->triangle_count());
    return count;
}

static bool has_occluding_strands(const SceneDescription& description) {
    return std::ranges::any_of(description.placed_shapes, [&](const PlacedShape& placed) {
        return placed.casts_shadow && description.shapes[placed.shape_index]->strands() != nullptr;
    });
}

LeftLights find_left(const Scene& scene, const Media& media, const Config& config, const RowsCounts& counts) {
    const RowsLimit& limit = config.rows_limit;
    if (limit.most_s == std::numeric_limits<double>::infinity())
        return {};
    const SceneDescription& description = scene.description();
    const double s_per_sample = occluding_triangles(description) * row_s_per_triangle +
                                (has_occluding_strands(description) ? row_s_of_strands : 0.0);
    const double lamps_s = static_cast<double>(counts.lamp_samples) * s_per_sample +
                           static_cast<double>(counts.lamps) * row_s_per_ray * limit.ray_count;
    const bool is_swallowed = config.attenuates_light && media.fills_world();
    const std::optional<LackOfDirections> lack = lack_of_directions(scene, config);
    return {.lamps = lamps_s > limit.most_s,
            .world = !is_swallowed && (static_cast<double>(counts.world_samples) * s_per_sample > limit.most_s ||
                                       (lack && lack->is_worth_draws()))};
}
} // namespace tyndall::light_shafts
