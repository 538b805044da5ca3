// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/row_query_shares.hpp"
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/row_query_shares.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/row_query_lane-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Steps of one ray over the lines of a row.
struct StepsInRow {
    const float* slopes; ///< Of the row's line 0, were it there.
    float slope;
    float first_line, lines_per_step; ///< Where step 0 begins, in lines; may lie before the row.
    std::int32_t first, last;         ///< Lines that the ray crosses.
};

/// Steps that are shorter than 16 lines: the lines whose centres lie in them, or the one nearest to their middle.
static void find_short(const StepsInRow& ray, std::span<float> shares) {
    const auto slope = hn::Set(lines_tag, ray.slope);
    for (std::size_t step = 0; step < shares.size(); ++step) {
        const float begin = ray.first_line + static_cast<float>(step) * ray.lines_per_step;
        auto from = static_cast<std::int32_t>(std::floor(begin + 0.5f));
        auto past = static_cast<std::int32_t>(std::floor(begin + ray.lines_per_step + 0.5f));
        if (from >= past) {
            from = static_cast<std::int32_t>(std::floor(begin + 0.5f * ray.lines_per_step));
            past = from + 1;
        }
        from = std::clamp(from, ray.first, ray.last);
        past = std::clamp(past, from + 1, std::max(ray.last + 1, from + 1));
        // Lines behind the row's are those of the next one, or padding.
        const std::uint32_t lit = at_or_above(slope, ray.slopes + from) & ((1u << (past - from)) - 1);
        shares[step] = static_cast<float>(std::popcount(lit)) / static_cast<float>(past - from);
    }
}

/// Steps of at least 16 lines: groups of 16 in the middles of `group_count` parts of each.
static void find_long(const StepsInRow& ray, std::int32_t group_count, std::span<float> shares) {
    const auto slope = hn::Set(lines_tag, ray.slope);
    const float part = ray.lines_per_step / static_cast<float>(group_count),
                per_line = 1.0f / static_cast<float>(16 * group_count);
    float middle = ray.first_line + 0.5f * part - 7.5f;
    const std::int32_t most = std::max(ray.last - 15, ray.first);
    for (float& share : shares) {
        int count = 0;
        for (std::int32_t group = 0; group < group_count; ++group, middle += part) {
            const std::int32_t from = std::clamp(static_cast<std::int32_t>(middle), ray.first, most);
            count += std::popcount(at_or_above(slope, ray.slopes + from));
        }
        share = static_cast<float>(count) * per_line;
    }
}

void find_lit_shares_of(const Rows& rows, std::span<const ViewRay> rays, const StepRows& steps, std::span<float> shares,
                        row_query::Uncovered& uncovered) {
    PlacedRays placed;
    RowHits hits;
    const Layout& layout = rows.layout;
    const auto most_groups = static_cast<std::int32_t>(std::max(4u, 256 / std::max(1u, steps.step_count)));
    for (std::size_t start = 0; start < rays.size(); start += PlacedRays::capacity) {
        const std::size_t count = std::min(PlacedRays::capacity, rays.size() - start);
        if (!layout.rows.empty()) {
            place_rays(layout.frame, rays.subspan(start, count), placed);
            find_rows(layout, placed, count, hits);
        }
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t ray = start + i;
            const auto cover = layout.rows.empty() ? Cover::Outside : static_cast<Cover>(hits.cover[i]);
            if (cover != Cover::Rows) {
                (cover == Cover::NearEpipole ? uncovered.near_epipole : uncovered.outside)
                    .push_back(static_cast<std::uint32_t>(ray));
                continue;
            }
            const RowHit hit = hits.hit(i);
            const RowView row = rows.row(hit.slice);
            const float lines_per_m = placed.radial_per_m[i] / layout.line_step;
            StepsInRow in_row{.slopes = row.slopes - row.first,
                              .slope = placed.slope[i],
                              .first_line = hit.near_index + (steps.begin_m[ray] - placed.near_m[i]) * lines_per_m,
                              .lines_per_step = steps.step_m[ray] * lines_per_m,
                              .first = hit.first,
                              .last = hit.last};
            const std::span<float> own = shares.subspan(ray * steps.step_count, steps.step_count);
            if (in_row.lines_per_step < 16.0f || in_row.last - in_row.first < 15)
                find_short(in_row, own);
            else
                find_long(in_row, std::min(static_cast<std::int32_t>(in_row.lines_per_step / 16.0f), most_groups), own);
        }
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(find_lit_shares_of);
} // namespace tyndall::light_shafts

namespace tyndall::light_shafts::row_query {
void find_lit_shares(const slope_rows::Rows& rows, std::span<const ViewRay> rays, const StepRows& steps,
                     std::span<float> shares, Uncovered& uncovered) {
    HWY_DYNAMIC_DISPATCH(find_lit_shares_of)(rows, rays, steps, shares, uncovered);
}
} // namespace tyndall::light_shafts::row_query
#endif
