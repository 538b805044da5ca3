// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/strand_bends.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
/// Between two points a strand may leave their straight line by this share of its radius.
static constexpr float bend_in_radii = 0.1f;
static constexpr float swell_in_radii = 0.02f; // and be wider or thinner by this, which its shadow is then, too
static constexpr float most_pieces_per_segment = 16.0f;
static constexpr float thinnest_m = 1e-30f; // a strand that is nowhere wide is straight if it is a line

/// Of a segment between the second and the third of four points.
static std::size_t pieces_of_segment(const vec4* p) {
    const vec4 square = p[0] - 2.5f * p[1] + 2.0f * p[2] - 0.5f * p[3],
               cube = 0.5f * (3.0f * (p[1] - p[2]) + p[3] - p[0]);
    // What a curve leaves its chord by is at most an eighth of its second derivative, which is linear.
    const float bend_m = 0.25f * std::max(glm::length(square), glm::length(square + 3.0f * cube));
    const float allowed_m = bend_in_radii * std::max({p[1].w, p[2].w, thinnest_m});
    const float pieces = std::ceil(std::sqrt(bend_m / allowed_m));
    return static_cast<std::size_t>(std::clamp(pieces, 1.0f, most_pieces_per_segment));
}

/// Whether those between lie on one piece from the first to the last, as wide as it is there.
static bool are_on_one_piece(std::span<const StrandPoint> rings) {
    const StrandPoint &first = rings.front(), &last = rings.back();
    const vec3 way = last.centre - first.centre;
    const float squared = glm::dot(way, way), widest_m = std::max(first.radius_m, last.radius_m);
    float reached = 0.0f;
    return std::ranges::all_of(rings, [&](const StrandPoint& ring) {
        const vec3 from_first = ring.centre - first.centre;
        const float along = glm::dot(from_first, way) / std::max(squared, 1e-36f);
        const bool goes_on = along >= reached && along <= 1.0f + 1e-5f;
        reached = along - 1e-5f;
        return goes_on && glm::length(from_first - along * way) <= bend_in_radii * widest_m &&
               std::abs(first.radius_m + along * (last.radius_m - first.radius_m) - ring.radius_m) <=
                   swell_in_radii * widest_m;
    });
}

/// All but the first, without those that lie on one piece.
static void for_bends(std::span<const StrandPoint> rings, const auto& visit) {
    if (rings.size() <= 2 || are_on_one_piece(rings)) {
        visit(rings.back());
        return;
    }
    const std::size_t middle = rings.size() / 2;
    for_bends(rings.first(middle + 1), visit);
    for_bends(rings.subspan(middle), visit);
}

StrandBends::StrandBends(const Strands& strands) : strands_(strands), first_segment_(strands.strand_count(), 0) {
    for (std::uint32_t strand = 0; strand + 1 < first_segment_.size(); ++strand)
        first_segment_[strand + 1] =
            first_segment_[strand] + static_cast<std::uint32_t>(strands.points_of(strand).size() - 3);
}

std::span<const StrandPoint> StrandBends::of(std::uint32_t strand) {
    const std::span<const vec4> points = strands_.points_of(strand);
    const auto segments = static_cast<std::uint32_t>(points.size() - 3);
    dense_.clear();
    for (std::uint32_t segment = 0; segment < segments; ++segment) {
        const std::size_t pieces = pieces_of_segment(&points[segment]);
        for (std::size_t piece = 0; piece < pieces; ++piece)
            dense_.push_back(strands_.on_spline(first_segment_[strand] + segment,
                                                static_cast<float>(piece) / static_cast<float>(pieces)));
    }
    dense_.push_back(strands_.on_spline(first_segment_[strand] + segments - 1, 1.0f));
    bends_.assign(1, dense_.front());
    for_bends(dense_, [&](const StrandPoint& at) { bends_.push_back(at); });
    return bends_;
}
} // namespace tyndall
