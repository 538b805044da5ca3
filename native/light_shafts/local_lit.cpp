// SPDX-License-Identifier: GPL-3.0-or-later
// What of a view ray a local light shines on.
#include "light_shafts/local_reached.hpp"
#include "light_shafts/local_scatter.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
/// What of the lit parts of a ray the light shines on: half of it counts within a cone's soft edge.
static void append_shone_on(std::span<const LitInterval> lit, const LocalSupport& support, std::size_t ray,
                            bool has_soft_edge, std::vector<LitInterval>& shone_on) {
    const auto at = [&](LocalSupport::Distance which) {
        return static_cast<float>(support.distance[LocalSupport::LightX][ray] + support.distance[which][ray]);
    };
    const float begin = at(LocalSupport::Begin), end = at(LocalSupport::End);
    float inner_begin = has_soft_edge ? std::max(begin, at(LocalSupport::Inner0)) : begin;
    float inner_end = has_soft_edge ? std::min(end, at(LocalSupport::Inner1)) : end;
    if (!(inner_begin < inner_end)) // only its edge
        inner_begin = inner_end = end;
    for (const LitInterval& interval : lit) {
        const auto append = [&](float from, float to, float weight) {
            const float near_m = std::max(interval.near_m, from), far_m = std::min(interval.far_m, to);
            if (near_m < far_m)
                shone_on.push_back({near_m, far_m, weight * interval.transmittance});
        };
        append(begin, inner_begin, 0.5f);
        append(inner_begin, inner_end, 1.0f);
        append(inner_end, end, 0.5f);
    }
}

/// The lit length of a ray in its media.
static float lit_length_of(std::span<const LitInterval> lit, std::span<const LocalRays::Segment> segments) {
    float length_m = 0.0f;
    for (const LitInterval& interval : lit) {
        const float share = average(interval.transmittance);
        for (const LocalRays::Segment& segment : segments)
            length_m += share * std::max(0.0f, std::min(interval.far_m, segment.far_m) -
                                                   std::max(interval.near_m, segment.near_m));
    }
    return length_m;
}

void LocalScatter::lit_intervals(const LocalRays& rays, const Visibility* visibility, LitRows& lit) const {
    thread_local Reached reached;
    find_reached(rays, visibility, reached);
    std::size_t row = 0;
    for (std::uint32_t ray = 0; ray < rays.size(); ++ray) {
        if (row < reached.rays.size() && reached.rays[row] == ray)
            append_shone_on(reached.lit.of_ray(row++), reached.support, ray, shape_.has_soft_edge, lit.intervals);
        lit.end_ray();
    }
}

void LocalScatter::add_lit_lengths(const LocalRays& rays, const Reached& reached, std::span<float> lit_length_m) const {
    thread_local std::vector<LitInterval> shone_on;
    for (std::size_t row = 0; row < reached.rays.size(); ++row) {
        const std::uint32_t ray = reached.rays[row];
        shone_on.clear();
        append_shone_on(reached.lit.of_ray(row), reached.support, ray, shape_.has_soft_edge, shone_on);
        lit_length_m[ray] += lit_length_of(shone_on, rays.segments_of(ray));
    }
}
} // namespace tyndall::light_shafts
