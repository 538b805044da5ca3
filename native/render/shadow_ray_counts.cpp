// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/shadow_ray_counts.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "render/best_ray_counts.hpp"
#include "render/pixel_samples.hpp"
#include "scene/seen_part.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace tyndall::render {
/// Time of a camera ray with all that follows from it, and of a ray to a lamp or sun, in rays to the world: where a square
/// of pixels sees one plane, and among leaves. There a ray to the world, which goes alone, takes as long as all that a
/// camera ray needs, and the rays to a sun still go side by side. Between these, by the square of the share of a pixel's
/// square that lies in the pixel's plane.
static constexpr double camera_ray_cost_in_plane = 8.0, camera_ray_cost_in_leaves = 2.5;
static constexpr double lamp_ray_cost_in_plane = 0.9, lamp_ray_cost_in_leaves = 0.25;
/// Of a ray to an image of the world: it is drawn, and weighed by the image's density.
static constexpr double image_ray_cost = 1.2;
/// Of a ray to one of many lights: it is found in their tree.
static constexpr double many_ray_cost = 2.7;
/// Of the noise in a fixed time, that twice the rays of a light save where no fog takes its time, too, of few samples; of
/// more, in proportion less.
static constexpr double least_saving_on_surfaces = 0.15;

namespace {
/// Pixels of a square of the pilot: neighbours, which trace faster together.
constexpr std::uint32_t square_px = 4;
constexpr std::size_t pixels_per_square = std::size_t{square_px} * square_px;
constexpr std::uint32_t most_squares_along = 8;
constexpr std::uint32_t camera_rays = 4, shadow_rays = 2; ///< Of a pixel; of a camera ray and light.

/// What the pilot finds of a pixel.
struct OfPixel {
    /// Of each camera ray with each of its shadow rays: of surfaces and of the world behind them, without the fog.
    std::array<std::array<double, shadow_rays>, camera_rays> brightness{};
    std::array<double, camera_rays> opacity{}; ///< Of the fog in front of these.
    std::vector<double> light_variances;
    std::vector<double> camera_variances; ///< Of a camera ray, by each light alone.
    double neighbour_count = 1.0;         ///< Pixels of its square that lie in its plane, itself included.
    double fog = 0.0;                     ///< Brightness of opaque fog here.
    light_shafts::ViewRay part{};         ///< Of its last ray.
    bool is_beside = false;               ///< Of what the camera shows: it tells nothing.

    [[nodiscard]] double mean() const {
        double sum = 0.0;
        for (std::size_t ray = 0; ray < camera_rays; ++ray)
            sum += 0.5 * (brightness[ray][0] + brightness[ray][1]) + fog * opacity[ray];
        return sum / camera_rays;
    }
    /// Variance of all but the shadow rays' choice.
    [[nodiscard]] double camera_variance() const {
        double sum = 0.0;
        // Of a product of differences, independent but for the camera rays, the lights' own noise averages out.
        for (std::size_t ray = 0; ray < camera_rays; ray += 2) {
            const double of_fog = fog * (opacity[ray] - opacity[ray + 1]);
            sum += (brightness[ray][0] - brightness[ray + 1][0] + of_fog) *
                   (brightness[ray][1] - brightness[ray + 1][1] + of_fog);
        }
        return std::max(0.0, sum / camera_rays);
    }
};

class Pilot {
public:
    Pilot(const Scene& scene, const Media& media, const DirectLight& light, const IndirectLight* bounce,
          const Camera& camera, const FilterSampler& filter, const ShadowRayConfig& config)
        : scene_(scene), media_(media), light_(light), bounce_(bounce), camera_(camera), filter_(filter),
          voxel_detail_px_(config.voxel_detail_px), seed_(config.seed), width_px_(std::min(square_px, camera.width_px)),
          height_px_(std::min(square_px, camera.height_px)), columns_(squares_along(camera.width_px)),
          rows_(squares_along(camera.height_px)) {}

    [[nodiscard]] std::size_t square_count() const { return std::size_t{columns_} * rows_; }

