// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/row_query.hpp"
#include "core/huge_pages.hpp"
#include "core/parallel.hpp"
#include "light_shafts/slope_rows_kernels.hpp"
#include <algorithm>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/row_query.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/row_query_lane-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Calls toggle(line) wherever lit and dark change, beginning dark; only lines of whole blocks around [first, last].
template <class Toggle>
static HWY_INLINE bool scan(const RowView& row, float slope_value, std::int32_t first, std::int32_t last,
                            const Toggle& toggle) {
    const auto slope = hn::Set(lines_tag, slope_value);
    const std::int32_t first_block = (first - row.first) / block_lines, last_block = (last - row.first) / block_lines;
    std::uint32_t is_lit = 0; // 0 or 1
    for (std::int32_t group = first_block; group <= last_block; group += 16) {
        const std::uint32_t used = last_block - group >= 15 ? 0xffffu : (1u << (last_block - group + 1)) - 1;
        const std::uint32_t all_lit = at_or_above(slope, row.highest + group);
        const std::uint32_t all_dark = ~at_or_above(slope, row.lowest + group);
        std::uint32_t left = used & ~(is_lit ? all_lit : all_dark);
        while (left != 0) {
            const auto block = static_cast<std::uint32_t>(__builtin_ctz(left));
            const std::int32_t line = row.first + (group + static_cast<std::int32_t>(block)) * block_lines;
            if ((is_lit ? all_dark : all_lit) >> block & 1) {
                toggle(line);
                is_lit ^= 1;
            } else {
                const std::uint32_t lit = at_or_above(slope, row.slopes + (line - row.first));
                for (std::uint32_t changes = (lit ^ (lit << 1 | is_lit)) & 0xffffu; changes != 0;
                     changes &= changes - 1)
                    toggle(line + __builtin_ctz(changes));
                is_lit = lit >> 15;
            }
            left = used & ~(is_lit ? all_lit : all_dark) & ~((2u << block) - 1);
        }
    }
    return is_lit != 0;
}

void lit_runs_of(const RowView& row, float slope, std::int32_t first, std::int32_t last,
                 std::vector<std::int32_t>& borders) {
    const bool ends_lit = scan(row, slope, first, last, [&](std::int32_t line) { borders.push_back(line); });
    if (ends_lit)
        borders.push_back(last + 1);
}

/// Distance along a ray at which it crosses the light line X.
struct Crossing {
    float numerator, numerator_x, denominator, denominator_x;
    Crossing(const Frame& frame, const PlacedRays& placed, std::size_t i)
        : numerator(frame.x.at(placed.axial[i], placed.radial[i])),
          numerator_x(frame.w.at(placed.axial[i], placed.radial[i])),
          denominator(frame.x.per_axial * placed.axial_per_m[i] + frame.x.per_radial * placed.radial_per_m[i]),
          denominator_x(frame.w.per_radial * placed.radial_per_m[i]) {}
    [[nodiscard]] float at(float x) const { return (numerator - x * numerator_x) / (x * denominator_x - denominator); }
};

static void answer(const Rows& rows, const PlacedRays& placed, const RowHits& hits, std::size_t i, const ViewRay& ray,
                   std::uint32_t index, LitRows& lit, row_query::Uncovered& uncovered) {
    const Layout& layout = rows.layout;
    const Frame& frame = layout.frame;
    const auto cover = static_cast<Cover>(hits.cover[i]);
    const RowHit hit = hits.hit(i);
    if (cover != Cover::Rows) {
        (cover == Cover::NearEpipole ? uncovered.near_epipole : uncovered.outside).push_back(index);
        return;
    }
    const Crossing crossing(frame, placed, i);
    float near_m = 0.0f;
    bool is_open = false;
    const auto toggle = [&](std::int32_t line) {
        if (!is_open)
            near_m = line <= hit.first ? ray.near_m : crossing.at(layout.x_at_edge[static_cast<std::size_t>(line)]);
        else if (line > hit.first) {
            const float far_m =
                line > hit.last ? ray.far_m : crossing.at(layout.x_at_edge[static_cast<std::size_t>(line)]);
            if (near_m < far_m)
                lit.intervals.push_back({.near_m = near_m, .far_m = far_m});
        }
        is_open = !is_open;
        if (is_open && line > hit.last)
            near_m = ray.far_m;
    };
    if (scan(rows.row(hit.slice), placed.slope[i], hit.first, hit.last, toggle) && near_m < ray.far_m)
        lit.intervals.push_back({.near_m = near_m, .far_m = ray.far_m});
}

