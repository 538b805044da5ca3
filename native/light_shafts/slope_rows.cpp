// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/slope_rows.hpp"
#include "core/parallel.hpp"
#include "light_shafts/slope_rows_kernels.hpp"
#include <algorithm>
#include <array>
#include <bitset>
#include <numbers>

namespace tyndall::light_shafts::slope_rows {
static constexpr std::size_t spans_per_task = 1 << 14;
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

namespace {
/// What rows need of a part of a span, whose ends are less than widest_rad apart around the axis.
struct SpanPart {
    float low, width;            ///< Slice coordinates that it covers.
    float first_line, last_line; ///< Metres or radians.
    float slope;                 ///< The least.
    /// How far its rays are from the epipole, at most: the radius they gain per metre, or keep where they run along the axis.
    float radius;
};
using SpanParts = std::vector<std::vector<SpanPart>>; ///< Per task.
constexpr float widest_rad = 0.25f;

/// Between its ends the slope is a cosine of the angle, A cos(p - p0), so that it falls below both of them by at most their
/// distance's 1 / cos(width / 2).
SpanPart part_between(const Frame& frame, const PlacedRays& placed, std::size_t first, std::size_t last) {
    float to_last = placed.slice_coordinate[last] - placed.slice_coordinate[first];
    if (!frame.is_parallel)
        to_last -= turn_rad * std::rint(to_last * (1 / turn_rad));
    const PlacedRays::Column& radius = frame.is_orthographic ? placed.radial : placed.radial_per_m;
    SpanPart part{.low = placed.slice_coordinate[first] + std::min(to_last, 0.0f),
                  .width = std::abs(to_last),
                  .first_line = std::min(placed.near_line[first], placed.near_line[last]),
                  .last_line = std::max(placed.far_line[first], placed.far_line[last]),
                  .slope = std::min(placed.slope[first], placed.slope[last]),
                  .radius = std::max(radius[first], radius[last])};
    const float excess = frame.is_parallel ? 0.0f : 0.14f * std::min(part.width * part.width, 1.0f);
    part.slope -= excess * std::abs(part.slope);
    if (frame.is_angular) {
        part.first_line -= excess * part.first_line;
        part.last_line += excess * (turn_rad / 2 - part.last_line);
    } else if (!frame.is_parallel) {
        part.first_line -= excess * part.first_line;
    }
    return part;
}

/// Close to the axis a few pixels are half a turn apart: what lies between is placed ray by ray.
void append_parts(const Frame& frame, const RaySpan& span, std::vector<SpanPart>& parts) {
    constexpr std::size_t part_count = 32;
    std::array<ViewRay, part_count + 1> rays;
    for (std::size_t i = 0; i <= part_count; ++i) {
        const float t = static_cast<float>(i) / part_count;
        rays[i] = span.first;
        rays[i].origin = glm::mix(span.first.origin, span.last.origin, t);
        rays[i].direction = glm::normalize(glm::mix(span.first.direction, span.last.direction, t));
    }
    PlacedRays placed;
    place_rays(frame, rays, placed);
    for (std::size_t i = 0; i < part_count; ++i)
        parts.push_back(part_between(frame, placed, i, i + 1));
}

SpanParts place_spans(const Frame& frame, std::span<const RaySpan> spans, const Progress& progress) {
    static_assert(sizeof(RaySpan) == 2 * sizeof(ViewRay));
    constexpr std::size_t spans_per_block = PlacedRays::capacity / 2;
    SpanParts parts((spans.size() + spans_per_task - 1) / spans_per_task);
    parallel_blocks(spans.size(), spans_per_task, progress, [&](std::size_t begin, std::size_t end) {
        std::vector<SpanPart>& of_task = parts[begin / spans_per_task];
        of_task.reserve(end - begin);
        PlacedRays placed;
        for (std::size_t start = begin; start < end; start += spans_per_block) {
            const auto block = spans.subspan(start, std::min(spans_per_block, end - start));
            place_rays(frame, {&block.front().first, 2 * block.size()}, placed);
            for (std::size_t i = 0; i < block.size(); ++i) {
                if (!(block[i].first.near_m < block[i].first.far_m))
                    continue;
                const SpanPart part = part_between(frame, placed, 2 * i, 2 * i + 1);
                if (frame.is_parallel || part.width < widest_rad)
                    of_task.push_back(part);
                else
                    append_parts(frame, block[i], of_task);
            }
        }
    });
    return parts;
}
} // namespace

static Needs find_needs(const Frame& frame, const SpanParts& parts, const Progress& progress) {
    return parallel_sum(parts.size(), 1, Needs{}, progress, [&](std::size_t task, std::size_t) {
        Needs needs;
        for (const SpanPart& part : parts[task]) {
            needs.lowest_line = std::min(needs.lowest_line, part.first_line);
            needs.highest_line = std::max(needs.highest_line, part.last_line);
            needs.lowest_slice = std::min(needs.lowest_slice, part.low);
            needs.highest_slice = std::max(needs.highest_slice, part.low + part.width);
            needs.largest_radius = std::max(needs.largest_radius, part.radius);
            if (frame.is_parallel)
                continue;
            // Angles are above -1.5 turns; the last sector is the first one again.
            constexpr std::size_t turn = sector_count - 1;
            std::size_t sector = static_cast<std::size_t>((part.low * (1 / turn_rad) + 1.5f) * turn);
            std::size_t last = static_cast<std::size_t>(((part.low + part.width) * (1 / turn_rad) + 1.5f) * turn);
            for (; sector >= turn; last -= turn)
                sector -= turn;
            for (; sector <= last; ++sector)
                needs.sectors.set(sector < turn ? sector : sector - turn);
        }
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

static std::vector<GroupNeeds> find_group_needs(const Layout& layout, std::int32_t slice_count, const SpanParts& parts,
                                                const Progress& progress) {
    const auto group_count = static_cast<std::size_t>(slice_count / group_slices + 1);
    std::vector<std::vector<GroupNeeds>> per_task(parts.size());
    const auto find = [&](std::size_t task) {
        std::vector<GroupNeeds>& groups = per_task[task];
        groups.resize(group_count);
        for (const SpanPart& part : parts[task]) {
            if (!layout.frame.is_parallel && part.radius < layout.smallest_radius)
                continue;
            const auto grow = [&](std::int32_t first, std::int32_t last) {
                first = std::max(first, 0);
                last = std::min(last, slice_count - 1);
                for (std::int32_t g = first / group_slices; first <= last && g <= last / group_slices; ++g)
                    groups[static_cast<std::size_t>(g)].grow({part.first_line, part.last_line, part.slope});
            };
            const std::int32_t first = nearest_slice(layout, part.low);
            const std::int32_t last = first + static_cast<std::int32_t>(part.width / layout.slice_step) + 1;
            grow(first, last);
            grow(first - layout.slices_per_turn, last - layout.slices_per_turn);
        }
    };
    parallel_for(parts.size(), progress, find, 1);
    std::vector<GroupNeeds> groups(group_count);
    for (const auto& of_task : per_task)
        for (std::size_t g = 0; g < group_count; ++g)
            groups[g].grow(of_task[g]);
    return groups;
}

static void place_rows(Layout& layout, std::int32_t slice_count, const std::vector<GroupNeeds>& groups,
                       const LayoutConfig& config) {
    layout.rows.assign(static_cast<std::size_t>(slice_count), {});
    layout.slice_directions.assign(static_cast<std::size_t>(slice_count) + 16, vec2(1, 0));
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
            const float first = (needs.first - config.margin_before - layout.first_line) / layout.line_step - 2.0f;
            const float last = (needs.last + config.margin_after - layout.first_line) / layout.line_step + 2.0f;
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
    return make_layout(frame, outline(frame.is_orthographic, rays, progress), config, progress);
}

Layout make_layout(const Frame& frame, std::span<const RaySpan> spans, const LayoutConfig& config,
                   const Progress& progress) {
    Layout layout;
    layout.frame = frame;
    layout.room = config.room;
    const SpanParts parts = place_spans(frame, spans, progress);
    Needs needs = find_needs(frame, parts, progress);
    if (!(needs.lowest_line <= needs.highest_line))
        return layout;
    needs.lowest_line -= config.margin_before;
    needs.highest_line += config.margin_after;
    for (auto lines = static_cast<float>(config.lines);; lines *= 0.8f) {
        place_lines(layout, needs, static_cast<std::uint32_t>(lines));
        const std::int32_t slice_count = place_slices(layout, needs, config.slices_per_line);
        place_rows(layout, slice_count, find_group_needs(layout, slice_count, parts, progress), config);
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

void Rows::take_room() {
    if (layout.room && !room_taken)
        room_taken =
            MemoryRoom::take(layout.room, bytes(), "the maps and rows of light shafts",
                             "render a region or at a lower resolution, or give light shafts a larger error or "
                             "fewer samples of lights");
}
} // namespace tyndall::light_shafts::slope_rows