    /// One view ray per square, up to its first surface.
    [[nodiscard]] std::vector<light_shafts::ViewRay> rays() const {
        std::vector<light_shafts::ViewRay> rays;
        for (std::uint32_t index = 0; index < square_count(); ++index) {
            const Ray ray = pixel_ray(camera_, first_x(index), first_y(index));
            if (!ray.exists()) {
                rays.push_back({ray.origin, ray.direction, 0.0f, 0.0f});
                continue;
            }
            const std::uint32_t pixel = pixel_seed(camera_, seed_, first_x(index), first_y(index));
            const Hit hit = scene_.closest_hit(ray, camera_mask, ray_detail(camera_, ray, voxel_detail_px_, pixel, 0));
            rays.push_back({ray.origin, ray.direction, ray.near_m, seen_part(media_, ray, hit).far_m});
        }
        return rays;
    }

    [[nodiscard]] std::vector<OfPixel> of_square(std::uint32_t index) const {
        const std::uint32_t x0 = first_x(index), y0 = first_y(index);
        std::vector<Lit> lights(light_.light_count() + (bounce_ != nullptr ? 1 : 0));
        Seen seen;
        std::array<WorldLit, pixels_per_square> surfaces;
        for (std::uint32_t ray = 0; ray < camera_rays; ++ray)
            shade(x0, y0, ray, lights, seen, surfaces);
        std::vector<OfPixel> pixels;
        for (std::size_t pixel = 0; pixel < std::size_t{width_px_} * height_px_; ++pixel) {
            pixels.push_back(of_pixel(pixel, lights, seen));
            const auto shares = [&](const WorldLit& other) {
                return other.albedo != Rgb(0.0f) && is_coplanar(surfaces[pixel], other);
            };
            const auto count = std::count_if(surfaces.begin(), surfaces.end(), shares);
            pixels.back().neighbour_count = std::max(1.0, static_cast<double>(count));
        }
        return pixels;
    }

private:
    /// By one light: brightness of each pixel in each camera ray with each shadow ray.
    struct Lit {
        std::array<std::array<std::array<float, shadow_rays>, camera_rays>, pixels_per_square> of_pixel{};
    };

    /// Without any light: what glows, and the fog's opacity in front of it, of each pixel in each camera ray.
    struct Seen {
        std::array<std::array<float, camera_rays>, pixels_per_square> emitted{}, opacity{};
        std::array<light_shafts::ViewRay, pixels_per_square> parts{};
        std::array<bool, pixels_per_square> is_beside{};
    };

    [[nodiscard]] static std::uint32_t squares_along(std::uint32_t frame_px) {
        return std::clamp(frame_px / square_px, 1u, most_squares_along);
    }
    /// First pixel of square `index` of `count` in a frame with room for their beginnings.
    [[nodiscard]] static std::uint32_t place(std::uint32_t index, std::uint32_t count, std::uint32_t room_px) {
        return static_cast<std::uint32_t>(std::uint64_t{room_px} * (2 * index + 1) / (2 * count));
    }

    [[nodiscard]] std::uint32_t first_x(std::uint32_t square) const {
        return place(square % columns_, columns_, camera_.width_px - width_px_);
    }
    [[nodiscard]] std::uint32_t first_y(std::uint32_t square) const {
        return place(square / columns_, rows_, camera_.height_px - height_px_);
    }

