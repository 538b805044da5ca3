// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_shafts.hpp"
#include "core/parallel.hpp"
#include "light_shafts/exact_strip.hpp"
#include "light_shafts/light_shares.hpp"
#include "light_shafts/local_scatter.hpp"
#include "light_shafts/occluders.hpp"
#include "light_shafts/ray_outline.hpp"
#include "light_shafts/scatter_pieces.hpp"
#include "light_shafts/scattering_lights.hpp"
#include "light_shafts/visibility.hpp"
#include <algorithm>
#include <bit>
#include <numeric>
#include <optional>

namespace tyndall::light_shafts {
namespace {
void validate(const Config& config) {
    require_in(config.error_target, 1e-5f, 0.1f, "error_target");
    if (config.resolution != 0)
        require_in(static_cast<float>(config.resolution), 16.0f, 16384.0f, "resolution");
    require_in(static_cast<float>(config.light_samples), 1.0f, 65536.0f, "light_samples");
    require_in(static_cast<float>(config.world_samples), 0.0f, 65536.0f, "world_samples");
}

/// What a light sample may cost. `share_of_frame` and `share_of_light` are shares of the scattered light; a resolution
/// that the artist sets is that of a whole light.
Config config_of_share(const Config& config, float share_of_frame, float share_of_light) {
    Config result = config;
    result.error_target = error_of_share(config.error_target, share_of_frame);
    if (config.resolution != 0)
        result.resolution = std::max(
            16u, static_cast<std::uint32_t>(static_cast<float>(config.resolution) * std::sqrt(share_of_light)));
    return result;
}

/// The stretch of a ray that lies in media, in front of its surface.
struct MediaRay {
    ViewRay clipped;
    float length_in_media_m = 0.0f;
};

/// Appends the segments of a ray; in the world's medium an endless ray ends where 1e-17 of its light would be left.
MediaRay clip_to_media(const Media& media, const ViewRay& ray, std::vector<MediumSegment>& segments) {
    const std::size_t first = segments.size();
    MediaRay result{.clipped = {ray.origin, ray.direction, ray.near_m, ray.near_m}};
    if (!(ray.near_m < ray.far_m))
        return result;
    media.segments({.origin = ray.origin, .direction = ray.direction, .near_m = ray.near_m, .far_m = ray.far_m},
                   segments);
    if (segments.size() == first)
        return result;
    if (MediumSegment& last = segments.back(); std::isinf(last.far_m)) {
        const Rgb sigma_t = media.sigma_t_per_m(last.set);
        float least = std::numeric_limits<float>::infinity();
        for (int channel = 0; channel < 3; ++channel)
            if (sigma_t[channel] > 0.0f)
                least = std::min(least, sigma_t[channel]);
        last.far_m = last.near_m + (std::isinf(least) ? 0.0f : 40.0f / least);
    }
    result.clipped.near_m = segments[first].near_m;
    result.clipped.far_m = segments.back().far_m;
    for (std::size_t segment = first; segment < segments.size(); ++segment)
        result.length_in_media_m += segments[segment].far_m - segments[segment].near_m;
    return result;
}

/// One light sample, ready for rays.
struct Beam {
    LightSample sample;
    std::size_t share = 0; ///< Into LightShares.
    std::unique_ptr<const Visibility> visibility;
    std::optional<DirectionalScatter> directional;
    std::optional<LocalScatter> local;
};
struct LightBeams {
    std::vector<Beam> beams;
};

/// The beams of a light that are this turn's: beams[permuted(i)] for i in [first, last), each `weight` times.
struct Deal {
    std::size_t first, last;
    float weight;
};
Deal deal(std::size_t beam_count, const Turn& turn) {
    if (beam_count >= turn.count)
        return {.first = turn.index * beam_count / turn.count,
                .last = (turn.index + 1) * beam_count / turn.count,
                .weight = static_cast<float>(turn.count)};
    const std::size_t beam = turn.index % beam_count;
    const std::size_t use_count = turn.count / beam_count + (beam < turn.count % beam_count ? 1 : 0);
    return {.first = beam, .last = beam + 1, .weight = static_cast<float>(turn.count) / static_cast<float>(use_count)};
}
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
/// A permutation that spreads consecutive indices over all beams, by steps near the golden section.
std::size_t spread(std::size_t index, std::size_t count) {
    std::size_t step = std::max<std::size_t>(1, count * 618 / 1000);
    while (std::gcd(step, count) != 1)
        ++step;
    return index * step % count;
}

/// The rays of a block with their media: found once, used by every light.
struct Block {
    std::vector<ViewRay> rays;         ///< Those that meet a medium, clipped to it.
    std::vector<std::uint32_t> target; ///< Their index in the caller's span.
    std::vector<float> length_m;
    std::vector<std::uint32_t> first_segment;
    std::vector<MediumSegment> segments;
    std::vector<Rgb> radiance;     ///< Of one light.
    std::vector<Rgb> all_radiance; ///< Of all so far.
    std::vector<float> lit_length_m, visibility;
    PieceRows pieces;
    LocalRays local; ///< The same for lights at points; empty until one asks.
    bool wants_visibility = false;

