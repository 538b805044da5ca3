// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/local_rays.hpp"
#include "volume/phase_function.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::light_shafts {
bool holds(const MediumBoundary& boundary, const vec3& point, float slack) {
    const vec3 at(boundary.object_from_world * vec4(point, 1.0f));
    const vec3 margin = slack * (boundary.object_bounds.max - boundary.object_bounds.min);
    return glm::all(glm::greaterThanEqual(at, boundary.object_bounds.min - margin)) &&
           glm::all(glm::lessThanEqual(at, boundary.object_bounds.max + margin));
}

std::uint32_t LocalRays::index_of(const Media& media, const MediumSet& set) {
    for (std::uint32_t index = 0; index < sets_.size(); ++index)
        if (sets_[index].set == set)
            return index;
    SetOfMedia& made =
        sets_.emplace_back(SetOfMedia{.set = set, .sigma_t = dvec3(media.sigma_t_per_m(set)), .lobes = {}});
    dvec3 least(0.0), most(0.0);
    for (std::size_t index = 0; index < set.count; ++index)
        for (const ScatterLobe& lobe : media.scene().description().media[set.media[index]].lobes) {
            const double g = std::abs(double{lobe.asymmetry_g});
            const double alpha = double{lobe.draine_alpha}, total = draine_total(lobe.asymmetry_g, lobe.draine_alpha);
            const dvec3 weight = dvec3(lobe.sigma_s_per_m) * ((1.0 - g * g) * 0.25 * std::numbers::inv_pi / total);
            made.lobes.push_back(
                {.weight = {static_cast<float>(weight.x), static_cast<float>(weight.y), static_cast<float>(weight.z)},
                 .least = static_cast<float>((1.0 - g) * (1.0 - g)),
                 .two_g = static_cast<float>(2.0 * g),
                 .draine_alpha = lobe.draine_alpha,
                 .is_forward = lobe.asymmetry_g >= 0.0f});
            least += weight * std::pow(1.0 + g, -3.0);
            most += (1.0 + alpha) * weight * std::pow(std::max(1.0 - g, 1e-6), -3.0);
        }
    made.least_scatter = std::max({least.x, least.y, least.z});
    made.most_scatter = std::max({most.x, most.y, most.z});
    return static_cast<std::uint32_t>(sets_.size() - 1);
}

void LocalRays::assign(const Media& media, std::span<const ViewRay> rays, std::span<const std::uint32_t> first_segment,
                       std::span<const MediumSegment> segments) {
    rays_ = rays, first_segment_ = first_segment;
    segments_.clear(), sets_.clear(), is_in_all_boxes_.clear();
    const std::size_t padded = (rays.size() + padding - 1) / padding * padding;
    for (std::vector<double>& values : columns_)
        values.assign(padded, 0.0);
    for (std::size_t index = 0; index < rays.size(); ++index) {
        dvec3 depth(0.0);
        for (std::uint32_t at = first_segment[index]; at < first_segment[index + 1]; ++at) {
            const MediumSegment& segment = segments[at];
            const std::uint32_t set = index_of(media, segment.set);
            segments_.push_back({segment.near_m, segment.far_m, set, depth});
            depth += sets_[set].sigma_t * (double{segment.far_m} - segment.near_m);
        }
        const ViewRay& ray = rays[index];
        for (int axis = 0; axis < 3; ++axis) {
            columns_[static_cast<std::size_t>(OriginX + axis)][index] = ray.origin[axis];
            columns_[static_cast<std::size_t>(DirectionX + axis)][index] = ray.direction[axis];
        }
        const auto own = segments_of(index);
        columns_[Near][index] = own.empty() ? 1.0 : own.front().near_m;
        columns_[Far][index] = own.empty() ? 0.0 : own.back().far_m;
        is_in_all_boxes_.push_back(std::ranges::all_of(media.boundaries(), [&](const MediumBoundary& boundary) {
            return own.empty() || (boundary.is_box &&
                                   holds(boundary, ray.origin + own.front().near_m * ray.direction, rounding_of_ends) &&
                                   holds(boundary, ray.origin + own.back().far_m * ray.direction, rounding_of_ends));
        }));
    }
    double most = 1e-30;
    for (const SetOfMedia& set : sets_)
        most = std::max(most, set.most_scatter);
    log_most_scatter_ = std::log(most);
}
} // namespace tyndall::light_shafts
