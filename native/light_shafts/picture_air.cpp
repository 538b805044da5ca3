// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/picture_air.hpp"
#include "core/parallel.hpp"
#include "light_shafts/heterogeneity.hpp"
#include "light_shafts/row_query_air.hpp"
#include "light_shafts/turns.hpp"
#include <algorithm>
#include <tbb/concurrent_vector.h>

namespace tyndall::light_shafts {
/// The beams that a turn asks of a light, and how much each counts.
template <class Visit>
static void for_asked_beams(const PreparedLights& prepared, const Turn& turn, const Visit& visit) {
    for (const LightBeams& light : prepared.lights)
        for_texture_beams(light, turn, visit);
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

PictureAir::PictureAir(const PreparedLights& prepared, const Camera& camera, const AirTexture& air, const Turn& turn)
    : air_(air), camera_(camera_of_columns(camera)),
      grid_(make_air_grid(prepared.media, camera_, air, most_depth_of_light)) {
    std::vector<const DirectionalScatter*> lights;
    for_asked_beams(prepared, turn, [&](const Beam& beam, float weight) {
        beams_.push_back({beam.visibility->coarse_rows(), weight});
        lights.push_back(&*beam.directional);
    });
    columns_ =
        std::make_unique<AirColumns>(prepared.media, camera_, grid_, air, offset_in_step(turn), std::move(lights));
}

bool PictureAir::shows_paint() const {
    // Smoke that is painted some voxels wide and a hundred times as bright as the air around it has to be met by each ray.
    constexpr float steps_per_voxel = 8.0f;
    return air_.least_voxel_m() >= steps_per_voxel * grid_.step_m;
}

std::vector<std::uint32_t> PictureAir::find(std::span<const ViewRay> rays, std::span<const std::uint32_t> asked,
                                            std::span<float> heterogeneity, const Progress& progress) const {
    if (asked.empty() || grid_.is_empty())
        return {};
    tbb::concurrent_vector<std::uint32_t> unanswered;
    const CoarseRows& coarse = *beams_.front().rows;
    const std::vector<std::uint32_t> order =
        row_query::by_wedge(coarse.rows->layout, rays, progress, coarse.stride, asked);
    constexpr std::size_t rays_per_block = 256;
    parallel_blocks(order.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        std::array<ViewRay, rays_per_block> of_block;
        std::array<float, rays_per_block> light{}, textured{};
        thread_local row_query::Uncovered uncovered;
        const std::span<const ViewRay> block = std::span(of_block).first(end - begin);
        // They lie in many lines of the picture; those of the next block arrive while this one is asked.
        for (std::size_t at = end; at < std::min(end + rays_per_block, order.size()); ++at)
            __builtin_prefetch(&rays[order[at]]);
        for (std::size_t at = begin; at < end; ++at) {
            ViewRay& ray = of_block[at - begin] = rays[order[at]];
            const float shift_m = grid_.shift_m(ray);
            ray.near_m = std::max(ray.near_m, grid_.first_m - shift_m);
            ray.far_m = std::min(ray.far_m, grid_.last_m() - shift_m);
        }
        for (std::size_t beam = 0; beam < beams_.size(); ++beam) {
            uncovered.near_epipole.clear(), uncovered.outside.clear();
            row_query::add_lit_air(*beams_[beam].rows, *columns_, beam, beams_[beam].weight, block, {light, textured},
                                   uncovered);
            for (const auto* const without : {&uncovered.near_epipole, &uncovered.outside})
                for (const std::uint32_t ray : *without)
                    light[ray] = -std::numeric_limits<float>::infinity(); // to be asked alone
        }
        for (std::size_t at = begin; at < end; ++at)
            if (light[at - begin] > 0.0f)
                heterogeneity[order[at]] = textured[at - begin] / light[at - begin];
            else if (light[at - begin] < 0.0f)
                unanswered.push_back(order[at]);
    });
    std::vector<std::uint32_t> result(unanswered.begin(), unanswered.end());
    std::ranges::sort(result); // threads find them in any order
    return result;
}

std::shared_ptr<const PictureAir> Shafts::picture_air(const Camera& camera, const AirTexture& air, Turn turn) const {
    if (is_empty() || !PictureAir::fits(*prepared_, air, turn))
        return nullptr;
    auto picture = std::make_shared<const PictureAir>(*prepared_, camera, air, turn);
    return picture->shows_paint() ? std::move(picture) : nullptr;
}
} // namespace tyndall::light_shafts
