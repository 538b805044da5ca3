// SPDX-License-Identifier: GPL-3.0-or-later
// A ray of a row, between columns of air: its light and texture up to edges of blocks, and of single lines where blocks are
// neither lit nor dark, compiled once per SIMD target.
#if defined(TYNDALL_ROW_QUERY_KNOT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_ROW_QUERY_KNOT_INL
#undef TYNDALL_ROW_QUERY_KNOT_INL
#else
#define TYNDALL_ROW_QUERY_KNOT_INL
#endif
#include "light_shafts/row_query_air.hpp"
#include "light_shafts/row_query_place-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Blocks of a row, and what vectors reach beyond.
static constexpr std::size_t most_edges = row_query::most_air_lines / block_lines + 2 * block_lines;

/// Of two vectors side by side.
static HWY_INLINE V looked_up(V low, V high, I index) {
    const I size = hn::Set(di, static_cast<std::int32_t>(lanes));
    const auto within = hn::IndicesFromVec(d, hn::And(index, hn::Sub(size, hn::Set(di, 1))));
    const auto is_low = hn::RebindMask(d, hn::Lt(index, size));
    return hn::IfThenElse(is_low, hn::TableLookupLanes(low, within), hn::TableLookupLanes(high, within));
}

/// A ray of a row, its light and texture up to the edges of the row's blocks, and those of single lines.
class Knot {
public:
    float slope;

    /// `last_line`: the last that anything is asked of.
    void begin(AirColumns& air, std::size_t of_light, const Asked& asked, std::size_t at, const ViewRay& ray,
               const RowView& row, std::int32_t last_line) {
        const AirGrid& grid = air.grid();
        slope = asked.slope[at];
        const float per_step = 1.0f / grid.step_m;
        const float edge_m = asked.near_m[at] +
                             (static_cast<float>(row.first) - asked.near_index[at]) * asked.m_per_line[at] +
                             grid.shift_m(ray);
        first_edge_ = (edge_m - grid.first_m) * per_step;
        steps_per_line_ = asked.m_per_line[at] * per_step;
        const float end = first_edge_ + steps_per_line_ * static_cast<float>(last_line + 1 - row.first);
        step_count_ =
            static_cast<std::size_t>(std::max(1.0f, std::min(static_cast<float>(grid.step_count), end + 1.0f)));

        const vec2 place = grid.place(ray);
        const float x = std::clamp(place.x, 0.0f, static_cast<float>(grid.width - 1)),
                    y = std::clamp(place.y, 0.0f, static_cast<float>(grid.height - 1));
        const auto left = std::min(static_cast<std::size_t>(x), std::size_t{grid.width} - 2),
                   lower = std::min(static_cast<std::size_t>(y), std::size_t{grid.height} - 2);
        const float share_x = x - static_cast<float>(left), share_y = y - static_cast<float>(lower);
        const std::size_t column = lower * grid.width + left;
        for (const std::size_t corner : {column, column + 1, column + grid.width, column + grid.width + 1})
            air.reach(corner, static_cast<std::uint32_t>(step_count_));
        right_ = grid.step_count, above_ = grid.width * right_;
        corner_light_ = air.light(of_light, column);
        corner_textured_ = air.textured(of_light, column);
        shares_ = {(1 - share_y) * (1 - share_x), (1 - share_y) * share_x, share_y * (1 - share_x), share_y * share_x};
        light_up_to_.resize(step_count_ + 3 * lanes), textured_up_to_.resize(step_count_ + 3 * lanes);
        light_up_to_[0] = textured_up_to_[0] = 0.0f;
        begin_step_ = past_step_ = 0;
        ready_ = 0;
        ready_lines_ = {};
    }
    /// Makes light and textured known at the edges of 16 blocks from 16 * group on.
    void reach(std::uint32_t group) {
        if ((ready_ >> group & 1) != 0)
            return;
        ready_ |= std::uint32_t{1} << group;
        for (std::size_t edge = std::size_t{group} * block_lines; edge < std::size_t{group + 1} * block_lines;
             edge += lanes) {
            const Places at = places(static_cast<float>(edge) * static_cast<float>(block_lines), block_lines);
            // They rise.
            interpolate(static_cast<std::size_t>(std::max(at.first, 1) - 1), static_cast<std::size_t>(at.last) + 1);
            hn::Store(find(light_up_to_, at), d, light + edge);
            hn::Store(find(textured_up_to_, at), d, textured + edge);
        }
    }
    /// Makes known what each line of a block has, between edges that are known.
    void reach_lines(std::size_t block) {
        if ((ready_lines_[block / 64] >> block % 64 & 1) != 0)
            return;
        ready_lines_[block / 64] |= std::uint64_t{1} << block % 64;
        float light_before = light[block], textured_before = textured[block];
        for (std::size_t line = block * block_lines; line < (block + 1) * block_lines; line += lanes) {
            const Places at = places(static_cast<float>(line + 1), 1);
            const auto differences = [&](const std::vector<float>& up_to, float& before, float* of_line) {
                const V after = find(up_to, at);
                // One lane up.
                const auto from = hn::IndicesFromVec(d, hn::Max(hn::Iota(di, -1), hn::Zero(di)));
                const V moved = hn::IfThenElse(hn::FirstN(d, 1), hn::Set(d, before), hn::TableLookupLanes(after, from));
                hn::Store(hn::Sub(after, moved), d, of_line + line);
                before = hn::ExtractLane(after, lanes - 1);
            };
            differences(light_up_to_, light_before, line_light);
            differences(textured_up_to_, textured_before, line_textured);
        }
    }

