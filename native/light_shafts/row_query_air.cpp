// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/row_query_air.hpp"
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/row_query_air.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/row_query_knot-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Rows and lines of placed rays, among coarse rows. What reaches beyond its row ends there; rays without a line, and those
/// that end before they begin, get far_m = near_m.
static void find_coarse(const CoarseRows& rows, PlacedRays& placed, std::size_t count, RowHits& hits) {
    const Layout& layout = rows.layout;
    const auto set = [](float value) { return hn::Set(d, value); };
    const V half = set(0.5f), per_line = set(1.0f / layout.line_step),
            per_slice = set(1.0f / static_cast<float>(rows.stride));
    const auto& radius = layout.frame.is_orthographic ? placed.radial : placed.radial_per_m;
    for (std::size_t i = 0; i < count; i += lanes) {
        const V slice = slices_at(layout, hn::Load(d, &placed.slice_coordinate[i]));
        const auto has_slice =
            hn::And(hn::Ge(slice, hn::Zero(d)), hn::Lt(slice, set(static_cast<float>(rows.slice_count))));
        const I row = hn::ConvertTo(di, hn::Mul(hn::Add(hn::IfThenElseZero(has_slice, slice), half), per_slice));
        hn::Store(row, di, &hits.slice[i]);
        V from, past;
        const std::int32_t first_row = hits.slice[i];
        if (hn::AllTrue(di, hn::Eq(row, hn::Set(di, first_row)))) {
            const RowView view = rows.row(first_row);
            from = set(static_cast<float>(view.first)), past = set(static_cast<float>(view.end));
        } else {
            alignas(64) float ends[2][lanes];
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const RowView view = rows.row(hits.slice[i + lane]);
                ends[0][lane] = static_cast<float>(view.first), ends[1][lane] = static_cast<float>(view.end);
            }
            from = hn::Load(d, ends[0]), past = hn::Load(d, ends[1]);
        }
        const auto index_of = [&](const PlacedRays::Column& line) {
            return hn::Mul(hn::Sub(hn::Load(d, &line[i]), set(layout.first_line)), per_line);
        };
        const V near = index_of(placed.near_line), far = index_of(placed.far_line);
        V first = hn::Ceil(hn::Sub(near, half)), last = hn::Floor(hn::Sub(far, half));
        const auto is_short = hn::Gt(first, last);
        const V middle = hn::Floor(hn::Mul(half, hn::Add(near, far)));
        first = hn::Max(hn::IfThenElse(is_short, middle, first), from);
        last = hn::Min(hn::IfThenElse(is_short, middle, last), hn::Sub(past, set(1.0f)));
        const auto is_some = hn::And(has_slice, hn::Le(first, last));
        I cover = hn::IfThenElse(hn::RebindMask(di, has_slice), hn::Set(di, static_cast<int>(Cover::Rows)),
                                 hn::Set(di, static_cast<int>(Cover::Outside)));
        if (!layout.frame.is_parallel)
            cover = hn::IfThenElse(hn::RebindMask(di, hn::Lt(hn::Load(d, &radius[i]), set(layout.smallest_radius))),
                                   hn::Set(di, static_cast<int>(Cover::NearEpipole)), cover);
        hn::Store(cover, di, &hits.cover[i]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(is_some, first)), di, &hits.first[i]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(is_some, last)), di, &hits.last[i]);
        hn::Store(near, d, &hits.near_index[i]);
        const auto is_dark =
            hn::AndNot(is_some, hn::RebindMask(d, hn::Eq(cover, hn::Set(di, static_cast<int>(Cover::Rows)))));
        hn::Store(hn::IfThenElse(is_dark, hn::Load(d, &placed.near_m[i]), hn::Load(d, &placed.far_m[i])), d,
                  &placed.far_m[i]);
    }
}

/// Of lit lines along two rays.
struct LineSums {
    V light_a, textured_a, light_b, textured_b;

