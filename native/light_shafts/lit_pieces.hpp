// SPDX-License-Identifier: GPL-3.0-or-later
// Where the lit intervals and the scatter pieces of one ray overlap.
#pragma once
#include "light_shafts/visibility.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
/// Calls visit(piece, near_m, far_m, transmittance) for each lit part of each piece, near to far.
template <class Visit>
void for_each_lit_part(std::span<const ScatterPiece> pieces, std::span<const LitInterval> lit, const Visit& visit) {
    auto piece = pieces.begin();
    for (const LitInterval& interval : lit) {
        while (piece != pieces.end() && piece->far_m <= interval.near_m)
            ++piece;
        for (auto at = piece; at != pieces.end() && at->near_m < interval.far_m; ++at) {
            const float near_m = std::max(interval.near_m, at->near_m);
            const float far_m = std::min(interval.far_m, at->far_m);
            if (near_m < far_m)
                visit(*at, near_m, far_m, interval.transmittance);
        }
    }
}
} // namespace tyndall::light_shafts
