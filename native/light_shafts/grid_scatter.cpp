// SPDX-License-Identifier: GPL-3.0-or-later
// Asking a light about rays where there are density grids: those that meet one, or whose light may pass one, apart from the
// others, which have closed forms.
#include "light_shafts/prepared_lights.hpp"
#include "light_shafts/ratio_tracking.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
void PreparedLights::gather_in_grids(const Beam& beam, Block& block) const {
    Block::InGrids& part = block.in_grids;
    part.rays.clear(), part.row.clear(), part.segments.clear();
    part.first_segment.assign(1, 0);
    for (std::uint32_t ray = 0; ray < block.rays.size(); ++ray) {
        const auto has_share = [](const MediumStep& step) { return step.share_count > 0; };
        const ViewRay& own = block.rays[ray];
        if (!std::ranges::any_of(block.steps.of_ray(ray), has_share) && !beam.is_dimmed_by_grids(own))
            continue;
        part.rays.push_back(own);
        part.row.push_back(ray);
        const auto segments = block.segments_of(ray);
        part.segments.insert(part.segments.end(), segments.begin(), segments.end());
        part.first_segment.push_back(static_cast<std::uint32_t>(part.segments.size()));
    }
    part.radiance.resize(part.rays.size());
    part.unshadowed.resize(block.unshadowed.empty() ? 0 : part.rays.size());
}

void PreparedLights::track_in_grids(const Beam& beam, std::span<float> lit_length_m, Block& block) const {
    Block::InGrids& part = block.in_grids;
    part.lit.clear();
    beam.visibility->lit_intervals(part.rays, part.lit);
    track_ratios(media, beam.sample, seed, {part.rays, part.first_segment, part.segments, part.lit}, part.radiance,
                 part.unshadowed);
    if (beam.local || lit_length_m.empty())
        return;
    for (std::size_t index = 0; index < part.rays.size(); ++index)
        for (const LitInterval& lit : part.lit.of_ray(index))
            for (const MediumSegment& segment : block.segments_of(part.row[index]))
                lit_length_m[part.row[index]] +=
                    average(lit.transmittance) *
                    std::max(0.0f, std::min(lit.far_m, segment.far_m) - std::max(lit.near_m, segment.near_m));
}

void PreparedLights::add_in_grids(const LightBeams& light, const Beam& beam, std::span<float> lit_length_m,
                                  Block& block) const {
    Block::InGrids& part = block.in_grids;
    if (beam.local || tracks_ratios)
        gather_in_grids(beam, block);
    if (beam.directional) {
        block.pieces.clear();
        std::size_t next = 0; // of those that are tracked
        for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
            if (tracks_ratios && next < part.row.size() && part.row[next] == ray)
                ++next;
            else
                beam.directional->append_grid_pieces(block.rays[ray], block.segments_of(ray), block.steps, ray,
                                                     block.pieces.pieces);
            block.pieces.end_ray();
        }
        add_pieces(light, beam, lit_length_m, block);
        if (!tracks_ratios)
            return;
        track_in_grids(beam, lit_length_m, block);
        for (std::size_t index = 0; index < part.rays.size(); ++index)
            block.radiance[part.row[index]] += part.radiance[index];
        return;
    }
    part.radiance_of_all.assign(block.rays.size(), Rgb(0.0f));
    part.unshadowed_of_all.assign(block.unshadowed.size(), Rgb(0.0f));
    if (part.rays.size() < block.rays.size() || !lit_length_m.empty())
        beam.local->add_scattered(block.local, beam.visibility.get(), part.radiance_of_all, part.unshadowed_of_all,
                                  lit_length_m);
    if (tracks_ratios) {
        track_in_grids(beam, lit_length_m, block);
    } else if (!part.rays.empty()) {
        part.local.assign(media, part.rays, part.first_segment, part.segments);
        beam.local->scatter_in_grids(part.local, block.steps, part.row, beam.visibility.get(), part.radiance,
                                     part.unshadowed);
    }
    for (std::size_t index = 0; index < part.rays.size(); ++index) {
        part.radiance_of_all[part.row[index]] = part.radiance[index];
        if (!part.unshadowed.empty())
            part.unshadowed_of_all[part.row[index]] = part.unshadowed[index];
    }
    for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
        block.radiance[ray] += part.radiance_of_all[ray];
        if (!block.unshadowed.empty())
            block.unshadowed[ray] += part.unshadowed_of_all[ray];
    }
}
} // namespace tyndall::light_shafts