void lit_intervals_of(const Rows& rows, const ViewRay* rays, std::size_t count, LitRows& lit,
                      row_query::Uncovered& uncovered) {
    if (rows.layout.rows.empty()) {
        for (std::uint32_t i = 0; i < count; ++i) {
            if (rays[i].near_m < rays[i].far_m)
                uncovered.outside.push_back(i);
            lit.end_ray();
        }
        return;
    }
    PlacedRays placed;
    RowHits hits;
    for (std::size_t start = 0; start < count; start += PlacedRays::capacity) {
        const std::size_t block = std::min(PlacedRays::capacity, count - start);
        place_rays(rows.layout.frame, {rays + start, block}, placed);
        find_rows(rows.layout, placed, block, hits);
        for (std::size_t i = 0; i < block; ++i) {
            if (rays[start + i].near_m < rays[start + i].far_m)
                answer(rows, placed, hits, i, rays[start + i], static_cast<std::uint32_t>(start + i), lit, uncovered);
            lit.end_ray();
        }
    }
}

/// The slices nearest to rays, those of rows that exist.
void find_slices_of(const Layout& layout, const ViewRay* rays, const std::uint32_t* asked, std::size_t ray_count,
                    std::int32_t* slices) {
    static constexpr hn::RebindToSigned<LineTag> di;
    const auto d = lines_tag;
    const auto last = hn::Set(d, static_cast<float>(layout.slice_count() - 1));
    alignas(64) std::array<std::int32_t, PlacedRays::capacity> found;
    PlacedRays placed;
    std::array<ViewRay, PlacedRays::capacity> some;
    for (std::size_t start = 0; start < ray_count; start += PlacedRays::capacity) {
        const std::size_t count = std::min(PlacedRays::capacity, ray_count - start);
        if (asked != nullptr)
            for (std::size_t i = 0; i < count; ++i)
                some[i] = rays[asked[start + i]];
        const std::span<const ViewRay> block{asked != nullptr ? some.data() : rays + start, count};
        place_rays(layout.frame, block, placed);
        for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
            const auto slice = slices_at(layout, hn::Load(d, &placed.slice_coordinate[i]));
            hn::Store(hn::ConvertTo(di, hn::Min(hn::Max(slice, hn::Zero(d)), last)), di, &found[i]);
        }
        std::copy_n(found.begin(), count, slices + start);
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(lit_runs_of);
HWY_EXPORT(lit_intervals_of);
HWY_EXPORT(find_slices_of);
} // namespace tyndall::light_shafts