    [[nodiscard]] std::span<const MediumSegment> segments_of(std::size_t ray) const {
        return std::span(segments).subspan(first_segment[ray], first_segment[ray + 1] - first_segment[ray]);
    }
};
} // namespace

struct Shafts::Prepared {
    const Media& media;
    std::vector<LightBeams> lights;
    const Visibility* finest = nullptr; ///< Of the sample that carries most light, and so has the largest rows.
    Statistics statistics;

    void gather(std::span<const ViewRay> rays, std::span<const std::uint32_t> order, Block& block) const;
    void add(const Beam& beam, Block& block) const;
    void add(const LightBeams& light, const Turn& turn, Block& block) const;
    /// Of the lights that squares of shared_sides[side] pixels share.
    void scatter_side(std::span<const ViewRay> rays, std::span<const std::uint8_t> cells,
                      std::span<const std::uint32_t> order, std::size_t side, const Scattered& out,
                      const Progress& progress, const Turn& turn) const;
};

Shafts::~Shafts() = default;
bool Shafts::is_empty() const { return prepared_->lights.empty(); }
const Statistics& Shafts::statistics() const { return prepared_->statistics; }

Shafts::Shafts(const Scene& scene, const Media& media, const View& view, std::span<const ViewRay> rays,
               const Config& config, Progress& progress)
    : prepared_(std::make_unique<Prepared>(Prepared{.media = media, .lights = {}, .statistics = {}})) {
    validate(config);
    Statistics& statistics = prepared_->statistics;
    if (media.is_empty()) {
        statistics.skip("light shafts", "no medium in the scene");
        return;
    }
    const std::vector<ScatteringLight> lights = find_scattering_lights(scene, media, config, statistics);
    if (lights.empty()) {
        statistics.skip("light shafts", "no light scatters in a medium");
        return;
    }
    std::vector<ViewRay> clipped(rays.size());
    parallel_blocks(rays.size(), 4096, progress, [&](std::size_t begin, std::size_t end) {
        std::vector<MediumSegment> segments;
        for (std::size_t ray = begin; ray < end; ++ray) {
            segments.clear();
            clipped[ray] = clip_to_media(media, rays[ray], segments).clipped;
        }
    });
    std::erase_if(clipped, [](const ViewRay& ray) { return !(ray.near_m < ray.far_m); });
    if (clipped.empty()) {
        statistics.skip("light shafts", "no view ray meets a medium");
        return;
    }
    LightShares shares(media, clipped);
    for (const ScatteringLight& light : lights) {
        LightBeams beams;
        for (const LightSample& sample : light.samples) {
            progress.poll();
            Beam beam;
            beam.sample = sample;
            if (sample.is_directional)
                shares.add(beam.directional.emplace(media, sample, config.attenuates_light));
            else
                shares.add(beam.local.emplace(media, sample, config.attenuates_light));
            beam.share = shares.size() - 1;
            if (!(sample.is_directional ? beam.directional->is_black() : beam.local->is_black()))
                beams.beams.push_back(std::move(beam));
        }
        if (beams.beams.empty())
            statistics.skip("light shafts of " + light.name, "no medium scatters its light");
        else
            prepared_->lights.push_back(std::move(beams));
    }
    std::vector<std::pair<Beam*, float>> all_beams; // with the share of their light
    for (LightBeams& light : prepared_->lights)
        for (Beam& beam : light.beams)
            all_beams.emplace_back(&beam, 1.0f / static_cast<float>(light.beams.size()));
    progress.set_message("Light shafts: " + std::to_string(all_beams.size()) + " light samples");
    std::shared_ptr<const StripScene> strip;
    Occluders occluders;
    std::vector<RaySpan> outer_rays;
    if (all_beams.empty())
        return;
    if (config.method == Method::Exact) {
        const StageTimer timer(statistics, "light shafts: hierarchies for cuts");
        strip = std::make_shared<const StripScene>(make_strip_scene(scene, progress));
    } else {
        occluders = gather_occluders(scene.description(), progress);
        outer_rays = outline(view.is_orthographic, clipped, progress);
    }
    parallel_for(
        all_beams.size(), progress,
        [&](std::size_t index) {
            auto& [beam, share_of_light] = all_beams[index];
            const Config share = config_of_share(config, shares.share(beam->share), share_of_light);
            if (config.method == Method::Exact)
                beam->visibility = make_exact_strip(scene, beam->sample, strip);
            else if (config.method == Method::Epipolar)
                beam->visibility =
                    make_epipolar_beam(scene, occluders, view, beam->sample, outer_rays, share, progress);
            else
                beam->visibility =
                    make_shadow_map_beam(scene, occluders, view, beam->sample, outer_rays, share, progress);
        },
        1);
    float most = -1.0f;
    for (const LightBeams& light : prepared_->lights) {
        for (const Beam& beam : light.beams)
            if (shares.share(beam.share) > most) {
                most = shares.share(beam.share);
                prepared_->finest = beam.visibility.get();
            }
        statistics.append(light.beams.front().visibility->statistics()); // one tells of its light; a world has many
    }
    statistics.count("light shafts: light samples", static_cast<double>(all_beams.size()));
}

void Shafts::Prepared::gather(std::span<const ViewRay> rays, std::span<const std::uint32_t> order, Block& block) const {
    block.rays.clear(), block.target.clear(), block.length_m.clear(), block.segments.clear();
    block.local.clear();
    block.first_segment.assign(1, 0);
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
    }
    block.all_radiance.assign(block.rays.size(), Rgb(0.0f));
    block.visibility.assign(block.rays.size(), 0.0f);
}

