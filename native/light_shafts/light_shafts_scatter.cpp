// SPDX-License-Identifier: GPL-3.0-or-later
// Asking the prepared lights: which strata in which turn, for which rays, block by block.
#include "core/parallel.hpp"
#include "light_shafts/prepared_lights.hpp"
#include "light_shafts/shared_strata.hpp"
#include "light_shafts/textured_beam.hpp"
#include "light_shafts/turns.hpp"
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace tyndall::light_shafts {
namespace {
/// Between how many cells of a square of pixels the strata of a light are dealt out, in one of turn_count passes.
struct Sharing {
    std::size_t side = 0; ///< Into shared_sides.
    std::uint32_t count = 1;
};
Sharing sharing(std::size_t beam_count, std::uint32_t turn_count) {
    // A power of two: each count of cells has as many pixels.
    const auto count =
        static_cast<std::uint32_t>(std::bit_floor(std::clamp<std::size_t>(beam_count / turn_count, 1, 16)));
    return {count == 1 ? 0u : count <= 4 ? 1u : 2u, count};
}
} // namespace

void PreparedLights::gather(std::span<const ViewRay> rays, std::span<const std::uint32_t> order, Block& block) const {
    block.rays.clear(), block.target.clear(), block.length_m.clear(), block.segments.clear();
    block.local.clear();
    block.steps.clear();
    block.first_segment.assign(1, 0);
    for (const std::uint32_t index : order) // they lie in many lines of the picture
        __builtin_prefetch(&rays[index]);
    for (const std::uint32_t index : order) {
        const ViewRay& ray = rays[index];
        const MediaRay clipped = clip_to_media(media, ray, block.segments);
        if (!(clipped.clipped.near_m < clipped.clipped.far_m)) {
            block.segments.resize(block.first_segment.back());
            continue;
        }
        block.rays.push_back(clipped.clipped);
        block.target.push_back(index);
        block.length_m.push_back(clipped.length_in_media_m);
        block.first_segment.push_back(static_cast<std::uint32_t>(block.segments.size()));
        if (!media.grids().is_empty())
            append_steps(media, {ray.origin, ray.direction, clipped.clipped.near_m, clipped.clipped.far_m},
                         block.segments_of(block.rays.size() - 1), step_limits, block.steps);
    }
}

void PreparedLights::swap_unlit(std::span<const UnlitMedium> unlit, Block& block) {
    if (unlit.empty())
        return;
    block.local.clear();
    if (!block.lit_segments.empty()) {
        block.segments.swap(block.lit_segments);
        block.lit_segments.clear();
        return;
    }
    block.lit_segments = block.segments;
    for (MediumSegment& segment : block.segments) {
        MediumSet set;
        for (const std::uint16_t medium : std::span(segment.set.media).first(segment.set.count)) {
            const auto found = std::ranges::find(unlit, medium, &UnlitMedium::medium);
            set.insert(found == unlit.end() ? medium : found->dark);
        }
        segment.set = set;
    }
}

void PreparedLights::begin_sums(Block& block) {
    block.all_radiance.assign(block.rays.size(), Rgb(0.0f));
    for (std::vector<Rgb>* const apart : {&block.patterned, &block.all_unshadowed})
        apart->assign(block.keeps_patterned_apart ? block.rays.size() : 0, Rgb(0.0f));
    block.visibility.assign(block.rays.size(), 0.0f);
}

void PreparedLights::add(const LightBeams& light, std::size_t stratum, Block& block) const {
    const bool tells_visibility = block.wants_visibility && visibility_share(light) > 0.0f;
    const std::span lit_length_m = tells_visibility ? std::span(block.lit_length_m) : std::span<float>();
    for (const Beam& beam : std::span(light.beams).subspan(stratum * light.parts, light.parts)) {
        if (beam.local && block.local.is_empty())
            block.local.assign(media, block.rays, block.first_segment, block.segments);
        if (!media.grids().is_empty()) {
            add_in_grids(light, beam, lit_length_m, block);
            continue;
        }
        if (beam.local) {
            beam.local->add_scattered(block.local, beam.visibility.get(), block.radiance, block.unshadowed,
                                      lit_length_m);
            continue;
        }
        block.pieces.clear();
        for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
            beam.directional->append_pieces(block.rays[ray], block.segments_of(ray), block.pieces.pieces);
            block.pieces.end_ray();
        }
        add_pieces(light, beam, lit_length_m, block);
    }
}

void PreparedLights::add_inside(const LightBeams& light, Block& block, std::span<Rgb> radiance, float share) const {
    if (!light.inside)
        return;
    swap_unlit(light.unlit_media, block);
    for (std::size_t ray = 0; ray < block.rays.size(); ++ray)
        radiance[ray] += share * light.inside->along(media, block.rays[ray], block.segments_of(ray));
    swap_unlit(light.unlit_media, block);
}

