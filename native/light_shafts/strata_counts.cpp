// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/strata_counts.hpp"
#include "light_shafts/map_cache.hpp"
#include "light_shafts/prepared_lights.hpp"
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <optional>

namespace tyndall::light_shafts {
static double mean(const Rgb& radiance) {
    const double value = (double{radiance.x} + radiance.y + radiance.z) / 3.0;
    return std::isfinite(value) ? value : 0.0;
}

std::uint32_t strata_for_error(double deviation, double error, std::uint32_t most) {
    constexpr double order = 0.75;
    const double count = std::pow(deviation / error, 1.0 / order);
    if (!(count < most)) // an infinity, too
        return most;
    return std::min(most, std::bit_ceil(static_cast<std::uint32_t>(std::ceil(std::max(count, 1.0)))));
}

/// Lines of a whole light with which the pilot begins: with 4 strata each has half as many.
static constexpr std::uint32_t few_lines = 128;
/// From this error target on finer rows would take longer than what strata cost that the pilot asks for needlessly.
static constexpr float draft_error = 0.03f;

/// Mean over rays of the variance between the strata of one light, each as if it were the whole light.
static double variance_of(const PreparedLights& pilot, const LightBeams& light, Block& block, double& light_sum) {
    const std::size_t ray_count = block.rays.size();
    std::vector<double> sum(ray_count), sum_of_squares(ray_count);
    const auto strata = static_cast<double>(light.stratum_count());
    for (std::size_t stratum = 0; stratum < light.stratum_count(); ++stratum) {
        block.radiance.assign(ray_count, Rgb(0.0f));
        block.lit_length_m.assign(ray_count, 0.0f);
        pilot.add(light, stratum, block);
        pilot.add_inside(light, block, block.radiance, 1.0f / static_cast<float>(light.stratum_count()));
        for (std::size_t ray = 0; ray < ray_count; ++ray) {
            const double value = strata * mean(block.radiance[ray]);
            sum[ray] += value;
            sum_of_squares[ray] += value * value;
        }
    }
    double variance = 0.0;
    for (std::size_t ray = 0; ray < ray_count; ++ray) {
        variance += std::max(0.0, sum_of_squares[ray] - sum[ray] * sum[ray] / strata) / std::max(strata - 1.0, 1.0);
        light_sum += sum[ray] / strata;
    }
    return variance / static_cast<double>(std::max<std::size_t>(ray_count, 1));
}

namespace {
/// What the pilot finds of a light.
struct Piloted {
    std::size_t light; ///< As ScatteringLight::index.
    /// A sun's strata differ by less than rows of few lines do; what edits change is not seen in few texels.
    bool needs_fine_rows;
    std::optional<double> variance = {};         ///< In the last rows; nothing: none of its strata scatters light.
    std::optional<double> coarser_variance = {}; ///< In rows of half as many lines.
    double light_sum = 0.0;                      ///< Over the pilot's rays.
    bool is_settled = false;

    /// Rows shift a shadow's edges by parts of a line, each stratum's its own way: that adds a variance which falls with the
    /// square of the number of lines, or slower among many edges. Where it falls faster, lines were too few to tell.
    [[nodiscard]] double deviation() const {
        constexpr double least_share = 0.25;
        const double added = coarser_variance ? (*coarser_variance - *variance) / 3.0 : 0.0;
        return std::sqrt(std::max(least_share * *variance, *variance - added));
    }
};

/// A few strata of each light along a few rays.
class Pilot {
public:
    Pilot(const Scene& scene, const Media& media, const View& view, std::span<const ViewRay> rays, const Config& config,
          std::vector<ScatteringLight> lights)
        : scene_(scene), media_(media), view_(view), config_(config), lights_(std::move(lights)) {
        config_.method = config.method == Method::Exact ? Method::Exact : Method::Epipolar;
        config_.part = {};      // to tell how much strata differ takes all of its few
        if (!config_.kept_maps) // occluders are gathered once for all rows
            config_.kept_maps = std::make_shared<MapCache>(0);
        constexpr std::size_t pilot_rays = 256;
        const std::size_t step = std::max<std::size_t>(1, rays.size() / pilot_rays);
        for (std::size_t ray = step / 2; ray < rays.size(); ray += step)
            rays_.push_back(rays[ray]);
        for (const ScatteringLight& light : lights_) {
            const Light* const lamp = light.index < scene.lights().size() ? &scene.lights()[light.index] : nullptr;
            found_.push_back(
                {.light = light.index,
                 .needs_fine_rows = lamp && (lamp->kind == LightKind::Sun || !lamp->occluder_edits.empty())});
        }
    }
    [[nodiscard]] std::span<Piloted> found() { return found_; }
    [[nodiscard]] std::size_t ray_count() const { return rays_.size(); }

