// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/asked_rays.hpp"
#include <algorithm>
#include <array>

namespace tyndall::render {
using transfer_functions::WeightedFunction;

namespace {
/// Rays with what they meet, before their light is asked for.
struct Asked {
    std::vector<vec2> places_px;
    std::vector<SeenSurface> surfaces;
    WaitingParts parts;

    Asked(const ViewPath& path, const RayParameters& parameters, const Camera& camera, std::span<const vec2> places,
          const Progress& progress)
        : places_px(places.begin(), places.end()) {
        constexpr std::size_t size = DirectLight::most_points;
        for (std::size_t begin = 0; begin < places.size(); begin += size) {
            progress.poll();
            const std::size_t count = std::min(size, places.size() - begin);
            std::array<Ray, size> rays;
            std::array<PathSample, size> samples;
            std::array<std::vector<MediumPart>, size> parts_of_ray;
            const std::array<std::uint32_t, size> seeds{}; // of the light on surfaces, which nobody asks for
            for (std::size_t i = 0; i < count; ++i)
                rays[i] = camera.ray(places[begin + i].x, places[begin + i].y);
            path.walk(std::span(rays).first(count), std::span(seeds).first(count), 0, {}, samples, parts_of_ray,
                      nullptr);
            for (std::size_t i = 0; i < count; ++i) {
                surfaces.push_back(parameters.seen(samples[i]));
                for (const MediumPart& part : parts_of_ray[i]) {
                    parts.rays.push_back({rays[i].origin, rays[i].direction, part.near_m, part.far_m});
                    parts.weights.push_back(part.weight);
                }
                parts.first.push_back(static_cast<std::uint32_t>(parts.rays.size()));
            }
        }
    }

    [[nodiscard]] std::vector<SeenShafts> find_shafts(const light_shafts::Shafts& shafts, bool asks_for_moments,
                                                      const Progress& progress) const {
        std::vector<Rgb> radiance(parts.rays.size());
        std::vector<float> visibility(parts.rays.size());
        shafts.scatter(parts.rays, radiance, visibility, progress);
        std::vector<light_shafts::LitMoments> moments(parts.rays.size());
        if (asks_for_moments)
            moments = shafts.find_lit_moments(parts.rays, progress);
        std::vector<SeenShafts> found;
        for (std::size_t ray = 0; ray < places_px.size(); ++ray) {
            const std::size_t first = parts.first[ray], count = parts.first[ray + 1] - first;
            found.push_back(
                sum_of_parts(std::span(parts.weights).subspan(first, count), std::span(radiance).subspan(first, count),
                             std::span(visibility).subspan(first, count), std::span(moments).subspan(first, count)));
        }
        return found;
    }

    /// Per ray and function.
    [[nodiscard]] std::vector<std::vector<vec2>> find(const light_shafts::Shafts& shafts,
                                                      const RayParameters& parameters, const Progress& progress) const {
        const std::vector<SeenShafts> seen =
            find_shafts(shafts, parameters.asks_for(transfer_functions::Axis::MeanLitPosition), progress);
        std::vector<std::vector<vec2>> found(places_px.size());
        for (std::size_t ray = 0; ray < places_px.size(); ++ray)
            for (std::size_t function = 0; function < parameters.function_count(); ++function)
                found[ray].push_back(parameters.at(function, places_px[ray], surfaces[ray], seen[ray]));
        return found;
    }
};
} // namespace

static void fit_visibility(const Asked& grid, const light_shafts::Shafts& shafts, RayParameters& parameters,
                           const Progress& progress) {
    std::vector<float> visibility;
    for (const SeenShafts& seen : grid.find_shafts(shafts, false, progress))
        visibility.push_back(seen.visibility);
    parameters.fit_visibility(std::move(visibility));
}

void fit_visibility(const ViewPath& path, const light_shafts::Shafts& shafts, const Camera& camera,
                    RayParameters& parameters, const Progress& progress) {
    if (parameters.fits_visibility())
        fit_visibility(Asked(path, parameters, camera, grid_places_px(camera), progress), shafts, parameters, progress);
}

std::vector<PlacedPoint> place_points(const ViewPath& path, const light_shafts::Shafts& shafts,
                                      const RayParameters& parameters, const Camera& camera,
                                      std::span<const WeightedFunction> functions, const Progress& progress) {
    std::vector<PlacedPoint> points;
    std::vector<vec2> places_px;
    for (const auto& [function, weight] : functions)
        for (const transfer_functions::Layer& layer : function.layers)
            for (const transfer_functions::Constraint& constraint : layer.constraints) {
                if (!constraint.point ||
                    std::ranges::find(points, *constraint.point, &PlacedPoint::point) != points.end())
                    continue;
                if (const std::optional<vec2> place_px = camera.raster_position(*constraint.point);
                    place_px && camera.ray(place_px->x, place_px->y).exists()) {
                    points.push_back({*constraint.point, {}});
                    places_px.push_back(*place_px);
                }
            }
    if (points.empty())
        return points;
    const auto found = Asked(path, parameters, camera, places_px, progress).find(shafts, parameters, progress);
    for (std::size_t index = 0; index < points.size(); ++index)
        points[index].parameters = found[index];
    return points;
}

std::vector<vec2> ray_parameters(const Scene& scene, const Media& media, const Camera& camera,
                                 const FrameConfig& config, std::span<const vec2> places_px, Progress& progress) {
    require(!config.transfer_functions.empty(), "there is no transfer function whose parameters a ray could have");
    require_usable(camera);
    Statistics statistics;
    const DirectLight light(scene, media, statistics);
    const ViewPath path(scene, media, light, camera, {.collects_parts = true});
    RayParameters parameters(scene, camera, std::span(config.transfer_functions).first(1), config.reference_light);
    const Asked asked(path, parameters, camera, places_px, progress);
    const Asked grid(path, parameters, camera,
                     parameters.fits_visibility() ? grid_places_px(camera) : std::vector<vec2>(), progress);
    std::vector<light_shafts::ViewRay> rays = asked.parts.rays;
    rays.insert(rays.end(), grid.parts.rays.begin(), grid.parts.rays.end());
    light_shafts::Config shaft_config = config.shafts;
    shaft_config.visibility_light = parameters.visibility_light();
    const light_shafts::Shafts shafts(scene, media, light_shafts::view_of(camera), rays, shaft_config, progress);
    if (parameters.fits_visibility())
        fit_visibility(grid, shafts, parameters, progress);
    std::vector<vec2> first;
    for (const std::vector<vec2>& of_ray : asked.find(shafts, parameters, progress))
        first.push_back(of_ray.front());
    return first;
}
} // namespace tyndall::render
