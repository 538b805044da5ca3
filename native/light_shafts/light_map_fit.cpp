// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit.hpp"
#include "core/parallel.hpp"
#include "light_shafts/light_map_fit_rows.hpp"
#include "light_shafts/prepared_lights.hpp"
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace tyndall::light_shafts {
namespace {
constexpr std::size_t rays_per_block = 256;

/// Consecutive rays of one view, with what they see of the light.
struct SeenBlock {
    std::vector<ViewRay> rays; ///< Clipped to the media.
    PieceRows pieces;
    LitRows lit;
    Focus focus;
    bool is_grey = true;

    [[nodiscard]] SeenRay at(std::size_t ray) const {
        return {rays[ray],
                std::span(pieces.pieces).subspan(pieces.first[ray], pieces.first[ray + 1] - pieces.first[ray]),
                std::span(lit.intervals).subspan(lit.first[ray], lit.first[ray + 1] - lit.first[ray])};
    }
};

void validate(const Scene& scene, std::span<const Strokes> strokes, const LightMap& current,
              const LightMapFitConfig& config) {
    require(config.light < scene.lights().size(), "light map fit: there is no light ", config.light);
    const Light& light = scene.lights()[config.light];
    require(light.kind == LightKind::Sun, "Light \"", light.name, "\" is no sun: a light map is fitted to suns only");
    require(std::ranges::any_of(strokes, [](const Strokes& view) { return !view.pixels.empty(); }),
            "nothing is painted: no stroke image has a pixel with an alpha above 0");
    require(16 <= config.resolution && config.resolution <= 4096, "resolution is ", config.resolution,
            ", outside [16, 4096]");
    require_in(config.regularisation, 0.0f, 1e6f, "regularisation");
    const std::size_t texel_count = std::size_t{current.place.resolution} * current.place.resolution;
    require(current.texels.empty() || (current.texels.size() == texel_count && current.place.size_m > 0.0f),
            "the current light map has ", current.texels.size(), " texels, not ", texel_count);
}

/// Rays one after another that go over the same texels: by their angle there, or side by side. Appends what was where.
Strokes in_coherent_order(const Strokes& strokes, const LightMapAxes& axes, std::vector<std::uint32_t>& pixel_of_ray) {
    std::vector<float> place;
    for (const StrokePixel& pixel : strokes.pixels) {
        const vec2 start = axes.metres(pixel.ray.origin), way = axes.along(pixel.ray.direction);
        place.push_back(strokes.view.is_orthographic ? start.x * way.y - start.y * way.x : std::atan2(way.y, way.x));
    }
    std::vector<std::uint32_t> order(place.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(
        order, [&](std::uint32_t a, std::uint32_t b) { return place[a] != place[b] ? place[a] < place[b] : a < b; });
    Strokes sorted{.view = strokes.view, .pixels = {}};
    const auto first = static_cast<std::uint32_t>(pixel_of_ray.size());
    for (const std::uint32_t pixel : order) {
        sorted.pixels.push_back(strokes.pixels[pixel]);
        pixel_of_ray.push_back(first + pixel);
    }
    return sorted;
}

/// The light itself, white and without a size: what a map is multiplied with comes later.
ScatteringLight white_sun(const Scene& scene, const Media& media, const LightMapFitConfig& config) {
    const std::string& name = scene.lights()[config.light].name;
    StrataCounts counts{.of_light = std::vector<std::uint32_t>(scene.lights().size(), 1u)};
    Statistics why;
    for (ScatteringLight& light : find_scattering_lights(scene, media, config.shafts, counts, why)) {
        if (light.index != config.light)
            continue;
        light.samples.front().strength = Rgb(1.0f);
        return std::move(light);
    }
    for (const Statistics::Skipped& skipped : why.skipped)
        if (skipped.what == "light shafts of " + name)
            refuse("Light \"", name, "\" makes no shafts: ", skipped.reason);
    refuse("Light \"", name, "\" makes no shafts");
}

/// What the strokes of one camera see, block by block.
std::vector<SeenBlock> see(const Scene& scene, const Media& media, const Strokes& strokes,
                           const LightMapFitConfig& config, Statistics& statistics, Progress& progress) {
    std::vector<SeenBlock> blocks((strokes.pixels.size() + rays_per_block - 1) / rays_per_block);
    std::vector<ViewRay> in_media;
    std::vector<std::vector<MediumSegment>> segments(strokes.pixels.size());
    parallel_for(
        blocks.size(), progress,
        [&](std::size_t block) {
            const std::size_t end = std::min(strokes.pixels.size(), (block + 1) * rays_per_block);
            for (std::size_t pixel = block * rays_per_block; pixel < end; ++pixel) {
                const ViewRay clipped = clip_to_media(media, strokes.pixels[pixel].ray, segments[pixel]).clipped;
                blocks[block].rays.push_back(clipped);
                if (!(clipped.near_m < clipped.far_m))
                    segments[pixel].clear();
            }
        },
        1);
    for (const SeenBlock& block : blocks)
        std::ranges::copy_if(block.rays, std::back_inserter(in_media),
                             [](const ViewRay& ray) { return ray.near_m < ray.far_m; });
    PreparedLights prepared{.media = media, .lights = {}, .statistics = {}};
    if (!in_media.empty()) {
        const StageTimer timer(statistics, "light map fit: visibility");
        prepared.prepare(scene, strokes.view, in_media, {white_sun(scene, media, config)}, config.shafts, progress);
    }
    const Beam* const beam = prepared.lights.empty() ? nullptr : &prepared.lights.front().beams.front();
    const LightMapAxes axes(scene.lights()[config.light]);
    const StageTimer timer(statistics, "light map fit: lit intervals");
    parallel_for(
        blocks.size(), progress,
        [&](std::size_t index) {
            SeenBlock& block = blocks[index];
            std::vector<ViewRay> asked;
            for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
                const auto& of_ray = segments[index * rays_per_block + ray];
                if (beam != nullptr)
                    beam->directional->append_pieces(block.rays[ray], of_ray, block.pieces.pieces);
                block.pieces.end_ray();
                if (!of_ray.empty() && beam != nullptr)
                    asked.push_back(block.rays[ray]);
            }
            LitRows lit;
            if (!asked.empty())
                beam->visibility->lit_intervals(asked, lit);
            for (std::size_t ray = 0, answer = 0; ray < block.rays.size(); ++ray) {
                if (!segments[index * rays_per_block + ray].empty() && beam != nullptr) {
                    block.lit.intervals.insert(block.lit.intervals.end(), lit.intervals.begin() + lit.first[answer],
                                               lit.intervals.begin() + lit.first[answer + 1]);
                    ++answer;
                }
                block.lit.end_ray();
                grow_focus(block.at(ray), axes, block.focus);
                block.is_grey = block.is_grey && is_grey(block.at(ray));
            }
        },
        1);
    return blocks;
}
MapTexels padded(const std::vector<Rgb>& texels, std::uint32_t resolution) {
    const std::uint32_t pitch = LightMapMatrix::pitch_of(resolution);
    MapTexels result(std::size_t{resolution} * pitch, vec4(0.0f));
    for (std::size_t row = 0; row < resolution; ++row)
        for (std::size_t column = 0; column < resolution; ++column)
            result[row * pitch + column] = vec4(glm::max(texels[row * resolution + column], 0.0f), 0.0f);
    return result;
}
} // namespace

LightMapFit::~LightMapFit() = default;

LightMapFit::LightMapFit(const Scene& scene, const Media& media, std::span<const Strokes> strokes,
                         const LightMap& current, const LightMapFitConfig& config, Progress& progress) {
    validate(scene, strokes, current, config);
    require(!media.is_empty(), "nothing scatters: no medium in the scene");
    progress.set_message("Light map fit: what the strokes see");
    std::vector<SeenBlock> blocks;
    std::vector<vec4> desired;
    std::vector<float> weight;
    const Light& sun = scene.lights()[config.light];
    const LightMapAxes axes(sun);
    for (const Strokes& as_given : strokes) {
        const Strokes view = in_coherent_order(as_given, axes, pixel_of_ray_);
        std::ranges::move(see(scene, media, view, config, statistics_, progress), std::back_inserter(blocks));
        for (const StrokePixel& pixel : view.pixels) {
            desired.emplace_back(glm::max(pixel.desired, 0.0f), 0.0f);
            weight.push_back(pixel.weight);
        }
    }
    Focus focus;
    bool is_coloured = false;
    for (const SeenBlock& block : blocks) {
        focus.grow(block.focus);
        is_coloured = is_coloured || !block.is_grey;
    }
    require(!focus.is_empty(), "no painted pixel sees air that light \"", sun.name,
            "\" reaches: paint where its shafts are");
    const bool stays =
        !current.texels.empty() && current.place.resolution == config.resolution && covers(current.place, focus);
    place_ = stays ? current.place : snapped(focus, config.resolution);

    progress.set_message("Light map fit: matrix");
    {
        const StageTimer timer(statistics_, "light map fit: matrix");
        std::vector<LightMapMatrix::Part> parts(blocks.size());
        parallel_for(
            blocks.size(), progress,
            [&](std::size_t block) {
                RowMaker maker(axes, place_, is_coloured);
                for (std::size_t ray = 0; ray < blocks[block].rays.size(); ++ray)
                    maker.add_row(blocks[block].at(ray), parts[block]);
                blocks[block] = {};
            },
            1);
        matrix_ = std::make_unique<const LightMapMatrix>(config.resolution, is_coloured, std::move(parts), progress);
    }
    const StageTimer timer(statistics_, "light map fit: first gradient");
    MapTexels prior = padded(resampled(current, place_), config.resolution);
    std::vector<vec4> target(desired.size());
    std::ranges::transform(desired, matrix_->white(), target.begin(), std::multiplies<>());
    MapTexels start = prior;
    solver_ = std::make_unique<LightMapSolver>(*matrix_, target, weight, std::move(start), std::move(prior),
                                               config.regularisation);
    statistics_.count("light map fit: stroke pixels", static_cast<double>(desired.size()));
    statistics_.count("light map fit: seen texels", static_cast<double>(solver_->seen_texel_count()));
    statistics_.count("light map fit: weights", static_cast<double>(matrix_->weight_count()));
    statistics_.count("light map fit: matrix, bytes", static_cast<double>(matrix_->byte_count()));
}

bool LightMapFit::iterate(std::uint32_t step_count, Progress& progress) {
    const StageTimer timer(statistics_, "light map fit: steps");
    for (std::uint32_t step = 0; step < step_count; ++step) {
        progress.poll();
        progress.set_message("Light map fit: step " + std::to_string(step + 1) + " of " + std::to_string(step_count));
        if (!solver_->step())
            return false;
        progress.advance_to(static_cast<float>(step + 1) / static_cast<float>(step_count));
    }
    return true;
}

LightMap LightMapFit::map() const {
    LightMap map{.place = place_, .texels = {}};
    for (std::uint32_t row = 0; row < place_.resolution; ++row)
        for (std::uint32_t column = 0; column < place_.resolution; ++column)
            map.texels.emplace_back(solver_->texels()[std::size_t{row} * matrix_->pitch() + column]);
    return map;
}
} // namespace tyndall::light_shafts
