// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/rows_limit.hpp"
#include "light_shafts/forward_fog.hpp"
#include "light_shafts/light_shafts.hpp"
#include "scene/strands.hpp"

namespace tyndall::light_shafts {
// Of a light sample's rows.
static constexpr double row_s_per_triangle = 7e-8; // or per segment of a strand
static constexpr double row_s_of_traced = 0.08;    // whose texels ask for strands ray by ray
static constexpr double row_s_per_ray = 3e-7;      // to ask a lamp's

static double occluding_triangles(const SceneDescription& description) {
    double count = 0.0;
    for (const Instance& instance : description.instances)
        if (instance.casts_shadow)
            count += static_cast<double>(description.meshes[instance.mesh_index]->triangle_count());
    return count;
}

/// Of a light sample, with the strands alone.
static double row_s_of_strands(const SceneDescription& description) {
    double segments = 0.0;
    bool is_traced = false;
    for (const PlacedShape& placed : description.placed_shapes) {
        const Strands* const strands = description.shapes[placed.shape_index]->strands();
        if (!placed.casts_shadow || strands == nullptr)
            continue;
        segments += static_cast<double>(strands->segment_count());
        is_traced |= !strands->are_splines();
    }
    return segments * row_s_per_triangle + (is_traced ? row_s_of_traced : 0.0);
}

LeftLights find_left(const Scene& scene, const Media& media, const Config& config, const RowsCounts& counts) {
    const RowsLimit& limit = config.rows_limit;
    if (limit.most_s == std::numeric_limits<double>::infinity())
        return {};
    const SceneDescription& description = scene.description();
    const double s_per_sample = occluding_triangles(description) * row_s_per_triangle + row_s_of_strands(description);
    const double lamps_s = static_cast<double>(counts.lamp_samples) * s_per_sample +
                           static_cast<double>(counts.lamps) * row_s_per_ray * limit.ray_count;
    const bool is_swallowed = config.attenuates_light && media.fills_world();
    const std::optional<LackOfDirections> lack = lack_of_directions(scene, config);
    return {.lamps = lamps_s > limit.most_s,
            .world = !is_swallowed && (static_cast<double>(counts.world_samples) * s_per_sample > limit.most_s ||
                                       (lack && lack->is_worth_draws()))};
}
} // namespace tyndall::light_shafts