    /// Of lines from `first` on, a bit each; a lane per line.
    HWY_INLINE void add_lit(const Knot& a, const Knot& b, std::size_t first, std::uint32_t lit) {
        for (std::size_t at = 0; at < block_lines; at += lanes) {
            const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(lit >> at),
                                           static_cast<std::uint8_t>(lit >> at >> 8)};
            const LaneMask is_lit = hn::LoadMaskBits(d, bytes);
            const auto add = [&](V& sum, const float* of_line) {
                sum = hn::Add(sum, hn::IfThenElseZero(is_lit, hn::Load(d, of_line + first + at)));
            };
            add(light_a, a.line_light), add(textured_a, a.line_textured);
            add(light_b, b.line_light), add(textured_b, b.line_textured);
        }
    }
    /// Of one line, for the rays that have it; a lane per ray.
    HWY_INLINE void add(const Knot& a, const Knot& b, std::size_t line, LaneMask has) {
        const auto add_one = [&](V& sum, const float* of_line) {
            sum = hn::IfThenElse(has, hn::Add(sum, hn::Set(d, of_line[line])), sum);
        };
        add_one(light_a, a.line_light), add_one(textured_a, a.line_textured);
        add_one(light_b, b.line_light), add_one(textured_b, b.line_textured);
    }
};

/// Up to 16 rays of one row.
struct AirPacket {
    RowView row;
    V slope;
    I first_line, last_line;
    float least_slope, most_slope;
    PacketBlocks blocks;

    V light, textured;

    void add(Knot& a, Knot& b) {
        const std::int32_t words = (blocks.end - blocks.first + blocks_per_word - 1) / blocks_per_word;
        const auto least_of_lines = [](I v) { return hn::GetLane(hn::MinOfLanes(di, v)); };
        const auto most_of_lines = [](I v) { return hn::GetLane(hn::MaxOfLanes(di, v)); };
        const I first_in_row = hn::Sub(first_line, hn::Set(di, row.first)),
                past_in_row = hn::Sub(last_line, hn::Set(di, row.first - 1));
        const std::int32_t inner_begin = (most_of_lines(first_in_row) + block_lines - 1) / block_lines,
                           inner_end = std::max(inner_begin, least_of_lines(past_in_row) / block_lines);
        const float slope_span = b.slope - a.slope;
        const V share =
            slope_span == 0.0f ? hn::Zero(d) : hn::Div(hn::Sub(slope, hn::Set(d, a.slope)), hn::Set(d, slope_span));
        float runs[4] = {};
        const V none = hn::Zero(d);
        LineSums of_all{none, none, none, none}; // lines that all rays have, a lane per line
        LineSums of_some = of_all;               // others, a lane per ray
        for (std::int32_t word = 0; word < words; ++word) {
            const std::int32_t start = blocks.first + word * blocks_per_word;
            const std::uint64_t some = blocks.some_lit[static_cast<std::size_t>(word)];
            if (some == 0)
                continue;
            for (std::uint64_t left = some, block; left != 0;) {
                block = static_cast<std::uint64_t>(start + std::countr_zero(left));
                const auto group = static_cast<std::uint32_t>(block / block_lines);
                a.reach(group), b.reach(group);
                const std::int32_t past = static_cast<std::int32_t>((group + 1) * block_lines) - start;
                if (past > 0 && past <= 64 && (some >> (past - 1) & 1) != 0)
                    a.reach(group + 1), b.reach(group + 1);
                left = past >= 64 ? 0 : left & ~((std::uint64_t{1} << past) - 1);
            }
            const std::uint64_t inner = PacketBlocks::bits_between(inner_begin, inner_end, start);
            const std::uint64_t all = blocks.all_lit[static_cast<std::size_t>(word)] & some;
            for (std::uint64_t left = all & inner; left != 0;) {
                const int bit = std::countr_zero(left), length = std::countr_one(left >> bit);
                const auto begin = static_cast<std::size_t>(start + bit),
                           past = begin + static_cast<std::size_t>(length);
                runs[0] += a.light[past] - a.light[begin];
                runs[1] += a.textured[past] - a.textured[begin];
                runs[2] += b.light[past] - b.light[begin];
                runs[3] += b.textured[past] - b.textured[begin];
                left = bit + length >= 64 ? 0 : left & ~((std::uint64_t{1} << (bit + length)) - 1);
            }
            for (std::uint64_t left = some & ~(all & inner); left != 0; left &= left - 1) {
                const auto block = static_cast<std::size_t>(start + std::countr_zero(left));
                a.reach_lines(block), b.reach_lines(block);
                const std::size_t first = block * block_lines;
                const float* const slopes = row.slopes + first;
                std::uint32_t lit = at_or_above(hn::Set(d, least_slope), slopes),
                              doubtful = at_or_above(hn::Set(d, most_slope), slopes) & ~lit;
                if ((inner >> std::countr_zero(left) & 1) != 0) {
                    of_all.add_lit(a, b, first, lit);
                    for (; doubtful != 0; doubtful &= doubtful - 1) {
                        const std::size_t line = static_cast<std::size_t>(std::countr_zero(doubtful));
                        of_some.add(a, b, first + line, hn::Ge(slope, hn::Set(d, slopes[line])));
                    }
                    continue;
                }
                for (lit |= doubtful; lit != 0; lit &= lit - 1) {
                    const std::size_t line = static_cast<std::size_t>(std::countr_zero(lit));
                    const I number = hn::Set(di, static_cast<std::int32_t>(first + line));
                    const LaneMask has_line =
                        hn::RebindMask(d, hn::AndNot(hn::Lt(number, first_in_row), hn::Lt(number, past_in_row)));
                    of_some.add(a, b, first + line, hn::And(has_line, hn::Ge(slope, hn::Set(d, slopes[line]))));
                }
            }
        }
        const auto sum = [&](int which, V of_all_lines, V of_some_lines) {
            return hn::Add(hn::Add(hn::Set(d, runs[which]), hn::SumOfLanes(d, of_all_lines)), of_some_lines);
        };
        const V light_a = sum(0, of_all.light_a, of_some.light_a), light_b = sum(2, of_all.light_b, of_some.light_b);
        const V textured_a = sum(1, of_all.textured_a, of_some.textured_a),
                textured_b = sum(3, of_all.textured_b, of_some.textured_b);
        light = hn::MulAdd(share, hn::Sub(light_b, light_a), light_a);
        textured = hn::MulAdd(share, hn::Sub(textured_b, textured_a), textured_a);
    }
};

