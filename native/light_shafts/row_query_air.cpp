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

/// Of the lowest bits, one per lane.
static HWY_INLINE LaneMask mask_of(std::uint32_t bits) {
    const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8)};
    return hn::LoadMaskBits(d, bytes);
}

/// Up to 16 rays of one row.
struct AirPacket {
    RowView row;
    V slope;
    I first_line, last_line;
    float least_slope, most_slope;
    PacketBlocks blocks;

    V light, textured;

    bool find_blocks() {
        return blocks.find(row, least_slope, most_slope, hn::GetLane(hn::MinOfLanes(di, first_line)),
                           hn::GetLane(hn::MaxOfLanes(di, last_line)));
    }
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
        // Of lines that all rays have, a lane per line; and of others, a lane per ray.
        V all_light_a = hn::Zero(d), all_textured_a = all_light_a, all_light_b = all_light_a,
          all_textured_b = all_light_a;
        V light_a = all_light_a, textured_a = all_light_a, light_b = all_light_a, textured_b = all_light_a;
        const float *const a_light = a.line_light, *const a_textured = a.line_textured, *const b_light = b.line_light,
                           *const b_textured = b.line_textured;
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
                const std::uint32_t lit = at_or_above(hn::Set(d, least_slope), slopes);
                std::uint32_t of_some = at_or_above(hn::Set(d, most_slope), slopes);
                const bool has_all_rays = (inner >> std::countr_zero(left) & 1) != 0;
                if (has_all_rays) {
                    of_some &= ~lit;
                    for (std::size_t at = 0; at < block_lines; at += lanes) {
                        const LaneMask is_lit = mask_of(lit >> at);
                        const auto add = [&](V sum, const float* of_line) {
                            return hn::Add(sum, hn::IfThenElseZero(is_lit, hn::Load(d, of_line + first + at)));
                        };
                        all_light_a = add(all_light_a, a_light), all_textured_a = add(all_textured_a, a_textured);
                        all_light_b = add(all_light_b, b_light), all_textured_b = add(all_textured_b, b_textured);
                    }
                }
                for (; of_some != 0; of_some &= of_some - 1) {
                    const auto line = static_cast<std::size_t>(std::countr_zero(of_some));
                    LaneMask has_line = hn::Ge(slope, hn::Set(d, slopes[line]));
                    if (!has_all_rays) {
                        const I number = hn::Set(di, static_cast<std::int32_t>(first + line));
                        has_line = hn::And(has_line, hn::RebindMask(d, hn::AndNot(hn::Lt(number, first_in_row),
                                                                                  hn::Lt(number, past_in_row))));
                    }
                    const auto add = [&](V sum, const float* of_line) {
                        return hn::IfThenElse(has_line, hn::Add(sum, hn::Set(d, of_line[first + line])), sum);
                    };
                    light_a = add(light_a, a_light), textured_a = add(textured_a, a_textured);
                    light_b = add(light_b, b_light), textured_b = add(textured_b, b_textured);
                }
            }
        }
        const auto in_all = [&](int run, V of_all, V of_some) {
            return hn::Add(hn::Add(hn::Set(d, runs[run]), hn::SumOfLanes(d, of_all)), of_some);
        };
        light_a = in_all(0, all_light_a, light_a), textured_a = in_all(1, all_textured_a, textured_a);
        light_b = in_all(2, all_light_b, light_b), textured_b = in_all(3, all_textured_b, textured_b);
        light = hn::MulAdd(share, hn::Sub(light_b, light_a), light_a);
        textured = hn::MulAdd(share, hn::Sub(textured_b, textured_a), textured_a);
    }
};

/// The rays of a block, slice by slice, in packets.
class AirPackets {
public:
    const CoarseRows& rows;
    AirColumns& air;
    std::size_t light;
    const Asked& asked;
    std::span<const ViewRay> rays;

