// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/row_query_scatter.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/row_query_scatter.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/row_query_alone-inl.hpp"
#include "light_shafts/row_query_packet-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
void add_scattered_of(const Rows& rows, std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                      std::span<float> lit_length_m, row_query::Unanswered& unanswered) {
    if (rows.layout.rows.empty()) {
        for (std::uint32_t i = 0; i < rays.size(); ++i)
            if (rays[i].near_m < rays[i].far_m && pieces.first[i] < pieces.first[i + 1])
                unanswered.outside.push_back(i);
        return;
    }
    PlacedRays placed;
    RowHits hits;
    Asked asked;
    PieceBatch batch;
    batch.count = 0;
    for (std::size_t start = 0; start < rays.size(); start += PlacedRays::capacity) {
        const auto block = rays.subspan(start, std::min(PlacedRays::capacity, rays.size() - start));
        place_rays(rows.layout.frame, block, placed);
        find_rows(rows.layout, placed, block.size(), hits);
        asked.first_of_call = static_cast<std::uint32_t>(start);
        asked.select(rows.layout, placed, hits, std::span(pieces.first).subspan(start, block.size() + 1), unanswered);
        asked.sort();
        const ScatterPiece* first_piece = pieces.pieces.data() + pieces.first[start];
        for (std::size_t begin = 0, end; begin < asked.count; begin = end) {
            end = begin + asked.count_together(begin);
            if (end - begin < least_packet ||
                !add_packet(rows, asked, begin, end, first_piece, radiance.subspan(start),
                            lit_length_m.empty() ? lit_length_m : lit_length_m.subspan(start)))
                for (std::size_t ray = begin; ray < end; ++ray)
                    add_alone(rows, asked, asked.ray(ray), first_piece, batch, radiance, lit_length_m, unanswered);
        }
    }
    flush(rows, batch, radiance, lit_length_m, unanswered);
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(add_scattered_of);
} // namespace tyndall::light_shafts

namespace tyndall::light_shafts::row_query {
void add_scattered(const slope_rows::Rows& rows, std::span<const ViewRay> rays, const PieceRows& pieces,
                   std::span<Rgb> radiance, std::span<float> lit_length_m, Unanswered& unanswered) {
    HWY_DYNAMIC_DISPATCH(add_scattered_of)(rows, rays, pieces, radiance, lit_length_m, unanswered);
}
} // namespace tyndall::light_shafts::row_query
#endif