/// The rays of a block, slice by slice, in packets.
class AirPackets {
public:
    const CoarseRows& rows;
    const AirColumns& air;
    const ColumnLight& columns;
    const Asked& asked;
    std::span<const ViewRay> rays;

    void add(float weight, const row_query::AirSums& sums) {
        thread_local Knot knots[4];
        Knot *a = &knots[0], *b = &knots[1];
        std::size_t from = asked.count, past = from; // the rays that they are of
        for (std::size_t begin = 0, end; begin < asked.count; begin = end) {
            end = begin + asked.count_together(begin);
            AirPacket packet;
            std::size_t least = 0, most = 0;
            while (!gather(begin, end, packet, least, most))
                end = begin + (end - begin) / 2;
            packet.row = rows.row(asked.slice[asked.ray(begin)]);
            if (!packet.blocks.find(packet.row, packet.least_slope, packet.most_slope,
                                    hn::GetLane(hn::MinOfLanes(di, packet.first_line)),
                                    hn::GetLane(hn::MaxOfLanes(di, packet.last_line))))
                continue;
            // Rays mostly follow each other along the row: two of them serve all between.
            if (begin < from || past <= begin)
                if (const std::size_t next = find_past(begin, end); next > begin) {
                    if (from < past && past == begin)
                        std::swap(a, b);
                    else
                        start(*a, begin, packet.row);
                    start(*b, next, packet.row);
                    from = begin, past = next;
                }
            if (from <= begin && end <= past && is_between(from, past, packet)) {
                packet.add(*a, *b);
            } else {
                start(knots[2], least, packet.row);
                if (least != most)
                    start(knots[3], most, packet.row);
                packet.add(knots[2], knots[least != most ? 3 : 2]);
            }
            alignas(64) float results[2][lanes];
            hn::Store(packet.light, d, results[0]);
            hn::Store(packet.textured, d, results[1]);
            for (std::size_t lane = 0; lane < end - begin; ++lane) {
                const auto ray = static_cast<std::size_t>(asked.number[asked.ray(begin + lane)]);
                sums.light[ray] += weight * results[0][lane];
                sums.textured[ray] += weight * results[1][lane];
            }
        }
    }

private:
    [[nodiscard]] const ViewRay& ray_at(std::size_t at) const {
        return rays[static_cast<std::size_t>(asked.number[asked.ray(at)])];
    }
    void start(Knot& knot, std::size_t at, const RowView& row) const {
        knot.begin(air, columns, asked, asked.ray(at), ray_at(at), row);
    }
    [[nodiscard]] bool are_near(std::size_t a, std::size_t b) const {
        const vec2 apart = glm::abs(air.grid().place(ray_at(a)) - air.grid().place(ray_at(b)));
        return std::max(apart.x, apart.y) < AirNeeds::most_span;
    }
    /// Rays [begin, end); false where they are too far apart. Lanes without a ray are like the first.
    bool gather(std::size_t begin, std::size_t end, AirPacket& packet, std::size_t& least, std::size_t& most) const {
        const auto is_member = hn::RebindMask(di, hn::FirstN(d, end - begin));
        const I first = hn::Set(di, static_cast<std::int32_t>(asked.ray(begin)));
        const I at = hn::IfThenElse(is_member,
                                    asked.is_in_order ? hn::Iota(di, static_cast<std::int32_t>(begin))
                                                      : hn::LoadU(di, &asked.order[begin]),
                                    first);
        const auto column = [&](const Asked::Column<float>& values) { return hn::GatherIndex(d, values.data(), at); };
        packet.slope = column(asked.slope);
        packet.least_slope = least_of(packet.slope);
        packet.most_slope = most_of(packet.slope);
        const auto lane_of = [&](float slope) {
            return begin + static_cast<std::size_t>(hn::FindFirstTrue(d, hn::Eq(packet.slope, hn::Set(d, slope))));
        };
        least = lane_of(packet.least_slope), most = lane_of(packet.most_slope);
        if (least != most && !are_near(least, most))
            return false;
        packet.first_line = hn::ConvertTo(di, column(asked.first_line));
        packet.last_line = hn::ConvertTo(di, column(asked.last_line));
        return true;
    }
    /// A ray of the same row, at or after `end`, up to which all may lie between it and the one at `begin`; `begin`: none.
    [[nodiscard]] std::size_t find_past(std::size_t begin, std::size_t end) const {
        for (const std::size_t count : {std::size_t{32}, std::size_t{16}, end - begin})
            if (const std::size_t past = begin + count; end <= past && past < asked.count &&
                                                        asked.slice[asked.ray(past)] == asked.slice[asked.ray(begin)] &&
                                                        are_near(begin, past))
                return past;
        return begin;
    }
    /// Whether the packet's rays lie between two others, or hardly beyond.
    [[nodiscard]] bool is_between(std::size_t a, std::size_t b, const AirPacket& packet) const {
        const float from = asked.slope[asked.ray(a)], to = asked.slope[asked.ray(b)];
        const float beyond = 0.1f * std::abs(to - from);
        return std::min(from, to) - beyond <= packet.least_slope && packet.most_slope <= std::max(from, to) + beyond;
    }
};

