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

void add_lit_share(float begin, float end, float weight, std::span<float> shares) {
    begin = std::max(begin, 0.0f);
    end = std::min(end, static_cast<float>(shares.size()));
    if (!(begin < end))
        return;
    const auto first = static_cast<std::size_t>(begin),
               last = std::min(static_cast<std::size_t>(end), shares.size() - 1);
    if (first == last) {
        shares[first] += weight * (end - begin);
        return;
    }
    shares[first] += weight * (static_cast<float>(first + 1) - begin);
    for (std::size_t step = first + 1; step < last; ++step)
        shares[step] += weight;
    shares[last] += weight * (end - static_cast<float>(last));
}

void Visibility::find_lit_shares(std::span<const ViewRay> rays, const StepRows& steps, std::span<float> shares) const {
    thread_local LitRows rows;
    rows.clear();
    lit_intervals(rays, rows);
    std::ranges::fill(shares, 0.0f);
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        const std::span<float> own = shares.subspan(ray * steps.step_count, steps.step_count);
        const float per_m = 1.0f / steps.step_m[ray], begin_m = steps.begin_m[ray];
        for (const LitInterval& lit : rows.of_ray(ray))
            add_lit_share((lit.near_m - begin_m) * per_m, (lit.far_m - begin_m) * per_m, average(lit.transmittance),
                          own);
    }
}
} // namespace tyndall::light_shafts