    /// One camera ray of each pixel of a square, up to the first surface: `surfaces` has the last ray's.
    void shade(std::uint32_t x0, std::uint32_t y0, std::uint32_t camera_ray, std::span<Lit> lights, Seen& seen,
               std::span<WorldLit> surfaces) const {
        std::array<Ray, pixels_per_square> rays;
        std::array<RayDetail, pixels_per_square> details;
        std::array<Hit, pixels_per_square> hits;
        std::array<SurfacePoint, pixels_per_square> points;
        std::array<Rgb, pixels_per_square> reflected, passed;
        std::array<std::vector<Lobe>, pixels_per_square> lobes;
        DirectLight::PointLobes lobes_of_points;
        std::array<std::size_t, pixels_per_square> pixels;
        std::array<std::uint32_t, pixels_per_square> seeds;
        const std::size_t pixel_count = std::size_t{width_px_} * height_px_;
        for (std::uint32_t pixel = 0; pixel < pixel_count; ++pixel) {
            const std::uint32_t x = x0 + pixel % width_px_, y = y0 + pixel / width_px_;
            seeds[pixel] = pixel_seed(camera_, seed_, x, y);
            rays[pixel] = pixel_ray(camera_, x, y, filter_.offset_px(pixel_pair(seeds[pixel], camera_ray, 0)));
            details[pixel] = ray_detail(camera_, rays[pixel], voxel_detail_px_, seeds[pixel], camera_ray);
        }
        scene_.closest_hits(std::span(rays).first(pixel_count), hits, camera_mask,
                            std::span(details).first(voxel_detail_px_ > 0.0f ? pixel_count : 0));
        std::size_t count = 0;
        std::vector<Lobe> bent, below;
        for (std::uint32_t pixel = 0; pixel < pixel_count; ++pixel) {
            if (!rays[pixel].exists()) {
                seen.is_beside[pixel] = true;
                continue;
            }
            const Hit& hit = hits[pixel];
            const Ray inside = seen_part(media_, rays[pixel], hit);
            const Rgb passing = media_.is_empty() ? Rgb(1.0f) : media_.transmittance(inside);
            seen.opacity[pixel][camera_ray] = 1.0f - average(passing);
            seen.parts[pixel] = {inside.origin, inside.direction, inside.near_m, inside.far_m};
            if (!hit.is_hit()) {
                seen.emitted[pixel][camera_ray] = average(passing * scene_.world().seen_radiance(inside.direction));
                continue;
            }
            points[count] = surface_point(scene_, rays[pixel], hit, seeds[pixel]);
            SurfaceClosures closures =
                scene_.closures({.ray = rays[pixel], .random = ProgramRandom{seeds[pixel], camera_ray}},
                                points[count].shading, hit, &lobes[count]);
            bent.clear(), below.clear();
            take_apart(lobes[count], bent, below); // rays are not followed here
            for (const Lobe& lobe : below)         // as if it came in where it is seen
                closures.diffuse_albedo += lobe.weight;
            points[count].lambert_share = average(closures.diffuse_albedo);
            lobes_of_points[count] = {.lobes = lobes[count],
                                      .normal = points[count].shading.shading_normal,
                                      .outgoing = -rays[pixel].direction};
            passed[count] = passing;
            seen.emitted[pixel][camera_ray] = average(passing * closures.emission);
            reflected[count] = passing * closures.diffuse_albedo * std::numbers::inv_pi_v<float>;
            surfaces[pixel] = {points[count].shading.position, points[count].shading.shading_normal, reflected[count],
                               Rgb(0.0f)};
            pixels[count++] = pixel;
        }
        std::array<DirectLight::Irradiance, pixels_per_square> irradiance;
        for (std::size_t light = 0; light < lights.size(); ++light)
            for (std::uint32_t ray = 0; ray < shadow_rays; ++ray) {
                for (std::size_t point = 0; point < count; ++point)
                    points[point].pixel_seed = hash(seeds[pixels[point]], 1 + camera_ray * shadow_rays + ray);
                irradiance.fill({});
                ask(light, std::span(points).first(count), lobes_of_points, irradiance);
                for (std::size_t point = 0; point < count; ++point)
                    lights[light].of_pixel[pixels[point]][camera_ray][ray] = average(
                        reflected[point] * irradiance[point].sum() + passed[point] * irradiance[point].reflected);
            }
    }

    /// One shadow ray of each point to a light; past the last, one that gathers.
    void ask(std::size_t light, std::span<const SurfacePoint> points, const DirectLight::PointLobes& lobes,
             std::span<DirectLight::Irradiance> irradiance) const {
        if (light < light_.light_count())
            return light_.add_one(light, points, {0, 1}, irradiance, &lobes);
        std::array<IndirectLight::Gathered, pixels_per_square> gathered{};
        bounce_->gather(points, 0, 0, 1, &lobes, std::span(gathered).first(points.size()));
        for (std::size_t point = 0; point < points.size(); ++point) {
            irradiance[point].from_lights = gathered[point].irradiance;
            irradiance[point].reflected = gathered[point].reflected;
        }
    }

