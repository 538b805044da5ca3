// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_shafts.hpp"
#include "core/parallel.hpp"
#include "light_shafts/forward_fog.hpp"
#include "light_shafts/prepared_lights.hpp"
#include "light_shafts/strata_counts.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
static void validate(const Config& config) {
    require_in(config.error_target, 1e-5f, 0.1f, "error_target");
    if (config.resolution != 0)
        require_in(static_cast<float>(config.resolution), 16.0f, 16384.0f, "resolution");
    require_in(config.grid_error_target, 1e-4f, 0.3f, "grid_error_target");
    require_in(static_cast<float>(config.light_samples), 1.0f, 65536.0f, "light_samples");
    require_in(static_cast<float>(config.world_samples), 0.0f, 65536.0f, "world_samples");
    const SeriesPart& part = config.part;
    if (part.first >= part.end || part.end > part.samples || part.pictures == 0)
        throw InvalidInput("light shafts: a part of a series must have some of its samples");
}

static bool is_world(const Scene& scene, const ScatteringLight& light) { return light.index == scene.lights().size(); }

/// Besides those that `left` names.
static LeftLights leave_costly(const Scene& scene, const Media& media, const Config& config, LeftLights left,
                               std::vector<ScatteringLight>& lights) {
    const auto is_lamp = [&](const ScatteringLight& light) {
        return !is_world(scene, light) && scene.lights()[light.index].kind != LightKind::Sun;
    };
    RowsCounts counts;
    for (const ScatteringLight& light : lights) {
        if (is_world(scene, light))
            counts.world_samples += light.samples.size();
        if (is_lamp(light))
            counts.lamps += 1, counts.lamp_samples += light.samples.size();
    }
    const LeftLights costly = find_left(scene, media, config, counts);
    std::erase_if(lights, [&](const ScatteringLight& light) {
        return (costly.lamps && is_lamp(light)) || (costly.world && is_world(scene, light));
    });
    left.lamps |= costly.lamps;
    left.world |= costly.world;
    return left;
}

Shafts::~Shafts() = default;
bool Shafts::is_empty() const { return prepared_->lights.empty(); }
std::span<const std::uint8_t> Shafts::slots() const { return prepared_->slots; }
const Statistics& Shafts::statistics() const { return prepared_->statistics; }

Shafts::Shafts(const Scene& scene, const Media& media, const View& view, std::span<const ViewRay> rays,
               const Config& config, Progress& progress)
    : prepared_(std::make_unique<PreparedLights>(PreparedLights{.media = media, .lights = {}, .statistics = {}})) {
    validate(config);
    prepared_->visibility_light = config.visibility_light;
    Statistics& statistics = prepared_->statistics;
    if (media.is_empty()) {
        statistics.skip("light shafts", "no medium in the scene");
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
    const auto count = [&] { return count_strata(scene, media, view, clipped, config, progress); };
    const StrataCounts counts = config.kept_strata && config.adapts_strata
                                    ? config.kept_strata->counts(config.part, shining_lights(scene), count)
                                    : count();
    std::vector<ScatteringLight> lights = find_scattering_lights(scene, media, config, counts, statistics);
    left_ = leave_costly(scene, media, config, counts.left, lights);
    const bool has_world = std::ranges::any_of(lights, [&](const auto& light) { return is_world(scene, light); });
    if (const auto lack = lack_of_directions(scene, config); lack && has_world && !config.walks_maps)
        statistics.report(described(*lack, scene, config));
    if (lights.empty() && !left_.is_any())
        statistics.skip("light shafts", "no light scatters in a medium");
    if (!lights.empty())
        prepared_->prepare(scene, view, clipped, std::move(lights), config, progress);
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
