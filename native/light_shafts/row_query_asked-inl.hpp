// SPDX-License-Identifier: GPL-3.0-or-later
// The rays of a call that rows answer, in columns and slice by slice, compiled once per SIMD target.
#if defined(TYNDALL_ROW_QUERY_ASKED_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_ROW_QUERY_ASKED_INL
#undef TYNDALL_ROW_QUERY_ASKED_INL
#else
#define TYNDALL_ROW_QUERY_ASKED_INL
#endif
#include "light_shafts/row_query_lane-inl.hpp"
#include <utility>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Rays with pieces, in columns.
struct Asked {
    template <class Value>
    using Column = std::array<Value, PlacedRays::capacity + block_lines>;
    alignas(64) Column<float> slope, first_line, last_line, near_index, m_per_line, lines_per_m, near_m, far_m;
    alignas(64) Column<std::int32_t> number, slice, first_piece, piece_count; ///< number: of the ray in the block.
    alignas(64) Column<std::int32_t> order;                                   ///< Slice by slice, unless is_in_order.
    bool is_in_order = true;                                                  ///< They come slice by slice.
    std::size_t count = 0;
    std::uint32_t first_of_call = 0; ///< Ray of the call that has number 0.

    /// Of placed rays those that are not empty, have pieces and are covered by rows; the others are named.
    void select(const Layout& layout, const PlacedRays& placed, const RowHits& hits,
                std::span<const std::uint32_t> piece, row_query::Uncovered& uncovered) {
        const auto d = lines_tag;
        static constexpr hn::RebindToSigned<LineTag> di;
        const std::size_t ray_count = piece.size() - 1;
        alignas(64) Column<std::int32_t> first_of; // one more than there are rays, and to the end of a vector
        for (std::size_t i = 0; i < piece.size(); ++i)
            first_of[i] = static_cast<std::int32_t>(piece[i] - piece[0]);
        count = 0;
        for (std::size_t i = 0; i < ray_count; i += hn::Lanes(d)) {
            const auto near = hn::Load(d, &placed.near_m[i]), far = hn::Load(d, &placed.far_m[i]);
            const auto first = hn::Load(di, &first_of[i]), past = hn::LoadU(di, &first_of[i + 1]);
            auto is_asked = hn::And(hn::Lt(near, far), hn::RebindMask(d, hn::Lt(first, past)));
            if (ray_count - i < hn::Lanes(d))
                is_asked = hn::And(is_asked, hn::FirstN(d, ray_count - i));
            const auto is_covered = hn::RebindMask(
                d, hn::Eq(hn::Load(di, &hits.cover[i]), hn::Set(di, static_cast<std::int32_t>(Cover::Rows))));
            for (std::uint32_t left = bits_of(hn::AndNot(is_covered, is_asked)); left != 0; left &= left - 1) {
                const std::size_t ray = i + static_cast<std::size_t>(__builtin_ctz(left));
                const bool is_near = static_cast<Cover>(hits.cover[ray]) == Cover::NearEpipole;
                (is_near ? uncovered.near_epipole : uncovered.outside)
                    .push_back(first_of_call + static_cast<std::uint32_t>(ray));
            }
            const auto kept = hn::And(is_asked, is_covered);
            const bool keeps_all = hn::AllTrue(d, kept);
            const auto keep = [&](auto value, auto& column) {
                const hn::DFromV<decltype(value)> tag;
                hn::StoreU(keeps_all ? value : hn::Compress(value, hn::RebindMask(tag, kept)), tag, &column[count]);
            };
            keep(hn::Load(d, &placed.slope[i]), slope);
            keep(hn::ConvertTo(d, hn::Load(di, &hits.first[i])), first_line);
            keep(hn::ConvertTo(d, hn::Load(di, &hits.last[i])), last_line);
            keep(hn::Load(d, &hits.near_index[i]), near_index);
            const auto radial_per_m = hn::Load(d, &placed.radial_per_m[i]);
            keep(hn::Div(hn::Set(d, layout.line_step), radial_per_m), m_per_line);
            keep(hn::Mul(radial_per_m, hn::Set(d, 1.0f / layout.line_step)), lines_per_m);
            keep(near, near_m);
            keep(far, far_m);
            keep(hn::Add(hn::Iota(di, 0), hn::Set(di, static_cast<std::int32_t>(i))), number);
            keep(hn::Load(di, &hits.slice[i]), slice);
            keep(first, first_piece);
            keep(hn::Sub(past, first), piece_count);
            count += hn::CountTrue(d, kept);
        }
    }

    /// Puts rays of a slice side by side, in the order that they come in: neighbours in the picture stay neighbours.
    /// Rays in more than most_slices slices share too little, and stay where they are.
    void sort() {
        constexpr std::int32_t most_slices = 1024;
        is_in_order = true;
        if (count == 0)
            return;
        static constexpr hn::RebindToSigned<LineTag> di;
        const auto last = hn::Set(di, slice[count - 1]);
        for (std::size_t i = 0; i < block_lines; i += hn::Lanes(di)) // what a vector reads past the end
            hn::StoreU(last, di, &slice[count + i]);
        auto all_least = last, all_most = last, falls = hn::Zero(di);
        for (std::size_t i = 0; i < count; i += hn::Lanes(di)) {
            const auto here = hn::Load(di, &slice[i]);
            falls = hn::Or(falls, hn::VecFromMask(di, hn::Lt(hn::LoadU(di, &slice[i + 1]), here)));
            all_least = hn::Min(all_least, here);
            all_most = hn::Max(all_most, here);
        }
        const std::int32_t least = hn::GetLane(hn::MinOfLanes(di, all_least)),
                           most = hn::GetLane(hn::MaxOfLanes(di, all_most));
        is_in_order = hn::AllTrue(di, hn::Eq(falls, hn::Zero(di))) || most - least >= most_slices;
        if (is_in_order)
            return;
        std::array<std::uint16_t, most_slices> next;
        const auto slice_count = static_cast<std::size_t>(most - least + 1);
        std::fill_n(next.begin(), slice_count, std::uint16_t{0});
        for (std::size_t i = 0; i < count; ++i)
            ++next[static_cast<std::size_t>(slice[i] - least)];
        std::uint16_t total = 0;
        for (std::size_t s = 0; s < slice_count; ++s)
            total = static_cast<std::uint16_t>(total + std::exchange(next[s], total));
        for (std::size_t i = 0; i < count; ++i)
            order[next[static_cast<std::size_t>(slice[i] - least)]++] = static_cast<std::int32_t>(i);
    }
    /// Of the rays of one slice from `begin` on, of which a vector takes as many as it can: how many.
    [[nodiscard]] std::size_t count_together(std::size_t begin) const {
        static constexpr hn::RebindToSigned<LineTag> di;
        const std::size_t most = std::min(count - begin, hn::Lanes(di));
        std::size_t together = 1;
        if (is_in_order) {
            const auto others = hn::Ne(hn::LoadU(di, &slice[begin]), hn::Set(di, slice[begin]));
            const auto first_other = hn::FindFirstTrue(di, others);
            return first_other < 0 ? most : std::min(most, static_cast<std::size_t>(first_other));
        }
        while (together < most && slice[ray(begin + together)] == slice[ray(begin)])
            ++together;
        return together;
    }
    [[nodiscard]] std::size_t ray(std::size_t at) const {
        return is_in_order ? at : static_cast<std::size_t>(order[at]);
    }
};
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
