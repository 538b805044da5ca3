// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/narrowed_strands.hpp"
#include "scene/scene.hpp"
#include "scene/strands.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <cmath>
#include <map>

namespace tyndall {
std::shared_ptr<const Strands> narrowed(const Strands& strands, const OpaqueShare& opaque_share,
                                        const Progress& progress) {
    StrandArrays arrays{.name = strands.name(), .form = strands.form(), .ribbon_pieces = strands.ribbon_pieces()};
    std::uint32_t segment = 0;
    for (std::uint32_t strand = 0; strand < strands.strand_count(); ++strand) {
        if (strand % 4096 == 0)
            progress.poll();
        if (strands.form() == StrandForm::Spheres) {
            const StrandPoint ball = strands.on_spline(strand, 0.0f);
            arrays.points.emplace_back(ball.centre, ball.radius_m * std::sqrt(opaque_share(strand, 0.0f)));
            continue;
        }
        arrays.first_points.push_back(static_cast<std::uint32_t>(arrays.points.size()));
        const std::span<const vec4> doubled = strands.points_of(strand),
                                    points = doubled.subspan(1, doubled.size() - 2);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const bool is_last = i + 1 == points.size();
            const float share = opaque_share(is_last ? segment - 1 : segment, is_last ? 1.0f : 0.0f);
            arrays.points.emplace_back(vec3(points[i]), points[i].w * share);
            segment += is_last ? 0 : 1;
        }
    }
    return std::make_shared<const Strands>(std::move(arrays), progress);
}

/// How much of a placed strand's width light finds opaque, as a shadow ray across it does.
static float opaque_share(const Scene& scene, const Strands& strands, std::uint32_t instance, std::uint32_t segment,
                          float along) {
    const PlacedShape& placed = *scene.placed_shape(instance);
    const StrandPoint at = strands.on_spline(segment, along);
    const vec3 across = orthonormal_basis(unit_or(at.tangent, {0, 0, 1})).first;
    const vec3 aside = unit_or(mat3(placed.world_from_object) * across, {0, 0, 1});
    const vec3 position(placed.world_from_object * vec4(at.centre, 1.0f));
    const Ray ray{.origin = position + aside, .direction = -aside};
    const Hit hit{.distance_m = 1.0f,
                  .instance = instance,
                  .cell = segment,
                  .barycentrics = vec2(along, 0.0f),
                  .geometric_normal = across};
    return std::clamp(1.0f - average(scene.passing_share(ray, hit)), 0.0f, 1.0f);
}

void Scene::Geometry::narrow_strands(const Scene& scene, const Progress& progress) {
    if (description.media.empty())
        return;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> narrowed_of; // by shape and material
    for (std::uint32_t i = 0; i < description.placed_shapes.size(); ++i) {
        PlacedShape& placed = description.placed_shapes[i];
        const Strands* const strands = description.shapes[placed.shape_index]->strands();
        if (strands == nullptr || !shade_of(description, placed) ||
            is_opaque_everywhere(description.materials[placed.material_index]))
            continue;
        const auto [found, is_new] =
            narrowed_of.try_emplace({placed.shape_index, placed.material_index}, description.shapes.size());
        if (is_new) {
            const auto instance = static_cast<std::uint32_t>(description.instances.size() + i);
            description.shapes.push_back(narrowed(
                *strands,
                [&](std::uint32_t segment, float along) {
                    return tyndall::opaque_share(scene, *strands, instance, segment, along);
                },
                progress));
            statistics.report("object '" + description.object_names[placed.name_index] +
                              "': light shafts see what lets a part of the light pass as opaque and narrower");
        }
        placed.shade_index = static_cast<std::int32_t>(found->second);
    }
}
} // namespace tyndall
