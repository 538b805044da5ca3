// SPDX-License-Identifier: GPL-3.0-or-later
// Where view rays are lit, for those who ask where the middle of a shaft is. Apart from the light that they carry: few
// pictures ask.
#include "core/parallel.hpp"
#include "light_shafts/prepared_lights.hpp"
#include "light_shafts/turns.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
static void add(LitMoments& moments, float near_m, float far_m, float weight) {
    if (!(near_m < far_m))
        return;
    const float length_m = weight * (far_m - near_m);
    moments.length_m += length_m;
    moments.moment_m2 += length_m * 0.5f * (near_m + far_m);
}

static void add_lit(LitMoments& moments, const MediumSegment& segment, std::span<const LitInterval> lit, float weight) {
    for (const LitInterval& interval : lit)
        add(moments, std::max(segment.near_m, interval.near_m), std::min(segment.far_m, interval.far_m),
            weight * average(interval.transmittance));
}

std::vector<LitMoments> Shafts::find_lit_moments(std::span<const ViewRay> rays, const Progress& progress,
                                                 Turn turn) const {
    std::vector<LitMoments> moments(rays.size());
    std::vector<std::uint32_t> order(rays.size());
    std::iota(order.begin(), order.end(), 0u);
    constexpr std::size_t rays_per_block = 256;
    parallel_blocks(rays.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        thread_local Block block;
        thread_local LitRows lit;
        prepared_->gather(rays, std::span(order).subspan(begin, end - begin), block);
        for (const LightBeams& light : prepared_->lights) {
            const Deal mine = deal(light.stratum_count(), turn);
            const float weight = prepared_->visibility_share(light) * mine.weight;
            if (weight == 0.0f)
                continue;
            for (std::size_t index = mine.first; index < mine.last; ++index) {
                const std::size_t first = spread(index, light.stratum_count()) * light.parts;
                for (const Beam& beam : std::span(light.beams).subspan(first, light.parts)) {
                    lit.clear();
                    if (beam.local) {
                        if (block.local.is_empty())
                            block.local.assign(prepared_->media, block.rays, block.first_segment, block.segments);
                        beam.local->lit_intervals(block.local, beam.visibility.get(), lit);
                    } else {
                        beam.visibility->lit_intervals(block.rays, lit);
                    }
                    for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
                        const std::span<const LitInterval> intervals = lit.of_ray(ray);
                        for (const MediumSegment& segment : block.segments_of(ray))
                            add_lit(moments[block.target[ray]], segment, intervals, weight);
                    }
                }
            }
        }
    });
    return moments;
}
} // namespace tyndall::light_shafts
