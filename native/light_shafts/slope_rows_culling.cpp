// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/slope_rows_culling.hpp"
#include <algorithm>

namespace tyndall::light_shafts::slope_rows {
static constexpr std::int32_t culled_slices = 32;

static void grow(SliceNeeds& needs, const SliceNeeds& other) {
    needs.first_line = std::min(needs.first_line, other.first_line);
    needs.last_line = std::max(needs.last_line, other.last_line);
    needs.smallest_slope = std::min(needs.smallest_slope, other.smallest_slope);
}

Culling::Culling(const Layout& layout) : layout_(layout) {
    groups_.resize((layout.rows.size() + culled_slices - 1) / culled_slices);
    const auto line = [&](std::int32_t i) { return layout.first_line + static_cast<float>(i) * layout.line_step; };
    for (std::size_t s = 0; s < layout.rows.size(); ++s) {
        const RowExtent& row = layout.rows[s];
        if (row.first < row.end)
            grow(groups_[s / culled_slices],
                 {.first_line = line(row.first), .last_line = line(row.end), .smallest_slope = row.smallest_slope});
    }
}

SliceNeeds Culling::needs_between(std::int32_t first, std::int32_t end) const {
    SliceNeeds needs{.first = first, .end = end};
    if (first < end)
        for (std::int32_t group = first / culled_slices; group <= (end - 1) / culled_slices; ++group)
            grow(needs, groups_[static_cast<std::size_t>(group)]);
    return needs;
}

namespace {
/// Largest and smallest value of a quotient that rises or falls steadily in both coordinates of a rectangle.
struct Extremes {
    float least, most;
    Extremes(const Linear& over, const Linear& under, const vec2& a, const vec2& r) {
        least = std::numeric_limits<float>::infinity();
        most = -least;
        for (const float along : {a.x, a.y})
            for (const float across : {r.x, r.y}) {
                const float value = over.at(along, across) / under.at(along, across);
                least = std::min(least, value);
                most = std::max(most, value);
            }
    }
};
} // namespace

SliceNeeds Culling::needs_of_box(const vec3& centre, const vec3& half_extent, std::int32_t first,
                                 std::int32_t end) const {
    const Frame& frame = layout_.frame;
    vec2 r;
    SliceNeeds needs;
    const auto slices = [&](float from, float to) { // rounded outwards, within [first, end)
        const auto low = static_cast<std::int32_t>(std::clamp(std::floor(from), -1.0f, 1e8f));
        const auto high = static_cast<std::int32_t>(std::clamp(std::ceil(to), -1.0f, 1e8f));
        grow(needs, needs_between(std::max(low, first), std::min(high + 1, end)));
    };
    if (frame.is_parallel) {
        r = vec2(centre.x - half_extent.x, centre.x + half_extent.x);
        slices((centre.y - half_extent.y - layout_.first_slice) / layout_.slice_step,
               (centre.y + half_extent.y - layout_.first_slice) / layout_.slice_step);
    } else {
        const float distance = std::hypot(centre.x, centre.y), radius = std::hypot(half_extent.x, half_extent.y);
        r = glm::max(vec2(distance - radius, distance + radius), vec2(layout_.smallest_radius_cut));
        if (!(distance > 1.0001f * radius)) {
            grow(needs, needs_between(first, end));
        } else {
            const float half_angle = std::asin(radius / distance) + 1e-6f;
            float low = std::atan2(centre.y, centre.x) - half_angle - layout_.first_slice;
            low -= 2 * pi * std::floor(low / (2 * pi));
            slices(low / layout_.slice_step, (low + 2 * half_angle) / layout_.slice_step);
            slices((low - 2 * pi) / layout_.slice_step, (low + 2 * half_angle - 2 * pi) / layout_.slice_step);
        }
    }
    if (!(needs.first_line <= needs.last_line))
        return {};
    const vec2 a(centre.z - half_extent.z, centre.z + half_extent.z);
    // Written so that a value which is no number keeps the box.
    if (Extremes(frame.y, frame.w, a, r).most < needs.smallest_slope)
        return {};
    if (frame.is_angular) {
        const Extremes x(frame.x, frame.w, a, r);
        if (x.least > frame.x_of_line(std::max(needs.first_line, 0.0f)) ||
            (needs.last_line < 3.14f && x.most < frame.x_of_line(needs.last_line)))
            return {};
    } else if (r.x > needs.last_line || r.y < needs.first_line) {
        return {};
    }
    needs.first = first;
    needs.end = end;
    return needs;
}
} // namespace tyndall::light_shafts::slope_rows