void Shafts::Prepared::add(const Beam& beam, Block& block) const {
    if (beam.directional) {
        block.pieces.clear();
        for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
            beam.directional->append_pieces(block.rays[ray], block.segments_of(ray), block.pieces.pieces);
            block.pieces.end_ray();
        }
        beam.visibility->add_scattered(block.rays, block.pieces, block.radiance, block.lit_length_m);
        return;
    }
    if (block.local.is_empty())
        block.local.assign(media, block.rays, block.first_segment, block.segments);
    beam.local->add_scattered(block.local, beam.visibility.get(), block.radiance,
                              block.wants_visibility ? std::span(block.lit_length_m) : std::span<float>());
}

void Shafts::Prepared::add(const LightBeams& light, const Turn& turn, Block& block) const {
    block.lit_length_m.assign(block.rays.size(), 0.0f);
    block.radiance.assign(block.rays.size(), Rgb(0.0f));
    const Deal mine = deal(light.beams.size(), turn);
    for (std::size_t index = mine.first; index < mine.last; ++index)
        add(light.beams[spread(index, light.beams.size())], block);
    const float share = mine.weight / static_cast<float>(light.beams.size() * lights.size());
    const auto most = static_cast<float>(mine.last - mine.first);
    for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
        block.all_radiance[ray] += mine.weight * block.radiance[ray];
        if (block.length_m[ray] > 0.0f)
            block.visibility[ray] += share * std::min(most, block.lit_length_m[ray] / block.length_m[ray]);
    }
}