void PreparedLights::add_pieces(const LightBeams& light, const Beam& beam, std::span<float> lit_length_m,
                                Block& block) {
    if (beam.sample.textured != nullptr)
        add_textured(*beam.visibility, *beam.sample.textured, light.texture_rows.get(), block.rays, block.pieces,
                     block.radiance, lit_length_m);
    else
        beam.visibility->add_scattered(block.rays, block.pieces, block.radiance, lit_length_m);
}

void PreparedLights::add(const LightBeams& light, const Turn& turn, Block& block) const {
    block.lit_length_m.assign(block.rays.size(), 0.0f);
    block.radiance.assign(block.rays.size(), Rgb(0.0f));
    const bool is_apart = block.keeps_patterned_apart && light.has_pattern;
    block.unshadowed.assign(is_apart ? block.rays.size() : 0, Rgb(0.0f));
    const Deal mine = deal(light.stratum_count(), turn);
    swap_unlit(light.unlit_media, block);
    for (std::size_t index = mine.first; index < mine.last; ++index)
        add(light, spread(index, light.stratum_count()), block);
    swap_unlit(light.unlit_media, block);
    const float share = visibility_share(light) * mine.weight / static_cast<float>(light.stratum_count());
    const auto most = static_cast<float>(mine.last - mine.first);
    std::vector<Rgb>& sum = is_apart ? block.patterned : block.all_radiance;
    for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
        sum[ray] += mine.weight * block.radiance[ray];
        if (is_apart)
            block.all_unshadowed[ray] += mine.weight * block.unshadowed[ray];
        if (block.length_m[ray] > 0.0f)
            block.visibility[ray] += share * std::min(most, block.lit_length_m[ray] / block.length_m[ray]);
    }
}

void Shafts::scatter(std::span<const ViewRay> rays, std::span<Rgb> radiance, std::span<float> average_visibility,
                     const Progress& progress, Turn turn) const {
    scatter(rays, {}, {Scattered{radiance, average_visibility, {}, {}}}, progress, turn);
}

std::vector<Air> Shafts::find_air(std::span<const ViewRay> rays, const Progress& progress) const {
    const Media& media = prepared_->media;
    std::vector<Air> air(rays.size());
    parallel_blocks(rays.size(), 4096, progress, [&](std::size_t begin, std::size_t end) {
        std::vector<MediumSegment> segments;
        for (std::size_t ray = begin; ray < end; ++ray) {
            segments.clear();
            const ViewRay clipped = clip_to_media(media, rays[ray], segments).clipped;
            Rgb depth(0.0f);
            for (const MediumSegment& segment : segments)
                depth += media.sigma_t_per_m(segment.set) * (segment.far_m - segment.near_m);
            if (!media.grids().is_empty())
                depth +=
                    media.grids().optical_depth({clipped.origin, clipped.direction, clipped.near_m, clipped.far_m});
            const float opacity = -(std::expm1(-depth.x) + std::expm1(-depth.y) + std::expm1(-depth.z)) / 3.0f;
            air[ray] = {clipped.near_m, clipped.far_m, opacity};
        }
    });
    return air;
}

void Shafts::set_alone(std::span<const ViewRay> rays, const View& view, std::uint32_t turn_count,
                       std::span<std::uint8_t> cells, const Progress& progress) const {
    constexpr float spacings = 8.0f; // the mean of 1 / distance over two pixels around is then right to 2 %
    std::vector<vec3> lamps;
    for (const LightBeams& light : prepared_->lights)
        if (light.beams.front().local && sharing(light.stratum_count(), turn_count).count > 1)
            lamps.push_back(light.lamp_position);
    parallel_for(rays.size(), progress, [&](std::size_t ray) {
        for (const vec3& lamp : lamps) {
            const vec3 way = lamp - rays[ray].origin;
            const float along = glm::dot(way, rays[ray].direction);
            const float limit = spacings * view.spacing * (view.is_orthographic ? 1.0f : along);
            if (along > rays[ray].near_m && glm::dot(way, way) - along * along < limit * limit)
                cells[ray] = alone_cell;
        }
    });
}

std::array<bool, shared_sides.size()> Shafts::sides_used(std::uint32_t turn_count) const {
    std::array<bool, shared_sides.size()> used{true}; // rays that are alone, even where every light is shared
    for (const LightBeams& light : prepared_->lights)
        used[sharing(light.stratum_count(), turn_count).side] = true;
    return used;
}

void Shafts::scatter(std::span<const ViewRay> rays, std::span<const std::uint8_t> cells, const ScatteredBySide& out,
                     const Progress& progress, Turn turn) const {
    scatter(rays, cells, std::span(&out, 1), progress, turn);
}