    void add(float weight, const row_query::AirSums& sums) {
        thread_local Knot of_thread[4];
        Knot* const knots = of_thread;
        Knot *a = &knots[0], *b = &knots[1];
        std::size_t from = asked.count, past = from; // the rays that they are of
        for (std::size_t begin = 0, end; begin < asked.count; begin = end) {
            end = begin + asked.count_together(begin);
            AirPacket packet;
            packet.row = rows.row(asked.slice[asked.ray(begin)]);
            std::size_t least = 0, most = 0;
            bool is_lit;
            for (gather(begin, end, packet, least, most);
                 (is_lit = packet.find_blocks()) && least != most && !are_near(place(least), place(most));
                 gather(begin, end, packet, least, most))
                end = begin + (end - begin) / 2; // too far apart for what lies between
            if (!is_lit)
                continue;
            // Rays mostly follow each other along the row: two of them serve all between.
            if (begin < from || past <= begin)
                if (const std::size_t next = find_past(begin, end); next > begin) {
                    if (from < past && past == begin)
                        std::swap(a, b);
                    else
                        start(*a, begin, packet.row, last_line(begin, next));
                    start(*b, next, packet.row, last_line(begin, next + most_between + 1));
                    from = begin, past = next;
                }
            if (from <= begin && end <= past && is_between(from, past, packet)) {
                packet.add(*a, *b);
            } else {
                const std::int32_t last = last_line(begin, end);
                start(knots[2], least, packet.row, last);
                if (least != most)
                    start(knots[3], most, packet.row, last);
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
    static constexpr std::size_t most_between = 32;  ///< From a ray to the next whose columns are looked up.
    static constexpr float most_cells_apart = 1.75f; ///< Of two such rays, along each axis.

    [[nodiscard]] const ViewRay& ray_at(std::size_t at) const {
        return rays[static_cast<std::size_t>(asked.number[asked.ray(at)])];
    }
    void start(Knot& knot, std::size_t at, const RowView& row, std::int32_t last_line) const {
        knot.begin(air, light, asked, asked.ray(at), ray_at(at), row, last_line);
    }
    /// The farthest that any ray of [begin, past) reaches; those of other rows count for nothing.
    [[nodiscard]] std::int32_t last_line(std::size_t begin, std::size_t past) const {
        float last = 0.0f;
        const std::int32_t slice = asked.slice[asked.ray(begin)];
        for (std::size_t at = begin; at < std::min(past, asked.count); ++at)
            if (const std::size_t ray = asked.ray(at); asked.slice[ray] == slice)
                last = std::max(last, asked.last_line[ray]);
        return static_cast<std::int32_t>(last);
    }
    [[nodiscard]] vec2 place(std::size_t at) const { return air.grid().place(ray_at(at)); }
    [[nodiscard]] static bool are_near(const vec2& a, const vec2& b) {
        const vec2 apart = glm::abs(a - b);
        return std::max(apart.x, apart.y) < most_cells_apart;
    }
    /// Rays [begin, end), and those of the least and the largest slope. Lanes without a ray are like the first.
    void gather(std::size_t begin, std::size_t end, AirPacket& packet, std::size_t& least, std::size_t& most) const {
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
        packet.first_line = hn::ConvertTo(di, column(asked.first_line));
        packet.last_line = hn::ConvertTo(di, column(asked.last_line));
    }
    /// A ray of the same row, at or after `end`, up to which all may lie between it and the one at `begin`; `begin`: none.
    [[nodiscard]] std::size_t find_past(std::size_t begin, std::size_t end) const {
        const vec2 here = place(begin);
        for (const std::size_t count : {most_between, most_between / 2, end - begin})
            if (const std::size_t past = begin + count; end <= past && past < asked.count &&
                                                        asked.slice[asked.ray(past)] == asked.slice[asked.ray(begin)] &&
                                                        are_near(here, place(past)))
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

void add_lit_air_of(const CoarseRows& rows, AirColumns& air, std::size_t light, float weight,
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
        AirPackets{rows, air, light, asked, block}.add(
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
void add_lit_air(const CoarseRows& rows, AirColumns& air, std::size_t light, float weight,
                 std::span<const ViewRay> rays, const AirSums& sums, Uncovered& uncovered) {
    HWY_DYNAMIC_DISPATCH(add_lit_air_of)(rows, air, light, weight, rays, sums, uncovered);
}
} // namespace tyndall::light_shafts::row_query
#endif