namespace tyndall::light_shafts::row_query {
void lit_intervals(const slope_rows::Rows& rows, std::span<const ViewRay> rays, LitRows& lit, Uncovered& uncovered) {
    HWY_DYNAMIC_DISPATCH(lit_intervals_of)(rows, rays.data(), rays.size(), lit, uncovered);
}
/// Of a wedge: pieces of the picture that stay in the cache, slice by slice within each. `slice_in_wedge` of each ray.
static void sort_by_slice(std::span<std::uint32_t> order, std::span<const std::uint8_t> slice_in_wedge) {
    constexpr std::size_t rays_at_once = 256 * slices_per_wedge;
    std::array<std::uint32_t, rays_at_once> unsorted;
    for (std::size_t start = 0; start < order.size(); start += rays_at_once) {
        const auto some = order.subspan(start, std::min(rays_at_once, order.size() - start));
        const auto slices = slice_in_wedge.subspan(start, some.size());
        std::array<std::uint32_t, slices_per_wedge> next{};
        for (const std::uint8_t slice : slices)
            ++next[slice];
        std::uint32_t total = 0;
        for (std::uint32_t& first : next)
            total += std::exchange(first, total);
        std::ranges::copy(some, unsorted.begin());
        for (std::size_t i = 0; i < some.size(); ++i)
            some[next[slices[i]]++] = unsorted[i];
    }
}

std::vector<std::uint32_t> by_wedge(const slope_rows::Layout& layout, std::span<const ViewRay> rays,
                                    const Progress& progress, std::int32_t slices_per_row,
                                    std::span<const std::uint32_t> asked) {
    if (layout.rows.empty())
        return {};
    const std::size_t ray_count = asked.empty() ? rays.size() : asked.size();
    const std::size_t wedge_count =
        layout.rows.size() / static_cast<std::size_t>(slices_per_row) / slices_per_wedge + 1;
    // Counts per block and wedge: a block knows where its rays of a wedge go, and all blocks are dealt out at once.
    constexpr std::size_t rays_per_block = std::size_t{1} << 15;
    std::vector<std::vector<std::uint32_t>> next((ray_count + rays_per_block - 1) / rays_per_block);
    auto slice_of = large_vector<std::int32_t>(ray_count);
    auto order = large_vector<std::uint32_t>(ray_count);
    auto slice_in_wedge = large_vector<std::uint8_t>(ray_count); // in the order of `order`
    const auto wedge_of = [&](std::size_t ray) { return static_cast<std::uint32_t>(slice_of[ray]) / slices_per_wedge; };
    parallel_blocks(ray_count, rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t>& counts = next[begin / rays_per_block];
        counts.assign(wedge_count, 0);
        HWY_DYNAMIC_DISPATCH(find_slices_of)
        (layout, rays.data() + (asked.empty() ? begin : 0), asked.empty() ? nullptr : &asked[begin], end - begin,
         &slice_of[begin]);
        if (slices_per_row > 1)
            for (std::size_t ray = begin; ray < end; ++ray)
                slice_of[ray] /= slices_per_row;
        for (std::size_t ray = begin; ray < end; ++ray)
            ++counts[wedge_of(ray)];
    });
    std::uint32_t total = 0;
    std::vector<std::uint32_t> first_of_wedge;
    for (std::size_t wedge = 0; wedge < wedge_count; ++wedge) {
        first_of_wedge.push_back(total);
        for (auto& counts : next)
            total += std::exchange(counts[wedge], total);
    }
    first_of_wedge.push_back(total);
    parallel_blocks(ray_count, rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t ray = begin; ray < end; ++ray) {
            const std::uint32_t place = next[begin / rays_per_block][wedge_of(ray)]++;
            order[place] = asked.empty() ? static_cast<std::uint32_t>(ray) : asked[ray];
            slice_in_wedge[place] =
                static_cast<std::uint8_t>(static_cast<std::uint32_t>(slice_of[ray]) % slices_per_wedge);
        }
    });
    parallel_for(
        wedge_count, progress,
        [&](std::size_t wedge) {
            const std::uint32_t first = first_of_wedge[wedge], count = first_of_wedge[wedge + 1] - first;
            sort_by_slice(std::span(order).subspan(first, count), std::span(slice_in_wedge).subspan(first, count));
        },
        16);
    return order;
}
void lit_runs(const slope_rows::RowView& row, float slope, std::int32_t first, std::int32_t last,
              std::vector<std::int32_t>& borders) {
    std::vector<std::int32_t> toggles;
    HWY_DYNAMIC_DISPATCH(lit_runs_of)(row, slope, first, last, toggles);
    for (std::size_t i = 0; i + 1 < toggles.size(); i += 2) {
        const std::int32_t begin = std::max(toggles[i], first), end = std::min(toggles[i + 1], last + 1);
        if (begin < end) {
            borders.push_back(begin);
            borders.push_back(end);
        }
    }
}
} // namespace tyndall::light_shafts::row_query
#endif
