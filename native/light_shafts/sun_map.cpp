// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/sun_map.hpp"
#include "core/parallel.hpp"
#include "light_shafts/map_cache.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
using namespace slope_rows;

static constexpr std::int32_t anchor_texels = 4096;
/// Beyond, a float has too few digits left for the place within a texel.
static constexpr float most_countable = 1 << 20;

static std::int32_t round_down(std::int32_t value, std::int32_t step) { return value - (value % step + step) % step; }
static std::int32_t round_up(std::int32_t value, std::int32_t step) { return -round_down(-value, step); }

float rounded_up(float value) { return std::exp2(std::ceil(4.0f * std::log2(value)) / 4.0f); }

float snapped_texel(const MapWindow& window, std::uint32_t resolution) {
    const vec2 size = window.max - window.min;
    return rounded_up(std::max({size.x, size.y, 1e-30f}) / static_cast<float>(resolution));
}

std::optional<TexelRange> texels_in(const MapWindow& window, float texel) {
    const vec2 first = glm::floor(window.min / texel), end = glm::ceil(window.max / texel);
    for (const float edge : {first.x, first.y, end.x, end.y})
        if (!(std::abs(edge) < most_countable))
            return std::nullopt;
    TexelRange range{glm::ivec2(first), glm::max(glm::ivec2(end), glm::ivec2(first) + 1)};
    range.first.x = round_down(range.first.x, block_lines);
    range.end.x = round_up(range.end.x, block_lines);
    return range;
}

/// Rows of a range in units of texels.
static Layout texel_layout(const MapAxes& axes, float texel, const TexelRange& range) {
    Layout layout;
    layout.frame = frame_across(axes);
    layout.frame.u /= texel;
    layout.frame.v /= texel;
    const std::int32_t anchor = round_down(range.first.x, anchor_texels);
    layout.first_line = static_cast<float>(anchor);
    layout.line_count = range.end.x - anchor;
    layout.first_slice = static_cast<float>(range.first.y) + 0.5f;
    layout.rows.resize(static_cast<std::size_t>(range.end.y - range.first.y));
    layout.slice_directions.assign(layout.rows.size(), vec2(1, 0));
    const auto width = static_cast<std::size_t>(range.end.x - range.first.x);
    for (std::size_t y = 0; y < layout.rows.size(); ++y)
        layout.rows[y] = {.first = range.first.x - anchor,
                          .end = range.end.x - anchor,
                          .offset = y * width,
                          .smallest_slope = no_occluder};
    for (std::int32_t x = 0; x < layout.line_count; ++x)
        layout.x_at_centre.push_back(layout.first_line + static_cast<float>(x) + 0.5f);
    layout.sample_count = layout.rows.size() * width;
    return layout;
}

static TexelRange range_of(const Layout& layout) {
    const auto anchor = static_cast<std::int32_t>(layout.first_line);
    const auto bottom = static_cast<std::int32_t>(std::floor(layout.first_slice));
    return {{anchor + layout.rows.front().first, bottom},
            {anchor + layout.rows.front().end, bottom + layout.slice_count()}};
}

/// More on every side, up to where lines are counted from.
static TexelRange grown(const TexelRange& range) {
    const glm::ivec2 more = (range.end - range.first) / 8;
    TexelRange result{range.first - more, range.end + more};
    result.first.x = std::max(round_down(result.first.x, block_lines), round_down(range.first.x, anchor_texels));
    result.end.x = round_up(result.end.x, block_lines);
    return result;
}

static std::shared_ptr<Rows> raster_range(const MapAxes& axes, float texel, const TexelRange& range,
                                          const Occluders& occluders, PartialShading partial, const Progress& progress,
                                          const std::shared_ptr<MemoryRoom>& room) {
    auto rows = std::make_shared<Rows>(texel_layout(axes, texel, range));
    rows->layout.room = room;
    rows->take_room();
    raster(*rows, occluders, progress);
    partial.first_slice = range.first.y;
    raster_partial(*rows, partial, progress);
    return rows;
}

/// The part of `from` that lies in a range.
static void crop(const Rows& from, const TexelRange& range, Rows& to, const Progress& progress) {
    const TexelRange all = range_of(from.layout);
    const glm::ivec2 skipped = range.first - all.first;
    parallel_blocks(to.layout.rows.size(), 32, progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            const RowExtent& source = from.layout.rows[y + static_cast<std::size_t>(skipped.y)];
            std::copy_n(from.slopes.get() + source.offset + skipped.x, range.end.x - range.first.x,
                        to.slopes.get() + to.layout.rows[y].offset);
        }
    });
}

DepthMap raster_sun_map(const MapAxes& axes, float texel, const TexelRange& range, const Occluders& occluders,
                        const PartialShading& partial, const Progress& progress,
                        const std::shared_ptr<MemoryRoom>& room) {
    DepthMap map;
    static_cast<MapAxes&>(map) = axes;
    lay_out_texels(map, {texel * vec2(range.first), texel * vec2(range.end)}, glm::uvec2(range.end - range.first));
    map.texels->layout.room = room;
    map.texels->take_room();
    if (!occluders.kept) {
        map.texels->slopes = std::move(raster_range(axes, texel, range, occluders, partial, progress, {})->slopes);
        return map;
    }
    // Of all ranges with the same anchor.
    Layout anywhere = texel_layout(axes, texel, range);
    anywhere.first_slice = 0.0f;
    anywhere.line_count = 0;
    anywhere.rows.clear();
    const MapCache::Key key = occluders.kept->key(CastKind::ParallelMap, partial, anywhere, {});
    bool has_part = false;
    std::shared_ptr<const Rows> kept = occluders.kept->cache().find(key, [&](const Rows& rows) {
        has_part = true;
        return range_of(rows.layout).contains(range);
    });
    if (!kept) {
        kept = raster_range(axes, texel, has_part ? grown(range) : range, occluders, partial, progress, room);
        occluders.kept->cache().keep(key, kept);
    }
    crop(*kept, range, *map.texels, progress); // filters work in place
    return map;
}
} // namespace tyndall::light_shafts