    static OfPixel of_pixel(std::size_t pixel, std::span<const Lit> lights, const Seen& seen) {
        OfPixel found{.light_variances = std::vector<double>(lights.size()),
                      .camera_variances = std::vector<double>(lights.size()),
                      .part = seen.parts[pixel],
                      .is_beside = seen.is_beside[pixel]};
        for (std::size_t light = 0; light < lights.size(); ++light) {
            const auto& of_light = lights[light].of_pixel[pixel];
            double sum = 0.0;
            for (std::size_t ray = 0; ray < camera_rays; ray += 2)
                sum += double{of_light[ray][0] - of_light[ray + 1][0]} * (of_light[ray][1] - of_light[ray + 1][1]);
            found.camera_variances[light] = std::max(0.0, sum / camera_rays);
        }
        for (std::uint32_t ray = 0; ray < camera_rays; ++ray) {
            found.opacity[ray] = seen.opacity[pixel][ray];
            found.brightness[ray].fill(seen.emitted[pixel][ray]);
            for (std::size_t light = 0; light < lights.size(); ++light) {
                const auto [a, b] = lights[light].of_pixel[pixel][ray];
                found.brightness[ray][0] += a;
                found.brightness[ray][1] += b;
                const double difference = double{a} - b;
                found.light_variances[light] += 0.5 * difference * difference / camera_rays;
            }
        }
        return found;
    }

    const Scene& scene_;
    const Media& media_;
    const DirectLight& light_;
    const IndirectLight* bounce_;
    const Camera& camera_;
    const FilterSampler& filter_;
    float voxel_detail_px_;
    std::uint32_t seed_, width_px_, height_px_; ///< Of a square.
    std::uint32_t columns_, rows_;              ///< Of squares.
};

/// Brightness of opaque fog in each square of the pilot, if fog were as bright all along its ray as it is in the mean: with
/// one stratum per light, which a few rays ask for by EXACT in less time than rows take to be laid out.
std::vector<double> fog_brightness(const Scene& scene, const Media& media, const Camera& camera, const Pilot& pilot,
                                   light_shafts::Config config, Progress& progress) {
    std::vector<double> brightness(pilot.square_count());
    if (media.is_empty())
        return brightness;
    config.method = light_shafts::Method::Exact;
    config.light_samples = 1;
    config.world_samples = std::min(config.world_samples, 1u);
    config.adapts_strata = false;
    const std::vector<light_shafts::ViewRay> rays = pilot.rays();
    // Edits change little of how bright fog is as a whole, and would cost maps of their own.
    std::vector<Light> lights(scene.lights().begin(), scene.lights().end());
    for (Light& light : lights)
        light.occluder_edits.clear();
    const Scene unedited(scene, std::move(lights), scene.world());
    const light_shafts::Shafts shafts(unedited, media, light_shafts::view_of(camera), rays, config, progress);
    if (shafts.is_empty())
        return brightness;
    std::vector<Rgb> radiance(rays.size());
    shafts.scatter(rays, radiance, {}, progress);
    const std::vector<light_shafts::Air> air = shafts.find_air(rays, progress);
    for (std::size_t square = 0; square < rays.size(); ++square)
        if (air[square].opacity > 0.0f && std::isfinite(average(radiance[square])))
            brightness[square] = average(radiance[square]) / air[square].opacity;
    return brightness;
}

RayCosts costs_where(double plane_share, const DirectLight& light, bool has_bounce, bool has_fog,
                     std::uint32_t pixel_samples) {
    const double weight = plane_share * plane_share;
    const double of_lamp = std::lerp(lamp_ray_cost_in_leaves, lamp_ray_cost_in_plane, weight);
    RayCosts costs{.of_camera = std::lerp(camera_ray_cost_in_leaves, camera_ray_cost_in_plane, weight),
                   .of_light = std::vector<double>(light.light_count(), of_lamp)};
    for (std::size_t index = 0; index < light.light_count(); ++index)
        if (light.is_many(index))
            costs.of_light[index] = many_ray_cost;
    if (light.has_world())
        costs.of_light.back() = light.has_even_world() ? 1.0 : image_ray_cost;
    const double least_saving = least_saving_on_surfaces * std::min(1.0, 1.0 * few_samples / pixel_samples);
    costs.least_savings.assign(light.light_count(), has_fog ? 0.0 : least_saving);
    if (has_bounce) { // its own ray finds the nearest surface; what is met has its shadow rays
        costs.of_light.push_back(1.5 + std::accumulate(costs.of_light.begin(), costs.of_light.end(), 0.0));
        costs.least_savings.push_back(0.0);
    }
    return costs;
}
} // namespace