    alignas(64) float light[most_edges], textured[most_edges]; ///< Up to the edges of blocks.
    alignas(64) float line_light[row_query::most_air_lines + block_lines],
        line_textured[row_query::most_air_lines + block_lines];

private:
    /// Edges along the ray, in steps.
    struct Places {
        I step;
        V share; ///< Of the step, that lies before the edge.
        std::int32_t first, last;
    };
    /// Of edges in lines: `first`, and so many from one to the next.
    [[nodiscard]] Places places(float first, std::int32_t stride) const {
        const V number = hn::ConvertTo(d, hn::Mul(hn::Iota(di, 0), hn::Set(di, stride)));
        const V line = hn::Add(number, hn::Set(d, first));
        const V at = clamped(hn::MulAdd(line, hn::Set(d, steps_per_line_), hn::Set(d, first_edge_)), hn::Zero(d),
                             hn::Set(d, static_cast<float>(step_count_)));
        const I step = hn::Min(hn::ConvertTo(di, at), hn::Set(di, static_cast<std::int32_t>(step_count_) - 1));
        return {step, hn::Sub(at, hn::ConvertTo(d, step)), hn::GetLane(step), hn::ExtractLane(step, lanes - 1)};
    }
    [[nodiscard]] static V find(const std::vector<float>& up_to, const Places& at) {
        V before, after;
        // Most vectors of edges lie within two of steps, where a look-up takes a fifth of a gather's time.
        if (at.last - at.first < static_cast<std::int32_t>(2 * lanes) - 1) {
            const I in_two = hn::Sub(at.step, hn::Set(di, at.first));
            const float* const from = &up_to[static_cast<std::size_t>(at.first)];
            const V low = hn::LoadU(d, from), high = hn::LoadU(d, from + lanes);
            before = looked_up(low, high, in_two);
            after = looked_up(low, high, hn::Add(in_two, hn::Set(di, 1)));
        } else {
            before = hn::GatherIndex(d, up_to.data(), at.step);
            after = hn::GatherIndex(d, up_to.data() + 1, at.step);
        }
        return hn::MulAdd(at.share, hn::Sub(after, before), before);
    }
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
    float first_edge_, steps_per_line_;
    std::uint32_t ready_;                                        ///< Groups of 16 edges.
    std::array<std::uint64_t, most_edges / 64 + 1> ready_lines_; ///< Blocks.
    std::vector<float> light_up_to_, textured_up_to_;
};

} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