void add_lit_air_of(const CoarseRows& rows, const AirColumns& air, const ColumnLight& columns, float weight,
                    std::span<const ViewRay> rays, const row_query::AirSums& sums, row_query::Uncovered& uncovered) {
    PlacedRays placed;
    RowHits hits;
    Asked asked;
    std::array<std::uint32_t, PlacedRays::capacity + 1> one_each;
    for (std::uint32_t i = 0; i < one_each.size(); ++i)
        one_each[i] = i;
    for (std::size_t start = 0; start < rays.size(); start += PlacedRays::capacity) {
        const auto block = rays.subspan(start, std::min(PlacedRays::capacity, rays.size() - start));
        place_rays(rows.layout.frame, block, placed);
        find_coarse(rows, placed, block.size(), hits);
        asked.first_of_call = static_cast<std::uint32_t>(start);
        asked.select(rows.layout, placed, hits, std::span(one_each).first(block.size() + 1), uncovered);
        asked.sort();
        AirPackets{rows, air, columns, asked, block}.add(
            weight, {sums.light.subspan(start, block.size()), sums.textured.subspan(start, block.size())});
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(add_lit_air_of);
} // namespace tyndall::light_shafts

namespace tyndall::light_shafts::row_query {
void add_lit_air(const CoarseRows& rows, const AirColumns& air, const ColumnLight& light, float weight,
                 std::span<const ViewRay> rays, const AirSums& sums, Uncovered& uncovered) {
    HWY_DYNAMIC_DISPATCH(add_lit_air_of)(rows, air, light, weight, rays, sums, uncovered);
}
} // namespace tyndall::light_shafts::row_query
#endif
