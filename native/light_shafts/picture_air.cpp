// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/picture_air.hpp"
#include "core/parallel.hpp"
#include "light_shafts/heterogeneity.hpp"
#include "light_shafts/row_query_air.hpp"
#include "light_shafts/turns.hpp"

namespace tyndall::light_shafts {
/// The beams that a turn asks of a light, and how much each counts.
template <class Visit>
static void for_asked_beams(const PreparedLights& prepared, const Turn& turn, const Visit& visit) {
    for (const LightBeams& light : prepared.lights) {
        const Deal mine = deal(light.stratum_count(), turn);
        const std::size_t stride = (mine.last - mine.first + most_strata_of_texture - 1) / most_strata_of_texture;
        for (std::size_t index = mine.first; index < mine.last; index += stride) {
            const std::size_t first = spread(index, light.stratum_count()) * light.parts;
            for (const Beam& beam : std::span(light.beams).subspan(first, light.parts))
                visit(beam, mine.weight * static_cast<float>(stride));
        }
    }
}

bool PictureAir::fits(const PreparedLights& prepared, const AirTexture& air, const Turn& turn) {
    if (air.heterogeneity().step_count > 128 || !prepared.media.grids().is_empty())
        return false;
    if (air.heterogeneity().weighting != Heterogeneity::Weighting::LitParts)
        return false;
    bool fit = true;
    for_asked_beams(prepared, turn, [&](const Beam& beam, float) {
        fit = fit && beam.directional && beam.visibility->coarse_rows() != nullptr;
    });
    return fit;
}

PictureAir::PictureAir(const PreparedLights& prepared, const Camera& camera, const AirTexture& air, const Turn& turn,
                       const Progress& progress)
    : columns_(prepared.media, camera, air, offset_in_step(turn), most_depth_of_light, progress) {
    if (columns_.is_empty())
        return;
    for_asked_beams(prepared, turn, [&](const Beam& beam, float weight) {
        beams_.push_back({beam.visibility->coarse_rows(), weight, columns_.find(*beam.directional, progress)});
    });
}

void PictureAir::find(std::span<const ViewRay> rays, std::span<float> heterogeneity, const Progress& progress) const {
    if (beams_.empty())
        return;
    const std::vector<std::uint32_t> asked = find_dark(heterogeneity, progress);
    if (asked.empty())
        return;
    const CoarseRows& coarse = *beams_.front().rows;
    const std::vector<std::uint32_t> order =
        row_query::by_wedge(coarse.rows->layout, rays, progress, coarse.stride, asked);
    constexpr std::size_t rays_per_block = 256;
    parallel_blocks(order.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        thread_local std::vector<ViewRay> block;
        thread_local std::vector<float> light, textured;
        thread_local row_query::Uncovered uncovered;
        block.resize(end - begin);
        light.assign(end - begin, 0.0f), textured.assign(end - begin, 0.0f);
        for (std::size_t at = begin; at < end; ++at)
            __builtin_prefetch(&rays[order[at]]);
        for (std::size_t at = begin; at < end; ++at) {
            ViewRay& ray = block[at - begin] = rays[order[at]];
            ray.near_m = std::max(ray.near_m, columns_.first_m());
            ray.far_m = std::min(ray.far_m, columns_.last_m());
        }
        for (const AskedBeam& beam : beams_) {
            uncovered.near_epipole.clear(), uncovered.outside.clear();
            row_query::add_lit_air(*beam.rows, columns_, beam.columns, beam.weight, block, {light, textured},
                                   uncovered);
            for (const auto* const rays_without : {&uncovered.near_epipole, &uncovered.outside})
                for (const std::uint32_t ray : *rays_without)
                    light[ray] = -std::numeric_limits<float>::infinity(); // to be asked alone
        }
        for (std::size_t at = begin; at < end; ++at)
            if (light[at - begin] > 0.0f)
                heterogeneity[order[at]] = textured[at - begin] / light[at - begin];
    });
}

std::shared_ptr<const PictureAir> Shafts::look_up_air(const Camera& camera, const AirTexture& air,
                                                      const Progress& progress, Turn turn) const {
    return !is_empty() && PictureAir::fits(*prepared_, air, turn)
               ? std::make_shared<const PictureAir>(*prepared_, camera, air, turn, progress)
               : nullptr;
}
} // namespace tyndall::light_shafts
