// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/visibility.hpp"
#include "light_shafts/lit_pieces.hpp"

namespace tyndall::light_shafts {
void Visibility::add_scattered(std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                               std::span<float> lit_length_m) const {
    thread_local LitRows rows;
    rows.clear();
    lit_intervals(rays, rows);
    for (std::size_t ray = 0; ray < rays.size(); ++ray)
        for_each_lit_part(pieces.of_ray(ray), rows.of_ray(ray),
                          [&](const ScatterPiece& piece, float near_m, float far_m, const Rgb& transmittance) {
                              radiance[ray] += transmittance * scattered(piece, near_m, far_m);
                              if (!lit_length_m.empty())
                                  lit_length_m[ray] += (far_m - near_m) * average(transmittance);
                          });
}
} // namespace tyndall::light_shafts
