// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/slope_rows.hpp"
#include "core/parallel.hpp"
#include "light_shafts/slope_rows_kernels.hpp"
#include <algorithm>
#include <bitset>
#include <numbers>

namespace tyndall::light_shafts::slope_rows {
static constexpr std::size_t rays_per_block = 1 << 15;
static constexpr std::size_t sector_count = 1024;
static constexpr float turn_rad = 2 * std::numbers::pi_v<float>;

/// What all rays together need.
struct Needs {
    float lowest_line = std::numeric_limits<float>::infinity(), highest_line = -lowest_line;
    float lowest_slice = lowest_line, highest_slice = highest_line;
    float largest_radius = 0.0f;
    std::bitset<sector_count> sectors; ///< Of the turn around the axis that hold a ray.

    Needs& operator+=(const Needs& other) {
        lowest_line = std::min(lowest_line, other.lowest_line);
        highest_line = std::max(highest_line, other.highest_line);
        lowest_slice = std::min(lowest_slice, other.lowest_slice);
        highest_slice = std::max(highest_slice, other.highest_slice);
        largest_radius = std::max(largest_radius, other.largest_radius);
        sectors |= other.sectors;
        return *this;
    }
};

/// How far a ray is from the epipole: the radius it gains per metre, or keeps where rays run along the axis.
static float radius_of(const Frame& frame, const PlacedRays& placed, std::size_t i) {
    return frame.is_orthographic ? placed.radial[i] : placed.radial_per_m[i];
}

template <typename Work>
static void for_placed_rays(const Frame& frame, std::span<const ViewRay> rays, const Work& work) {
    PlacedRays placed;
    for (std::size_t start = 0; start < rays.size(); start += PlacedRays::capacity) {
        const auto block = rays.subspan(start, std::min(PlacedRays::capacity, rays.size() - start));
        place_rays(frame, block, placed);
        for (std::size_t i = 0; i < block.size(); ++i)
            if (block[i].near_m < block[i].far_m)
                work(placed, i);
    }
}

static Needs find_needs(const Frame& frame, std::span<const ViewRay> rays, const Progress& progress) {
    return parallel_sum(rays.size(), rays_per_block, Needs{}, progress, [&](std::size_t begin, std::size_t end) {
        Needs needs;
        for_placed_rays(frame, rays.subspan(begin, end - begin), [&](const PlacedRays& placed, std::size_t i) {
            needs.lowest_line = std::min(needs.lowest_line, placed.near_line[i]);
            needs.highest_line = std::max(needs.highest_line, placed.far_line[i]);
            const float slice = placed.slice_coordinate[i];
            needs.lowest_slice = std::min(needs.lowest_slice, slice);
            needs.highest_slice = std::max(needs.highest_slice, slice);
            needs.largest_radius = std::max(needs.largest_radius, radius_of(frame, placed, i));
            if (!frame.is_parallel)
                needs.sectors.set(static_cast<std::size_t>((slice / turn_rad + 0.5f) * (sector_count - 1)));
        });
        return needs;
    });
}

/// The turn without its largest empty part: first angle and width.
static std::pair<float, float> occupied_wedge(const std::bitset<sector_count>& sectors) {
    std::size_t longest = 0, wedge_start = 0, gap = 0;
    for (std::size_t i = 0; i < 2 * sector_count && sectors.any(); ++i) {
        gap = sectors[i % sector_count] ? 0 : gap + 1;
        if (gap > longest) {
            longest = gap;
            wedge_start = (i + 1) % sector_count;
        }
    }
    constexpr float sector_rad = turn_rad / (sector_count - 1);
    if (longest < 4)
        return {-turn_rad / 2, turn_rad};
    return {-turn_rad / 2 + (static_cast<float>(wedge_start) - 1.0f) * sector_rad,
            static_cast<float>(sector_count - longest + 2) * sector_rad};
}

static std::int32_t place_slices(Layout& layout, const Needs& needs, float slices_per_line) {
    const float border = layout.frame.is_angular ? 1.0f : needs.highest_line;
    if (layout.frame.is_parallel) {
        layout.slice_step = layout.line_step / slices_per_line;
        layout.first_slice = needs.lowest_slice - layout.slice_step;
        return static_cast<std::int32_t>((needs.highest_slice - layout.first_slice) / layout.slice_step) + 2;
    }
    const auto [first_rad, width_rad] = occupied_wedge(needs.sectors);
    layout.slices_per_turn =
        static_cast<std::int32_t>(std::clamp(turn_rad * border / layout.line_step * slices_per_line, 16.0f, 4e6f));
    layout.slice_step = turn_rad / static_cast<float>(layout.slices_per_turn);
    layout.first_slice = first_rad;
    return std::min(static_cast<std::int32_t>(width_rad / layout.slice_step) + 2, layout.slices_per_turn);
}

static void place_lines(Layout& layout, const Needs& needs, std::uint32_t lines) {
    const Frame& frame = layout.frame;
    const bool starts_at_axis = !frame.is_parallel && !frame.is_angular;
    layout.first_line = starts_at_axis ? 0.0f : needs.lowest_line;
    const float length = std::max(needs.highest_line - layout.first_line, 1e-30f);
    layout.line_step = length / static_cast<float>(lines);
    if (!starts_at_axis) { // two lines of margin, but never past the angles 0 and pi, where X is infinite
        layout.first_line -= 2 * layout.line_step;
        if (frame.is_angular)
            layout.first_line = std::max(layout.first_line, 0.0f);
    }
    layout.line_count = static_cast<std::int32_t>(lines) + 4;
    if (frame.is_angular)
        layout.line_count = std::min(layout.line_count,
                                     static_cast<std::int32_t>((turn_rad / 2 - layout.first_line) / layout.line_step));
    layout.smallest_radius = frame.is_parallel ? 0.0f : near_epipole * needs.largest_radius;
    layout.smallest_radius_cut = starts_at_axis ? 0.25f * layout.line_step : 1e-6f / frame.angle_scale;
    if (frame.is_angular && frame.is_orthographic)
        layout.smallest_radius_cut = 1e-6f * needs.largest_radius;
    const std::int32_t padded = (layout.line_count + block_lines - 1) / block_lines * block_lines;
    const auto line = [&](float i) { return layout.first_line + i * layout.line_step; };
    layout.x_at_centre.clear();
    layout.x_at_edge.clear();
    for (std::int32_t i = 0; i < padded; ++i)
        layout.x_at_centre.push_back(
            frame.x_of_line(line(static_cast<float>(std::min(i, layout.line_count - 1)) + 0.5f)));
    for (std::int32_t i = 0; i <= layout.line_count; ++i)
        layout.x_at_edge.push_back(frame.x_of_line(line(static_cast<float>(i))));
}

/// Lines and slopes that the rays of a group of slices need.
struct GroupNeeds {
    float first = std::numeric_limits<float>::infinity(), last = -first, smallest_slope = first;
    void grow(const GroupNeeds& other) {
        first = std::min(first, other.first);
        last = std::max(last, other.last);
        smallest_slope = std::min(smallest_slope, other.smallest_slope);
    }
};
static constexpr std::int32_t group_slices = 8;

static std::vector<GroupNeeds> find_group_needs(const Layout& layout, std::int32_t slice_count,
                                                std::span<const ViewRay> rays, const Progress& progress) {
    const auto group_count = static_cast<std::size_t>(slice_count / group_slices + 1);
    const std::size_t block_count = (rays.size() + rays_per_block - 1) / rays_per_block;
    std::vector<std::vector<GroupNeeds>> per_block(block_count);
    parallel_blocks(rays.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        std::vector<GroupNeeds>& groups = per_block[begin / rays_per_block];
        groups.resize(group_count);
        for_placed_rays(layout.frame, rays.subspan(begin, end - begin), [&](const PlacedRays& placed, std::size_t i) {
            if (!layout.frame.is_parallel && radius_of(layout.frame, placed, i) < layout.smallest_radius)
                return;
            const std::int32_t slice = nearest_slice(layout, placed.slice_coordinate[i]);
            if (slice < 0 || slice >= slice_count)
                return;
            groups[static_cast<std::size_t>(slice / group_slices)].grow(
                {placed.near_line[i], placed.far_line[i], placed.slope[i]});
        });
    });
    std::vector<GroupNeeds> groups(group_count);
    for (const auto& block : per_block)
        for (std::size_t g = 0; g < group_count && !block.empty(); ++g)
            groups[g].grow(block[g]);
    return groups;
}

