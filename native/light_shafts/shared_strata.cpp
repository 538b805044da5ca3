// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/shared_strata.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace tyndall::light_shafts {
/// Two pixels see much the same air: it begins and ends within a tenth of its distance.
static bool is_alike(const Air& a, const Air& b) {
    constexpr float tolerance = 0.1f;
    const auto near_each_other = [&](float at_a, float at_b) {
        return at_a == at_b || std::abs(at_a - at_b) <= tolerance * std::min(at_a, at_b);
    };
    return b.opacity > 0.0f && near_each_other(a.far_m, b.far_m) && near_each_other(a.near_m, b.near_m);
}

void add_shared(const PictureRays& picture, std::uint32_t side, std::uint32_t first_row, std::uint32_t end_row,
                const ConstScattered& shared, const Scattered& sum, const Progress& progress) {
    const auto reach = static_cast<std::int32_t>(side / 2);
    const auto width = static_cast<std::int32_t>(picture.width_px),
               height = static_cast<std::int32_t>(picture.height_px);
    const auto share_of = [&](std::int32_t offset) { return std::abs(offset) == reach ? 0.5f : 1.0f; };
    // A pixel's own stratum alone would draw the edge of a cone where no other stratum has it.
    const auto share_here = [&](std::int32_t offset) {
        return std::max(0.0f, 1.0f - static_cast<float>(std::abs(offset)) / std::max(1.0f, static_cast<float>(reach)));
    };
    const bool has_visibility = !shared.average_visibility.empty(), has_patterned = !shared.patterned.empty();
    parallel_for(
        end_row - first_row, progress,
        [&](std::size_t row) {
            const auto y = static_cast<std::int32_t>(first_row + row);
            for (std::int32_t x = 0; x < width; ++x) {
                const auto pixel = static_cast<std::size_t>(y) * picture.width_px + static_cast<std::size_t>(x);
                for (std::uint32_t ray = picture.first_ray[pixel]; ray < picture.first_ray[pixel + 1]; ++ray) {
                    const Air& air = picture.air[ray];
                    if (picture.cells[ray] == alone_cell || !(air.opacity > 0.0f))
                        continue;
                    Rgb radiance(0.0f), patterned(0.0f), unshadowed(0.0f), unshadowed_here(0.0f);
                    float visibility = 0.0f, weight_sum = 0.0f, weight_here = 0.0f, opacity_sum = 0.0f;
                    for (std::int32_t dy = std::max(-reach, -y); dy <= std::min(reach, height - 1 - y); ++dy)
                        for (std::int32_t dx = std::max(-reach, -x); dx <= std::min(reach, width - 1 - x); ++dx) {
                            const auto beside = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(pixel) +
                                                                         static_cast<std::ptrdiff_t>(dy) * width + dx);
                            std::uint32_t other = picture.first_ray[beside];
                            const std::uint32_t end = picture.first_ray[beside + 1];
                            while (other < end &&
                                   (picture.cells[other] == alone_cell || !is_alike(air, picture.air[other])))
                                ++other;
                            if (other == end)
                                continue;
                            const float weight = share_of(dx) * share_of(dy);
                            radiance += weight * shared.radiance[other];
                            if (has_patterned) {
                                patterned += weight * shared.patterned[other];
                                unshadowed += weight * shared.patterned_unshadowed[other];
                                const float here = share_here(dx) * share_here(dy);
                                unshadowed_here += here * shared.patterned_unshadowed[other];
                                weight_here += here;
                            }
                            if (has_visibility)
                                visibility += weight * shared.average_visibility[other];
                            weight_sum += weight;
                            opacity_sum += weight * picture.air[other].opacity;
                        }
                    // Neither sum is 0: the ray itself is like itself.
                    sum.radiance[ray] += radiance * (air.opacity / opacity_sum);
                    for (int channel = 0; has_patterned && channel < 3; ++channel)
                        if (unshadowed[channel] > 0.0f)
                            sum.radiance[ray][channel] +=
                                patterned[channel] / unshadowed[channel] * unshadowed_here[channel] / weight_here;
                    if (has_visibility)
                        sum.average_visibility[ray] += visibility / weight_sum;
                }
            }
        },
        1);
}
} // namespace tyndall::light_shafts
