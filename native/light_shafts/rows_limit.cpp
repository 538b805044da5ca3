// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/rows_limit.hpp"
#include "light_shafts/forward_fog.hpp"
#include "light_shafts/light_shafts.hpp"
#include "light_shafts/occluders.hpp"
#include "light_shafts/transparency_lookup.hpp"
#include "scene/strands.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
// Of a light sample's rows.
static constexpr double row_s_per_triangle = 7e-8;         // or per segment of a strand
static constexpr double row_s_per_partial_triangle = 2e-6; // which its texels ask how much light it lets pass
static constexpr double row_s_per_program_triangle = 6e-6; // the same by a program at each of their points
static constexpr double row_s_per_cell = 3.5e-7;           // drawn by its faces
static constexpr double row_s_of_traced = 0.08;            // whose texels ask for strands or cells ray by ray
static constexpr double row_s_per_ray = 3e-7;              // to ask a lamp's
static constexpr double row_s_per_ray_in_grids = 1.6e-6;   // the same of steps through density grids

static double s_per_partial_triangle(const Material& material) {
    const bool reads_points = (TransparentOperations(material).reads & OpReads::point) != 0;
    return reads_points ? row_s_per_program_triangle : row_s_per_partial_triangle;
}

/// Of a light sample, with the triangles alone. Maps hold the opaque ones for next to nothing.
static double row_s_of_triangles(const SceneDescription& description, bool has_maps) {
    std::vector<double> s_per_triangle; // of each material
    for (const Material& material : description.materials) {
        const Occlusion occlusion = occlusion_of(material);
        s_per_triangle.push_back(occlusion == Occlusion::Partial               ? s_per_partial_triangle(material)
                                 : occlusion == Occlusion::Opaque && !has_maps ? row_s_per_triangle
                                                                               : 0.0);
    }
    double seconds = 0.0;
    for (const Instance& instance : description.instances) {
        if (!instance.casts_shadow)
            continue;
        double most = 0.0;
        for (std::uint32_t slot = 0; slot < instance.slot_count; ++slot)
            most = std::max(most, s_per_triangle[description.slot_materials[instance.first_slot_material + slot]]);
        if (most > 0.0)
            seconds += most * static_cast<double>(description.meshes[instance.mesh_index]->triangle_count());
    }
    return seconds;
}

/// Of a light sample, with strands and cells alone. Maps hold faces of cells as they hold triangles.
static double row_s_of_shapes(const SceneDescription& description, bool has_maps) {
    std::vector<std::size_t> place_counts(description.shapes.size());
    for (const PlacedShape& placed : description.placed_shapes)
        if (const std::optional<std::uint32_t> shade = shade_of(description, placed))
            ++place_counts[*shade];
    double seconds = 0.0;
    bool is_traced = false;
    for (std::size_t index = 0; index < place_counts.size(); ++index) {
        const ShapeGeometry& shape = *description.shapes[index];
        const auto places = static_cast<double>(place_counts[index]);
        if (places == 0.0)
            continue;
        const bool is_shape_traced = !is_drawn(shape, place_counts[index]);
        is_traced |= is_shape_traced;
        if (const Strands* const strands = shape.strands())
            seconds += places * static_cast<double>(strands->segment_count()) * row_s_per_triangle;
        else if (const CellShape* const cells = shape.cells(); cells != nullptr && !is_shape_traced && !has_maps)
            seconds += places * static_cast<double>(cells->cell_count()) * row_s_per_cell;
    }
    return seconds + (is_traced ? row_s_of_traced : 0.0);
}

LeftLights find_left(const Scene& scene, const Media& media, const Config& config, const RowsCounts& counts) {
    const RowsLimit& limit = config.rows_limit;
    if (limit.most_s == std::numeric_limits<double>::infinity())
        return {};
    const SceneDescription& description = scene.description();
    const bool has_maps = config.method == Method::ShadowMap;
    const double s_per_sample = row_s_of_triangles(description, has_maps) + row_s_of_shapes(description, has_maps);
    const double s_per_ray = !media.grids().is_empty() ? row_s_per_ray_in_grids : has_maps ? 0.0 : row_s_per_ray;
    const double lamps_s = static_cast<double>(counts.lamp_samples) * s_per_sample +
                           static_cast<double>(counts.lamps) * s_per_ray * limit.ray_count;
    const bool is_swallowed = config.attenuates_light && media.fills_world();
    const std::optional<LackOfDirections> lack = lack_of_directions(scene, config);
    return {.lamps = lamps_s > limit.most_s,
            .world = !is_swallowed && (static_cast<double>(counts.world_samples) * s_per_sample > limit.most_s ||
                                       (lack && lack->is_worth_draws() && !has_maps))};
}
} // namespace tyndall::light_shafts