static void place_rows(Layout& layout, std::int32_t slice_count, const std::vector<GroupNeeds>& groups) {
    layout.rows.assign(static_cast<std::size_t>(slice_count), {});
    layout.slice_directions.assign(static_cast<std::size_t>(slice_count), vec2(1, 0));
    layout.sample_count = 0;
    const std::int32_t padded = static_cast<std::int32_t>(layout.x_at_centre.size());
    for (std::size_t s = 0; s < layout.rows.size(); ++s) {
        // Neighbouring groups are included: rays of the same frame that were not announced lie a fraction of a pixel
        // off, where the surface behind may be much farther.
        GroupNeeds needs;
        const std::size_t group = s / group_slices;
        for (std::size_t g = group - (group > 0); g <= std::min(group + 1, groups.size() - 1); ++g)
            needs.grow(groups[g]);
        RowExtent& row = layout.rows[s];
        row.offset = layout.sample_count;
        if (needs.first <= needs.last) {
            const float first = (needs.first - layout.first_line) / layout.line_step - 2.0f;
            const float last = (needs.last - layout.first_line) / layout.line_step + 2.0f;
            row.first = std::clamp(static_cast<std::int32_t>(first), 0, padded - 1) / block_lines * block_lines;
            row.end = std::clamp((static_cast<std::int32_t>(last) / block_lines + 1) * block_lines, row.first, padded);
            row.smallest_slope = needs.smallest_slope - 1e-3f * std::abs(needs.smallest_slope);
        }
        layout.sample_count += static_cast<std::size_t>(row.end - row.first);
        if (!layout.frame.is_parallel) {
            const double angle = double{layout.first_slice} + double{layout.slice_step} * static_cast<double>(s);
            layout.slice_directions[s] = vec2(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
        }
    }
}

std::int32_t nearest_slice(const Layout& layout, float slice_coordinate) {
    float slice = (slice_coordinate - layout.first_slice) / layout.slice_step;
    const auto turn = static_cast<float>(layout.slices_per_turn);
    if (layout.slices_per_turn > 0 && slice < -0.5f)
        slice += turn;
    if (layout.slices_per_turn > 0 && slice >= turn - 0.5f)
        slice -= turn;
    return static_cast<std::int32_t>(std::floor(std::clamp(slice, -1e6f, 1e7f) + 0.5f));
}

Layout make_layout(const Frame& frame, std::span<const ViewRay> rays, const LayoutConfig& config,
                   const Progress& progress) {
    Layout layout;
    layout.frame = frame;
    const Needs needs = find_needs(frame, rays, progress);
    if (!(needs.lowest_line <= needs.highest_line))
        return layout;
    for (auto lines = static_cast<float>(config.lines);; lines *= 0.8f) {
        place_lines(layout, needs, static_cast<std::uint32_t>(lines));
        const std::int32_t slice_count = place_slices(layout, needs, config.slices_per_line);
        place_rows(layout, slice_count, find_group_needs(layout, slice_count, rays, progress));
        if (layout.sample_count * 9 / 2 <= config.memory_limit_bytes || lines < 32.0f)
            return layout;
    }
}

Rows::Rows(Layout layout_to_keep)
    : layout(std::move(layout_to_keep)),
      slopes(static_cast<float*>(::operator new[](layout.sample_count * sizeof(float) + 64, std::align_val_t{64}))) {
    // queries read whole vectors of blocks
    const std::size_t blocks = layout.sample_count / block_lines + block_lines;
    lowest = std::make_unique<float[]>(blocks);
    highest = std::make_unique<float[]>(blocks);
}
} // namespace tyndall::light_shafts::slope_rows