void Shafts::scatter(std::span<const ViewRay> rays, std::span<const std::uint8_t> cells,
                     std::span<const ScatteredBySide> by_slot, const Progress& progress, Turn turn) const {
    require(by_slot.size() == 1 || by_slot.size() == slots().size(), "scatter: ", by_slot.size(), " results for ",
            slots().size(), " slots");
    require(turn.index < turn.count, "scatter: turn ", turn.index, " of ", turn.count);
    require(cells.empty() || cells.size() == rays.size(), "scatter: ", rays.size(), " rays with ", cells.size(),
            " cells");
    const std::array used = cells.empty() ? std::array{true, false, false} : sides_used(turn.count);
    for (const ScatteredBySide& out : by_slot)
        for (std::size_t side = 0; side < shared_sides.size(); ++side) {
            const auto& [radiance, visibility, patterned, unshadowed] = out[side];
            const auto fits = [&](std::size_t size) { return size == 0 || size == rays.size(); };
            require(!used[side] || (radiance.size() == rays.size() && fits(visibility.size()) &&
                                    fits(patterned.size()) && patterned.size() == unshadowed.size()),
                    "scatter: ", rays.size(), " rays, but room for ", radiance.size(), " results");
            for (const std::span<Rgb> light : {radiance, patterned, unshadowed})
                std::ranges::fill(light, Rgb(0.0f));
            std::ranges::fill(visibility, 0.0f);
        }
    if (is_empty())
        return;
    // In the picture's order neighbours read different rows: 7 to 10 times slower at 8,192 lines.
    std::vector<std::uint32_t> order = prepared_->finest->coherent_order(rays, progress);
    if (order.empty()) {
        order.resize(rays.size());
        std::iota(order.begin(), order.end(), 0u);
    }
    for (std::size_t side = 0; side < shared_sides.size(); ++side)
        if (used[side])
            prepared_->scatter_side(rays, cells, order, side, by_slot, progress, turn);
}

void PreparedLights::scatter_side(std::span<const ViewRay> rays, std::span<const std::uint8_t> cells,
                                  std::span<const std::uint32_t> order, std::size_t side,
                                  std::span<const ScatteredBySide> by_slot, const Progress& progress,
                                  const Turn& turn) const {
    // Rays of one cell ask for the same strata: a block has one cell, and keeps the order within it. After the cells of
    // side 0, of which there is one, follow the rays that share nothing.
    const std::uint32_t cell_count = shared_sides[side] * shared_sides[side];
    std::vector<std::vector<std::uint32_t>> by_cell(cell_count + 1);
    for (const std::uint32_t ray : order)
        if (const bool is_alone = !cells.empty() && cells[ray] == alone_cell; !is_alone)
            by_cell[cells.empty() ? 0 : cells[ray] * cell_count / 16].push_back(ray);
        else if (side == 0)
            by_cell[cell_count].push_back(ray);
    constexpr std::size_t rays_per_block = 256; // their pieces and intervals stay in the first-level cache
    for (std::uint32_t cell = 0; cell <= cell_count; ++cell) {
        const std::span<const std::uint32_t> mine(by_cell[cell]);
        const bool is_alone = cell == cell_count;
        parallel_blocks(mine.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
            thread_local Block block;
            gather(rays, mine.subspan(begin, end - begin), block);
            for (std::size_t slot = 0; slot < by_slot.size(); ++slot) {
                const Scattered& out = by_slot[slot][side];
                block.wants_visibility = !out.average_visibility.empty();
                block.keeps_patterned_apart = !out.patterned.empty();
                begin_sums(block);
                for (const LightBeams& light : lights) {
                    if (by_slot.size() > 1 && light.slot != slot)
                        continue;
                    if (side == 0) // no stratum of it is shared
                        add_inside(light, block, block.all_radiance);
                    const Sharing shared =
                        cells.empty() || is_alone ? Sharing{} : sharing(light.stratum_count(), turn.count);
                    const std::uint32_t turns_before = is_alone ? 0 : cell * shared.count / cell_count * turn.count;
                    if (!block.rays.empty() && shared.side == side)
                        add(light, {turns_before + turn.index, shared.count * turn.count}, block);
                }
                for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
                    out.radiance[block.target[ray]] = block.all_radiance[ray];
                    if (block.keeps_patterned_apart) {
                        out.patterned[block.target[ray]] = block.patterned[ray];
                        out.patterned_unshadowed[block.target[ray]] = block.all_unshadowed[ray];
                    }
                    if (!out.average_visibility.empty())
                        out.average_visibility[block.target[ray]] = block.visibility[ray];
                }
            }
        });
    }
}

} // namespace tyndall::light_shafts
