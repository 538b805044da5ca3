// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/row_query_air.hpp"
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/row_query_air.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/row_query_place-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Blocks of a row, and what vectors reach beyond.
static constexpr std::size_t most_edges = row_query::most_air_lines / block_lines + 2 * block_lines;

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

/// Of two vectors side by side.
static HWY_INLINE V looked_up(V low, V high, I index) {
    const I size = hn::Set(di, static_cast<std::int32_t>(lanes));
    const auto within = hn::IndicesFromVec(d, hn::And(index, hn::Sub(size, hn::Set(di, 1))));
    const auto is_low = hn::RebindMask(d, hn::Lt(index, size));
    return hn::IfThenElse(is_low, hn::TableLookupLanes(low, within), hn::TableLookupLanes(high, within));
}

/// A ray of a row, and its light and texture up to the edges of the row's blocks.
class Knot {
public:
    float slope;

    void begin(const AirColumns& air, const ColumnLight& columns, const Asked& asked, std::size_t at,
               const ViewRay& ray, const RowView& row) {
        const AirGrid& grid = air.grid();
        slope = asked.slope[at];
        const vec2 place = grid.place(ray);
        const float x = std::clamp(place.x, 0.0f, static_cast<float>(grid.width - 1)),
                    y = std::clamp(place.y, 0.0f, static_cast<float>(grid.height - 1));
        const auto left = std::min(static_cast<std::size_t>(x), std::size_t{grid.width} - 2),
                   lower = std::min(static_cast<std::size_t>(y), std::size_t{grid.height} - 2);
        const float share_x = x - static_cast<float>(left), share_y = y - static_cast<float>(lower);
        const std::size_t column = lower * grid.width + left;
        right_ = grid.step_count, above_ = grid.width * right_;
        step_count_ = std::min({air.step_count(column), air.step_count(column + 1), air.step_count(column + grid.width),
                                air.step_count(column + grid.width + 1)});
        corner_light_ = columns.light.get() + column * right_;
        corner_textured_ = columns.textured.get() + column * right_;
        shares_ = {(1 - share_y) * (1 - share_x), (1 - share_y) * share_x, share_y * (1 - share_x), share_y * share_x};
        light_up_to_.resize(step_count_ + 2 * lanes), textured_up_to_.resize(step_count_ + 2 * lanes);
        light_up_to_[0] = textured_up_to_[0] = 0.0f;
        begin_step_ = past_step_ = 0;
        const float per_step = 1.0f / grid.step_m;
        const float edge_m = asked.near_m[at] +
                             (static_cast<float>(row.first) - asked.near_index[at]) * asked.m_per_line[at] +
                             grid.shift_m(ray);
        first_edge_ = (edge_m - grid.first_m) * per_step;
        steps_per_block_ = static_cast<float>(block_lines) * asked.m_per_line[at] * per_step;
        ready_ = 0;
    }
    /// Makes light and textured known at the edges of 16 blocks from 16 * group on.
    void reach(std::uint32_t group) {
        if ((ready_ >> group & 1) != 0)
            return;
        ready_ |= std::uint32_t{1} << group;
        for (std::size_t edge = std::size_t{group} * block_lines; edge < std::size_t{group + 1} * block_lines;
             edge += lanes) {
            const V number = hn::ConvertTo(d, hn::Iota(di, static_cast<std::int32_t>(edge)));
            const V at = clamped(hn::MulAdd(number, hn::Set(d, steps_per_block_), hn::Set(d, first_edge_)), hn::Zero(d),
                                 hn::Set(d, static_cast<float>(step_count_)));
            const I step = hn::Min(hn::ConvertTo(di, at), hn::Set(di, static_cast<std::int32_t>(step_count_) - 1));
            const V share = hn::Sub(at, hn::ConvertTo(d, step));
            const std::int32_t first = hn::GetLane(step), last = hn::ExtractLane(step, lanes - 1); // they rise
            interpolate(static_cast<std::size_t>(std::max(first, 1) - 1), static_cast<std::size_t>(last) + 1);
            // Most vectors of edges lie within two of steps, where a look-up takes a fifth of a gather's time.
            const bool is_close = last - first < static_cast<std::int32_t>(2 * lanes) - 1;
            const I in_two = is_close ? hn::Sub(step, hn::Set(di, first)) : hn::Zero(di);
            const auto find = [&](const std::vector<float>& up_to, float* at_edge) {
                V before, after;
                if (is_close) {
                    const float* const from = &up_to[static_cast<std::size_t>(first)];
                    const V low = hn::LoadU(d, from), high = hn::LoadU(d, from + lanes);
                    before = looked_up(low, high, in_two);
                    after = looked_up(low, high, hn::Add(in_two, hn::Set(di, 1)));
                } else {
                    before = hn::GatherIndex(d, up_to.data(), step);
                    after = hn::GatherIndex(d, up_to.data() + 1, step);
                }
                hn::Store(hn::MulAdd(share, hn::Sub(after, before), before), d, at_edge + edge);
            };
            find(light_up_to_, light);
            find(textured_up_to_, textured);
        }
    }

