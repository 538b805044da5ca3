// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit.hpp"
#include "core/parallel.hpp"
#include "light_shafts/light_map_fit_view.hpp"
#include "light_shafts/map_cache.hpp"
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace tyndall::light_shafts {
namespace {
void validate(const Scene& scene, std::span<const Strokes> strokes, const LightMap& current,
              const LightMapFitConfig& config) {
    require(config.light < scene.lights().size(), "light map fit: there is no light ", config.light);
    const Light& light = scene.lights()[config.light];
    require(light.kind != LightKind::Area, "Light \"", light.name,
            "\" is an area light, which has no beam to paint: paint the shafts of a sun, a spot or a point light");
    require(
        light.kind != LightKind::Point || light.body != LightBody::Sphere || light.radius_m == 0.0f, "Light \"",
        light.name,
        "\" glows as a sphere, each of its points in one colour: switch its Soft Falloff on, or set its Radius to 0");
    require(std::ranges::any_of(strokes, [](const Strokes& view) { return !view.pixels.empty(); }),
            "nothing is painted: no stroke image has a pixel with an alpha above 0");
    require(16 <= config.resolution && config.resolution <= 4096, "resolution is ", config.resolution,
            ", outside [16, 4096]");
    require_in(config.regularisation, 0.0f, 1e6f, "regularisation");
    require_in(config.shared_texels, 0.0f, 1.0f, "shared_texels");
    const std::size_t texel_count = std::size_t{current.place.resolution} * current.place.resolution;
    require(current.texels.empty() || (current.texels.size() == texel_count && current.place.size_m > 0.0f),
            "the current light map has ", current.texels.size(), " texels, not ", texel_count);
}

/// Rays one after another that go over the same texels: by the angle of the plane that they share with the light, or side by
/// side under a sun. Appends what was where.
Strokes in_coherent_order(const Strokes& strokes, const Light& light, std::vector<std::uint32_t>& pixel_of_ray) {
    const bool is_flat = strokes.view.is_orthographic, is_sun = light.kind == LightKind::Sun;
    const vec3 axis = is_flat  ? strokes.view.direction
                      : is_sun ? light.towards_light
                               : light.position - strokes.view.position;
    const auto [across, up] = orthonormal_basis(glm::length(axis) > 0.0f ? glm::normalize(axis) : vec3(0, 0, 1));
    const vec3 beside = is_sun ? glm::cross(axis, light.towards_light) : vec3(0.0f);
    std::vector<float> place;
    for (const StrokePixel& pixel : strokes.pixels) {
        const vec3 way = is_flat ? pixel.ray.origin - light.position : pixel.ray.direction;
        place.push_back(is_flat && is_sun ? glm::dot(way, beside)
                                          : std::atan2(glm::dot(way, up), glm::dot(way, across)));
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

void require_seen(bool is_seen, const Light& light, const Media& media) {
    const bool is_in_smoke = light.kind != LightKind::Sun && !media.grids().is_empty();
    require(is_seen, "no painted pixel sees air that light \"", light.name, "\" reaches: paint where its shafts are",
            is_in_smoke ? "; of a lamp, volumes with density grids are not fitted, only even air is" : "");
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

void LightMapFit::build_for_sun(std::span<const StrokeView> views, const Media& media, const Light& sun,
                                const LightMap& current, const LightMapFitConfig& config, const Progress& progress) {
    const LightMapAxes axes(sun);
    std::vector<SeenBlock> blocks;
    {
        const StageTimer timer(statistics_, "light map fit: lit intervals");
        for (const StrokeView& view : views)
            std::ranges::move(see_sun(view, axes, progress), std::back_inserter(blocks));
    }
    Focus focus;
    bool is_coloured = false;
    for (const SeenBlock& block : blocks) {
        focus.grow(block.focus);
        is_coloured = is_coloured || !block.is_grey;
    }
    require_seen(!focus.is_empty(), sun, media);
    const bool stays =
        !current.texels.empty() && current.place.resolution == config.resolution && covers(current.place, focus);
    place_ = stays ? current.place : snapped(focus, config.resolution);

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
    matrix_ = std::make_unique<const LightMapMatrix>(config.resolution, is_coloured, std::move(parts), progress,
                                                     config.shared_texels);
}

void LightMapFit::build_for_lamp(std::span<const StrokeView> views, const Media& media, const Light& lamp,
                                 const LightMapFitConfig& config, const Progress& progress) {
    place_ = thrown_place(config.resolution);
    const StageTimer timer(statistics_, "light map fit: matrix");
    std::vector<LightMapMatrix::Part> parts;
    for (const StrokeView& view : views)
        std::ranges::move(lamp_rows(view, media, lamp, config.resolution, progress), std::back_inserter(parts));
    require_seen(!std::ranges::all_of(parts, [](const auto& part) { return part.stretches.empty(); }), lamp, media);
    const bool is_coloured = std::ranges::any_of(parts, [](const auto& part) { return part.channels == 4; });
    if (is_coloured)
        for (LightMapMatrix::Part& part : parts)
            part.split_channels();
    matrix_ = std::make_unique<const LightMapMatrix>(config.resolution, is_coloured, std::move(parts), progress,
                                                     config.shared_texels);
}

LightMapFit::LightMapFit(const Scene& scene, const Media& media, std::span<const Strokes> strokes,
                         const LightMap& current, const LightMapFitConfig& config, Progress& progress) {
    validate(scene, strokes, current, config);
    require(!media.is_empty(), "nothing scatters: no medium in the scene");
    progress.set_message("Light map fit: what the strokes see");
    const Light& light = scene.lights()[config.light];
    std::vector<vec4> desired;
    std::vector<float> weight;
    std::vector<StrokeView> views;
    LightMapFitConfig shared = config;
    if (!shared.shafts.kept_maps) // occluders are gathered once for all views
        shared.shafts.kept_maps = std::make_shared<MapCache>(0);
    for (const Strokes& as_given : strokes) {
        const Strokes sorted = in_coherent_order(as_given, light, pixel_of_ray_);
        views.emplace_back(scene, media, sorted, shared, statistics_, progress);
        for (const StrokePixel& pixel : sorted.pixels) {
            desired.emplace_back(glm::max(pixel.desired, 0.0f), 0.0f);
            weight.push_back(pixel.weight);
        }
    }
    if (light.kind == LightKind::Sun)
        build_for_sun(views, media, light, current, config, progress);
    else
        build_for_lamp(views, media, light, config, progress);
    views.clear();
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
    statistics_.count("light map fit: samples of the map", static_cast<double>(matrix_->sample_count()));
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