ShadowRayCounts count_shadow_rays(const Scene& scene, const Media& media, const DirectLight& light,
                                  const IndirectLight* bounce, const Camera& camera, const FilterSampler& filter,
                                  const ShadowRayConfig& config, const light_shafts::Config& shafts,
                                  Progress& progress) {
    const std::size_t light_count = light.light_count();
    bool has_choice = bounce != nullptr || config.has_fog_glow || (config.longest_turn > 1 && light_count > 1);
    for (std::size_t index = 0; index < light_count; ++index)
        has_choice = has_choice || light.has_strata(index);
    if (!has_choice)
        return {.of_light = std::vector<std::uint32_t>(light_count, 1),
                .turn_of_light = std::vector<std::uint32_t>(light_count, 1)};
    const Pilot pilot(scene, media, light, bounce, camera, filter, config);
    std::vector<std::vector<OfPixel>> squares(pilot.square_count());
    parallel_for(
        squares.size(), progress,
        [&](std::size_t index) { squares[index] = pilot.of_square(static_cast<std::uint32_t>(index)); }, 1);
    const std::vector<double> fog = fog_brightness(scene, media, camera, pilot, shafts, progress);
    std::vector<OfPixel> pixels;
    for (std::size_t square = 0; square < squares.size(); ++square)
        for (OfPixel& pixel : squares[square]) {
            pixel.fog = fog[square];
            pixels.push_back(std::move(pixel));
        }
    std::erase_if(pixels, [](const OfPixel& pixel) { return pixel.is_beside || !std::isfinite(pixel.mean()); });
    double frame_mean = 0.0, plane_share = 0.0;
    for (const OfPixel& pixel : pixels) {
        frame_mean += pixel.mean() / static_cast<double>(pixels.size());
        plane_share += pixel.neighbour_count / static_cast<double>(pixels_per_square * pixels.size());
    }
    const RayCosts costs = costs_where(plane_share, light, bounce != nullptr, !media.is_empty(), config.pixel_samples);
    const auto scale_of = [&](const OfPixel& pixel) { return pixel.mean() + darkest_share * frame_mean; };
    const auto dark =
        std::ranges::stable_partition(pixels, [&](const OfPixel& pixel) { return scale_of(pixel) > 0.0; });
    PilotSamples samples{.pixels = {}, .longest_turn = config.longest_turn};
    for (const OfPixel& pixel : dark)
        samples.pixels.push_back({pixel.part});
    pixels.erase(dark.begin(), dark.end());
    std::vector<PixelVariances> variances;
    for (OfPixel& pixel : pixels) {
        const double scale = scale_of(pixel);
        for (std::vector<double>* of_light : {&pixel.light_variances, &pixel.camera_variances})
            for (double& variance : *of_light)
                variance /= scale * scale;
        variances.push_back({pixel.camera_variance() / (scale * scale), std::move(pixel.light_variances),
                             std::move(pixel.camera_variances)});
    }
    ShadowRayCounts counts{.of_light = best_ray_counts(variances, costs), .turn_of_light = {}};
    const std::size_t world = light_count - 1; // where there is one
    counts.is_world_shared = config.may_share_world && light.has_even_world() && counts.of_light[world] > 1;
    if (counts.is_world_shared) {
        for (std::size_t pixel = 0; pixel < pixels.size(); ++pixel)
            variances[pixel].of_light[world] /= pixels[pixel].neighbour_count;
        counts.of_light = best_ray_counts(variances, costs);
    }
    std::vector<double> rays_of_sample(counts.of_light.begin(), counts.of_light.end());
    if (bounce != nullptr) {
        counts.of_bounce = counts.of_light.back();
        counts.of_light.pop_back();
    }
    counts.turn_of_light = best_turns(variances, costs, counts.of_light, config.longest_turn);
    if (counts.is_world_shared) // neighbours look for what each pixel found
        counts.turn_of_light[world] = 1;
    for (std::size_t index = 0; index < light_count; ++index)
        rays_of_sample[index] /= counts.turn_of_light[index];
    samples.cost =
        std::inner_product(rays_of_sample.begin(), rays_of_sample.end(), costs.of_light.begin(), costs.of_camera);
    for (std::size_t pixel = 0; pixel < pixels.size(); ++pixel) {
        double variance = variances[pixel].of_camera;
        for (std::size_t index = 0; index < rays_of_sample.size(); ++index)
            variance += variances[pixel].of_light[index] / rays_of_sample[index];
        const double scale = scale_of(pixels[pixel]);
        samples.pixels.push_back({pixels[pixel].part, pixels[pixel].mean(), variance * scale * scale});
    }
    counts.pilot = std::move(samples);
    return counts;
}
} // namespace tyndall::render