    alignas(64) float light[most_edges], textured[most_edges];

private:
    /// Between the four columns around, up to the ends of steps [begin, past) at least.
    void interpolate(std::size_t begin, std::size_t past) {
        const bool is_empty = begin_step_ == past_step_;
        begin = std::min(begin, is_empty ? begin : begin_step_) / lanes * lanes;
        past = std::max(past, past_step_);
        const V ll = hn::Set(d, shares_[0]), lr = hn::Set(d, shares_[1]), ul = hn::Set(d, shares_[2]),
                ur = hn::Set(d, shares_[3]);
        const auto add = [&](std::size_t step) {
            const auto between = [&](const float* corner) {
                const float* const from = corner + step;
                return hn::MulAdd(hn::LoadU(d, from), ll,
                                  hn::MulAdd(hn::LoadU(d, from + right_), lr,
                                             hn::MulAdd(hn::LoadU(d, from + above_), ul,
                                                        hn::Mul(hn::LoadU(d, from + above_ + right_), ur))));
            };
            hn::StoreU(between(corner_light_), d, &light_up_to_[step + 1]);
            hn::StoreU(between(corner_textured_), d, &textured_up_to_[step + 1]);
        };
        if (is_empty)
            begin_step_ = past_step_ = begin;
        for (; begin_step_ > begin; begin_step_ -= lanes)
            add(begin_step_ - lanes);
        for (; past_step_ < past; past_step_ += lanes)
            add(past_step_);
    }

    std::size_t step_count_, right_, above_; ///< From a column to the next ones.
    const float *corner_light_, *corner_textured_;
    std::array<float, 4> shares_;
    std::size_t begin_step_, past_step_; ///< Steps up to whose ends sums are known.
    float first_edge_, steps_per_block_;
    std::uint32_t ready_;
    std::vector<float> light_up_to_, textured_up_to_;
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
        light = textured = hn::Zero(d);
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
        V of_light = hn::Zero(d), of_texture = of_light;
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
            const auto add_lines = [&](int bit, V lines) {
                const auto begin = static_cast<std::size_t>(start + bit);
                const float light_a = a.light[begin + 1] - a.light[begin],
                            light_b = b.light[begin + 1] - b.light[begin];
                const float textured_a = a.textured[begin + 1] - a.textured[begin],
                            textured_b = b.textured[begin + 1] - b.textured[begin];
                const V light_here = hn::MulAdd(share, hn::Set(d, light_b - light_a), hn::Set(d, light_a));
                const V texture_here = hn::MulAdd(share, hn::Set(d, textured_b - textured_a), hn::Set(d, textured_a));
                of_light = hn::MulAdd(lines, light_here, of_light);
                of_texture = hn::MulAdd(lines, texture_here, of_texture);
            };
            for (std::uint64_t left = some & inner & ~all; left != 0; left &= left - 1) {
                const int bit = std::countr_zero(left);
                const float* const slopes = row.slopes + (start + bit) * block_lines;
                const std::uint32_t lit = at_or_above(hn::Set(d, least_slope), slopes);
                V lines = hn::Set(d, static_cast<float>(std::popcount(lit)));
                for (std::uint32_t doubtful = at_or_above(hn::Set(d, most_slope), slopes) & ~lit; doubtful != 0;
                     doubtful &= doubtful - 1)
                    lines =
                        hn::Add(lines, hn::IfThenElseZero(hn::Ge(slope, hn::Set(d, slopes[__builtin_ctz(doubtful)])),
                                                          hn::Set(d, 1.0f)));
                add_lines(bit, lines);
            }
            for (std::uint64_t left = some & ~inner; left != 0; left &= left - 1) {
                const int bit = std::countr_zero(left);
                const float* const slopes = row.slopes + (start + bit) * block_lines;
                const I block_line = hn::Set(di, (start + bit) * block_lines);
                const auto before = [&](I line) {
                    const I count = hn::Min(hn::Max(hn::Sub(line, block_line), hn::Zero(di)), hn::Set(di, block_lines));
                    return hn::Sub(hn::Shl(hn::Set(di, 1), count), hn::Set(di, 1));
                };
                const std::uint32_t lit = at_or_above(hn::Set(d, least_slope), slopes);
                I bits = hn::Set(di, static_cast<std::int32_t>(lit));
                for (std::uint32_t doubtful = at_or_above(hn::Set(d, most_slope), slopes) & ~lit; doubtful != 0;
                     doubtful &= doubtful - 1) {
                    const int line = __builtin_ctz(doubtful);
                    bits = hn::Or(bits, hn::IfThenElseZero(hn::RebindMask(di, hn::Ge(slope, hn::Set(d, slopes[line]))),
                                                           hn::Set(di, 1 << line)));
                }
                bits = hn::And(bits, hn::AndNot(before(first_in_row), before(past_in_row)));
                add_lines(bit, hn::ConvertTo(d, hn::BitCast(di, hn::PopulationCount(hn::BitCast(
                                                                    hn::RebindToUnsigned<decltype(di)>(), bits)))));
            }
        }
        const V per_line = hn::Set(d, 1.0f / block_lines);
        light = hn::MulAdd(of_light, per_line, hn::MulAdd(share, hn::Set(d, runs[2] - runs[0]), hn::Set(d, runs[0])));
        textured =
            hn::MulAdd(of_texture, per_line, hn::MulAdd(share, hn::Set(d, runs[3] - runs[1]), hn::Set(d, runs[1])));
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