    /// Those that are meant, in rows of so many lines of a whole light.
    void measure(std::uint32_t lines, const std::function<bool(const Piloted&)>& is_meant, Progress& progress) {
        std::vector<ScatteringLight> lights;
        for (std::size_t index = 0; index < lights_.size(); ++index)
            if (is_meant(found_[index]))
                lights.push_back(lights_[index]); // what its samples refer to stays here
        if (lights.empty())
            return;
        PreparedLights prepared{
            .media = media_, .lights = {}, .step_limits = step_limits_, .grid_loss = grid_loss_, .statistics = {}};
        config_.resolution = lines;
        prepared.prepare(scene_, view_, rays_, std::move(lights), config_, progress);
        step_limits_ = prepared.step_limits, grid_loss_ = prepared.grid_loss; // once, whatever the rows
        Block block;
        std::vector<std::uint32_t> all(rays_.size());
        std::iota(all.begin(), all.end(), 0u);
        prepared.gather(rays_, all, block);
        for (const LightBeams& light : prepared.lights) {
            progress.poll();
            Piloted& of = *std::ranges::find(found_, light.light, &Piloted::light);
            of.coarser_variance = of.variance;
            of.light_sum = 0.0;
            of.variance = variance_of(prepared, light, block, of.light_sum);
        }
    }

private:
    const Scene& scene_;
    const Media& media_;
    const View& view_;
    Config config_;
    std::vector<ScatteringLight> lights_;
    std::vector<ViewRay> rays_;
    std::vector<Piloted> found_;
    StepLimits step_limits_;
    std::optional<GridLoss> grid_loss_;
};
} // namespace

static bool shines(const Light& light) { return light.scatters_in_media && light.strength != Rgb(0.0f); }

std::vector<bool> shining_lights(const Scene& scene) {
    std::vector<bool> shining;
    for (const Light& light : scene.lights())
        shining.push_back(shines(light));
    shining.push_back(scene.world().scatters_in_media());
    return shining;
}

const StrataCounts& KeptStrata::counts(const SeriesPart& part, const std::vector<bool>& shining,
                                       const std::function<StrataCounts()>& count) {
    const bool is_new = part.first == 0 || counted_.size() != shining.size();
    if (is_new)
        counted_.assign(shining.size(), false);
    else if (std::ranges::equal(shining, counted_, std::less_equal()))
        return counts_;
    StrataCounts found = count();
    for (std::size_t light = 0; light < found.of_light.size(); ++light)
        if (counted_[light]) // as pictures before had it
            found.of_light[light] = counts_.of_light[light];
    if (counted_.back())
        found.of_world = counts_.of_world;
    for (std::size_t light = 0; light < shining.size(); ++light)
        counted_[light] = counted_[light] || shining[light];
    counts_ = std::move(found);
    return counts_;
}

StrataCounts count_strata(const Scene& scene, const Media& media, const View& view, std::span<const ViewRay> rays,
                          const Config& config, Progress& progress) {
    constexpr std::uint32_t pilot_strata = 4, pilot_directions = 16;
    constexpr std::uint32_t usual_times = 4; // as many: where these are too many, so is the pilot
    StrataCounts most, few;
    RowsCounts usual;
    for (const Light& light : scene.lights()) {
        most.of_light.push_back(has_size(light) ? config.light_samples : 1);
        few.of_light.push_back(std::min(most.of_light.back(), pilot_strata));
        if (light.kind != LightKind::Sun && shines(light)) {
            usual.lamps += 1;
            usual.lamp_samples += std::min(most.of_light.back(), usual_times * pilot_strata);
        }
    }
    most.of_world = config.world_samples;
    few.of_world = std::min(config.world_samples, pilot_directions);
    if (scene.world().scatters_in_media())
        usual.world_samples = std::min(config.world_samples, usual_times * pilot_directions);
    const bool has_pilot = config.adapts_strata && (most.of_light != few.of_light || most.of_world != few.of_world);
    few.left = most.left = find_left(scene, media, config, usual);
    if (!has_pilot)
        return most;

    few.shares.assign(scene.lights().size(), 0.0f); // as few cells as can be, where something stands in a lamp
    Statistics ignored;                             // the frame's own preparation reports
    Pilot pilot(scene, media, view, rays, config, find_scattering_lights(scene, media, config, few, ignored));
    const std::span<Piloted> lights = pilot.found();
    const auto is_world = [&](const Piloted& light) { return light.light == scene.lights().size(); };
    const auto count_in = [&](auto& counts, const Piloted& light) -> auto& {
        return is_world(light) ? counts.of_world : counts.of_light[light.light];
    };
    double frame_sum = 0.0, error = 0.0;
    /// Never fewer than the pilot had: it may have missed a penumbra.
    const auto count_for = [&](const Piloted& light, double deviation) {
        return std::max(count_in(few, light), strata_for_error(deviation, error, count_in(most, light)));
    };
    const auto settle = [&] {
        frame_sum = 0.0;
        std::size_t with_size = 0;
        for (const Piloted& light : lights) {
            frame_sum += light.light_sum;
            with_size += light.variance && count_in(few, light) > 1;
        }
        const double frame_mean = frame_sum / static_cast<double>(std::max<std::size_t>(pilot.ray_count(), 1));
        error = double{config.error_target} * frame_mean / std::sqrt(std::max(static_cast<double>(with_size), 1.0));
        for (Piloted& light : lights)
            light.is_settled =
                !light.variance || count_for(light, light.deviation()) == count_for(light, std::sqrt(*light.variance));
    };
    const auto all = [](const Piloted&) { return true; };
    if (config.method == Method::Exact) {
        pilot.measure(2 * few_lines, all, progress); // the lines are of edited lights
        settle();
    } else {
        pilot.measure(
            few_lines / 2, [](const Piloted& light) { return !light.needs_fine_rows; }, progress);
        pilot.measure(few_lines, all, progress);
        settle();
        pilot.measure(
            2 * few_lines, [](const Piloted& light) { return light.needs_fine_rows || !light.is_settled; }, progress);
        settle();
        if (config.error_target < draft_error) {
            pilot.measure(
                4 * few_lines, [](const Piloted& light) { return !light.is_settled; }, progress);
            settle();
        }
    }
    StrataCounts counts = few;
    for (const Piloted& light : lights) {
        if (!light.variance)
            continue;
        if (!is_world(light))
            counts.shares[light.light] = frame_sum > 0.0 ? static_cast<float>(light.light_sum / frame_sum) : 1.0f;
        count_in(counts, light) = count_for(light, light.deviation());
    }
    return counts;
}
} // namespace tyndall::light_shafts
