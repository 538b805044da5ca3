// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/visibility.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
void Visibility::add_scattered(std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                               std::span<float> lit_length_m) const {
    thread_local LitRows rows;
    rows.clear();
    lit_intervals(rays, rows);
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        std::uint32_t piece = pieces.first[ray];
        const std::uint32_t last_piece = pieces.first[ray + 1];
        for (std::uint32_t index = rows.first[ray]; index < rows.first[ray + 1]; ++index) {
            const LitInterval& lit = rows.intervals[index];
            while (piece < last_piece && pieces.pieces[piece].far_m <= lit.near_m)
                ++piece;
            for (std::uint32_t at = piece; at < last_piece && pieces.pieces[at].near_m < lit.far_m; ++at) {
                const float near_m = std::max(lit.near_m, pieces.pieces[at].near_m);
                const float far_m = std::min(lit.far_m, pieces.pieces[at].far_m);
                if (!(near_m < far_m))
                    continue;
                radiance[ray] += lit.transmittance * scattered(pieces.pieces[at], near_m, far_m);
                if (!lit_length_m.empty())
                    lit_length_m[ray] += (far_m - near_m) * average(lit.transmittance);
            }
        }
    }
}
} // namespace tyndall::light_shafts