void Shafts::scatter(std::span<const ViewRay> rays, std::span<Rgb> radiance, std::span<float> average_visibility,
                     const Progress& progress, Turn turn) const {
    scatter(rays, {}, {Scattered{radiance, average_visibility}}, progress, turn);
}

std::array<bool, shared_sides.size()> Shafts::sides_used(std::uint32_t turn_count) const {
    std::array<bool, shared_sides.size()> used{};
    for (const LightBeams& light : prepared_->lights)
        used[sharing(light.beams.size(), turn_count).side] = true;
    return used;
}

void Shafts::scatter(std::span<const ViewRay> rays, std::span<const std::uint8_t> cells,
                     const std::array<Scattered, shared_sides.size()>& out, const Progress& progress, Turn turn) const {
    require(turn.index < turn.count, "scatter: turn ", turn.index, " of ", turn.count);
    require(cells.empty() || cells.size() == rays.size(), "scatter: ", rays.size(), " rays with ", cells.size(),
            " cells");
    const std::array used = cells.empty() ? std::array{true, false, false} : sides_used(turn.count);
    for (std::size_t side = 0; side < shared_sides.size(); ++side) {
        const auto& [radiance, visibility] = out[side];
        require(!used[side] ||
                    (radiance.size() == rays.size() && (visibility.empty() || visibility.size() == rays.size())),
                "scatter: ", rays.size(), " rays, but room for ", radiance.size(), " results");
        std::ranges::fill(radiance, Rgb(0.0f));
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
            prepared_->scatter_side(rays, cells, order, side, out[side], progress, turn);
}

void Shafts::Prepared::scatter_side(std::span<const ViewRay> rays, std::span<const std::uint8_t> cells,
                                    std::span<const std::uint32_t> order, std::size_t side, const Scattered& out,
                                    const Progress& progress, const Turn& turn) const {
    // Rays of one cell ask for the same strata: a block has one cell, and keeps the order within it.
    const std::uint32_t cell_count = shared_sides[side] * shared_sides[side];
    std::vector<std::uint32_t> by_cell;
    std::vector<std::size_t> first_of_cell{0};
    for (std::uint32_t cell = 0; cell < cell_count && side > 0; ++cell) {
        for (const std::uint32_t ray : order)
            if (cells[ray] * cell_count / 16 == cell)
                by_cell.push_back(ray);
        first_of_cell.push_back(by_cell.size());
    }
    if (side == 0)
        first_of_cell.push_back(order.size());
    const std::span<const std::uint32_t> sorted = side == 0 ? order : std::span<const std::uint32_t>(by_cell);
    constexpr std::size_t rays_per_block = 256; // their pieces and intervals stay in the first-level cache
    for (std::uint32_t cell = 0; cell < cell_count; ++cell) {
        const auto mine = sorted.subspan(first_of_cell[cell], first_of_cell[cell + 1] - first_of_cell[cell]);
        parallel_blocks(mine.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
            thread_local Block block;
            block.wants_visibility = !out.average_visibility.empty();
            gather(rays, mine.subspan(begin, end - begin), block);
            for (const LightBeams& light : lights) {
                const Sharing shared = cells.empty() ? Sharing{} : sharing(light.beams.size(), turn.count);
                if (!block.rays.empty() && shared.side == side)
                    add(light, {cell * shared.count / cell_count * turn.count + turn.index, shared.count * turn.count},
                        block);
            }
            for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
                out.radiance[block.target[ray]] = block.all_radiance[ray];
                if (!out.average_visibility.empty())
                    out.average_visibility[block.target[ray]] = block.visibility[ray];
            }
        });
    }
}

Result run(const Scene& scene, const View& view, std::span<const ViewRay> rays, const Config& config,
           Progress& progress) {
    const Media media(scene, progress);
    const Shafts shafts(scene, media, view, rays, config, progress);
    Result result{.radiance = std::vector<Rgb>(rays.size()),
                  .average_visibility = std::vector<float>(rays.size()),
                  .statistics = shafts.statistics()};
    const StageTimer timer(result.statistics, "light shafts: scatter");
    shafts.scatter(rays, result.radiance, result.average_visibility, progress);
    return result;
}
} // namespace tyndall::light_shafts
