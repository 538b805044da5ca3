// SPDX-License-Identifier: GPL-3.0-or-later
// Shafts of area lights, against marching with points of the light that each point of a ray samples for itself.
#include "core/parallel.hpp"
#include "light_shafts/scattering_lights.hpp"
#include "scene/light_texture.hpp"
#include "scene/softened_patch.hpp"
#include "support/area_lights.hpp"
#include "support/forest.hpp"
#include "support/relative_error.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>
#include <numeric>

namespace area_shafts_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
constexpr float sigma_s_per_m = 0.05f, usual_g = 0.3f;
struct Case {
    std::string name;
    Light light;
};
/// High up, shining down at a slant; the strata are told from each other by the bar and the board below.
std::vector<Case> cases() {
    Light window = support::area_light({0.6f, 0.35f});
    window.position = {-0.5f, 0.3f, 2.2f};
    window.spot_axis = glm::normalize(vec3(0.35f, 0.1f, -0.9f));
    const auto [x, y] = orthonormal_basis(-window.spot_axis);
    window.light_from_world_directions = glm::transpose(mat3(x, y, -window.spot_axis));
    std::vector<Case> result{{"window", window}};
    window.is_ellipse = true;
    result.push_back({"ellipse", window});
    window.spot_half_angle_rad = 0.6f;
    result.push_back({"soft box", window});
    window.is_ellipse = false;
    window.spot_half_angle_rad = 0.1f;
    result.push_back({"narrow", window});
    return result;
}
std::unique_ptr<Scene> scene_of(const Light& light, float asymmetry_g = usual_g) {
    const auto board = [](const vec3& at, const vec2& half) {
        return support::Part{.mesh = support::square(),
                             .world_from_object = support::translation(at) * glm::scale(mat4(1.0f), vec3(half, 1.0f))};
    };
    std::vector<support::Part> parts{board({0.1f, 0.3f, 0.9f}, {0.08f, 1.0f}),
                                     board({-0.8f, 0.4f, 0.6f}, {0.4f, 0.4f})};
    parts.push_back({.mesh = support::cube(),
                     .world_from_object = glm::scale(mat4(1.0f), vec3(4.0f)),
                     .material = {.name = "fog", .medium_index = 0, .has_surface = false}});
    return support::make_scene(parts, {{.name = "fog", .lobes = {{Rgb(sigma_s_per_m), asymmetry_g}}}}, {light});
}
std::vector<ViewRay> rays_past(const vec3& at, int count) {
    support::SceneRandom random(8);
    const vec3 eye(0.4f, -3.5f, 0.9f);
    std::vector<ViewRay> rays;
    for (int index = 0; index < count; ++index)
        rays.push_back(
            {eye, glm::normalize(at + 1.4f * std::sqrt(random.uniform()) * random.direction() - eye), 0.0f, 12.0f});
    return rays;
}
double march(const Scene& scene, const ViewRay& ray, int steps, support::SceneRandom& random, float g) {
    const Progress progress;
    const Light& light = scene.lights()[0];
    const double step_m = (double{ray.far_m} - ray.near_m) / steps;
    double sum = 0.0;
    for (int step = 0; step < steps; ++step) {
        const auto t = static_cast<float>(ray.near_m + (step + double{random.uniform()}) * step_m);
        const vec3 point = ray.origin + t * ray.direction;
        if (glm::any(glm::greaterThan(glm::abs(point), vec3(4.0f))))
            continue;
        constexpr int strata = 8;
        for (int index = 0; index < strata; ++index) {
            const vec2 u((static_cast<float>(index) + random.uniform()) / strata, random.uniform());
            const LightSample sample = sample_light_towards(light, 0, u, point);
            if (sample.strength == Rgb(0.0f))
                continue;
            const vec3 way = sample.position - point;
            const float distance_m = glm::length(way);
            const Ray to_light{.origin = point, .direction = way / distance_m, .far_m = distance_m};
            const float irradiance = intensity_w_per_sr(sample, -to_light.direction).x / (distance_m * distance_m) *
                                     texture_colour(light, sample.position, point).x;
            const float cosine = glm::dot(ray.direction, to_light.direction);
            const double phase =
                (1.0 - g * g) / (4.0 * std::numbers::pi * std::pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
            sum += irradiance * phase * std::exp(-sigma_s_per_m * (t + distance_m)) *
                   double{scene.shadow_transmittance(to_light).x} / strata;
        }
    }
    return sum * step_m * sigma_s_per_m;
}
std::vector<double> march(const Scene& scene, std::span<const ViewRay> rays, int steps, float g = usual_g) {
    const Progress progress;
    std::vector<double> of_ray(rays.size());
    parallel_for(
        rays.size(), progress,
        [&](std::size_t ray) {
            support::SceneRandom random(100 + ray);
            of_ray[ray] = march(scene, rays[ray], steps, random, g);
        },
        1);
    return of_ray;
}
std::vector<double> radiance(const Scene& scene, std::span<const ViewRay> rays, const Config& config) {
    Progress progress;
    std::vector<double> result;
    for (const Rgb& each : run(scene, {.position = rays[0].origin}, rays, config, progress).radiance)
        result.push_back(each.x);
    return result;
}
double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}
} // namespace

TEST_CASE("an area light's strata scatter what marching with the light itself says, ray by ray") {
    for (const auto& [name, light] : cases()) {
        CAPTURE(name);
        const auto scene = scene_of(light);
        const std::vector<ViewRay> rays = rays_past(light.position + 0.9f * light.spot_axis, 64);
        const std::vector<double> marched = march(*scene, rays, 4000);
        const auto ours =
            radiance(*scene, rays, {.method = Method::Exact, .light_samples = 1024, .adapts_strata = false});
        CHECK(std::abs(mean(ours) / mean(marched) - 1.0) < 0.005);
        CHECK(support::relative_rmse(ours, marched) < 0.04); // of which marching has most
    }
}
// Seen to fail (by 15 % of the mean) where strata fall off with the square of the distance.
TEST_CASE("an area light's light may fall off in any way with the distance, and show a picture beside it") {
    auto halves = std::make_shared<Texture>();
    halves->width = 2, halves->height = 1, halves->extension = TextureExtension::Extend;
    halves->floats = std::vector{1.0f, 1.0f, 1.0f, 1.0f, 0.2f, 0.2f, 0.2f, 1.0f};
    for (const std::uint8_t power : {std::uint8_t{1}, std::uint8_t{2}})
        for (auto& [name, light] : cases()) {
            CAPTURE(name);
            CAPTURE(int{power});
            light.texture = std::make_shared<const LightTexture>(
                LightTexture{.image = std::make_shared<const FilteredTexture>(halves),
                             .projection = LightProjection::Emitter,
                             .distance_power = power,
                             .smooth_m2 = power == 1 ? 0.0f : 2.0f});
            const auto scene = scene_of(light);
            const std::vector<ViewRay> rays = rays_past(light.position + 0.9f * light.spot_axis, 32);
            const std::vector<double> marched = march(*scene, rays, 4000);
            const auto ours =
                radiance(*scene, rays, {.method = Method::Exact, .light_samples = 1024, .adapts_strata = false});
            CHECK(std::abs(mean(ours) / mean(marched) - 1.0) < 0.02); // both: the march, in narrow beams
            CHECK(support::relative_rmse(ours, marched) < 0.08);
        }
}
TEST_CASE("the three methods agree about area lights") {
    for (const auto& [name, light] : cases()) {
        CAPTURE(name);
        const auto scene = scene_of(light);
        const std::vector<ViewRay> rays = rays_past(light.position + 0.9f * light.spot_axis, 192);
        const auto of = [&](Method method) {
            return radiance(*scene, rays,
                            {.method = method, .error_target = 0.005f, .light_samples = 16, .adapts_strata = false});
        };
        const std::vector<double> exact = of(Method::Exact);
        for (const Method method : {Method::Epipolar, Method::ShadowMap}) {
            const std::vector<double> rows = of(method);
            CHECK(std::abs(mean(rows) / mean(exact) - 1.0) < 0.005);
            CHECK(support::relative_rmse(rows, exact) < 0.02);
        }
    }
}
// Inverse squares of single points would be off by 50 % and more here.
TEST_CASE("points between an area light and its strata's spacing get light as even as the light is") {
    for (const float half_spread_rad : {1.5707964f, 0.5f, 0.1f}) {
        Light light = support::area_light({1.0f, 1.0f});
        light.spot_half_angle_rad = half_spread_rad;
        support::SceneRandom random(5);
        double squares = 0.0, sum = 0.0;
        constexpr int count = 400;
        for (int index = 0; index < count; ++index) {
            // Half a patch's radius before it; away from its edge, what it gives there is pi times its radiance.
            const vec2 foot(random.uniform(-0.5f, 0.5f), random.uniform(-0.5f, 0.5f));
            const vec3 point = support::before(light, foot, 0.03f);
            double irradiance = 0.0;
            for (std::uint32_t stratum = 0; stratum < 256; ++stratum) {
                const LightSample sample = stratum_of(light, 0, stratum, 256, 0);
                const LocalView view = view_local(sample, point);
                irradiance += double{view.irradiance.x} * glm::dot(light.spot_axis, view.from_light);
            }
            const double ratio = irradiance / (std::numbers::pi * light.strength.x / 4.0);
            sum += ratio;
            squares += ratio * ratio;
        }
        CAPTURE(half_spread_rad);
        const double average = sum / count;

        CHECK(std::abs(average - 1.0) < 0.1);
        CHECK(std::sqrt(squares / count - average * average) < 0.35);
    }
}
// Patches are softened by their size. If that came from a patch's middle it would graze the patch, and a lamp seen from
// behind would light such fog 10 % too brightly; without its edges' shares a lamp lacks 7 % with 256 samples.
TEST_CASE("next to a wide area light fog gets what the light sends, from all sides, with few samples") {
    for (const bool is_ellipse : {false, true}) {
        CAPTURE(is_ellipse);
        Light light = support::area_light({3.0f, 3.0f});
        light.position = {0.0f, 0.0f, 0.3f};
        light.spot_axis = {0.0f, 0.0f, -1.0f};
        light.is_ellipse = is_ellipse;
        const auto [x, y] = orthonormal_basis(-light.spot_axis);
        light.light_from_world_directions = glm::transpose(mat3(x, y, -light.spot_axis));
        const std::vector<ViewRay> rays = rays_past({0.0f, 0.0f, -0.5f}, 64);
        for (const float asymmetry_g : {0.0f, 0.7f}) {
            CAPTURE(asymmetry_g);
            const auto scene = scene_of(light, asymmetry_g);
            const double marched = mean(march(*scene, rays, 4000, asymmetry_g));
            const auto off = [&](std::uint32_t samples) {
                double sum = 0.0;
                for (std::uint32_t seed = 0; seed < 4; ++seed)
                    sum += mean(radiance(
                        *scene, rays,
                        {.method = Method::Exact, .light_samples = samples, .adapts_strata = false, .seed = seed}));
                return sum / 4 / marched - 1.0;
            };
            CHECK(std::abs(off(64)) < (asymmetry_g > 0.0f ? 0.035 : 0.008));
            CHECK(std::abs(off(256)) < 0.006);
        }
    }
}
// What all patches give a point next to the light's edge is what the light gives there.
TEST_CASE("beside an area light's edge its strata light what the light does, and where it does not shine nothing") {
    for (const bool is_ellipse : {false, true})
        for (const float half_spread_rad : {1.5707964f, 1.3f, 0.5f}) {
            CAPTURE(is_ellipse);
            CAPTURE(half_spread_rad);
            Light light = support::area_light({1.0f, 1.0f});
            light.is_ellipse = is_ellipse;
            light.spot_half_angle_rad = half_spread_rad;
            support::SceneRandom random(5);
            double inside = 0.0, outside = 0.0, true_inside = 0.0, true_outside = 0.0;
            for (int index = 0; index < 2000; ++index) {
                const float turn = 6.2831853f * random.uniform();
                const float from_middle = random.uniform(0.7f, 1.3f), height_m = random.uniform(0.01f, 0.2f);
                const vec2 foot = from_middle * vec2(std::cos(turn), std::sin(turn));
                const bool is_inside =
                    is_ellipse ? from_middle < 1.0f : std::max(std::abs(foot.x), std::abs(foot.y)) < 1.0f;
                const vec3 point = support::before(light, foot, height_m);
                double fluence = 0.0, truth = 0.0;
                for (std::uint32_t stratum = 0; stratum < 64; ++stratum) {
                    const LightSample sample = stratum_of(light, 0, stratum, 64, 0);
                    fluence += double{view_local(sample, point).irradiance.x};
                    const LightSample towards = sample_light_towards(
                        light, 0, vec2((static_cast<float>(stratum) + random.uniform()) / 64.0f, random.uniform()),
                        point);
                    const vec3 way = point - towards.position;
                    if (towards.strength != Rgb(0.0f))
                        truth += double{intensity_w_per_sr(towards, glm::normalize(way)).x} / glm::dot(way, way) / 64;
                }
                (is_inside ? inside : outside) += fluence;
                (is_inside ? true_inside : true_outside) += truth;
            }
            const double share = is_ellipse && is_narrow_area(light) ? 0.06 : 0.02;
            CHECK(std::abs(inside / true_inside - 1.0) < share);
            CHECK(std::abs(outside - true_outside) < 0.02 * true_inside);
        }
}
TEST_CASE("what lies behind an area light gets nothing of it, and no sample is prepared for it") {
    Light light = cases()[0].light;
    light.position = {0, 0, 6.5f};
    light.spot_axis = {0, 0, 1};
    const auto scene = scene_of(light);
    Progress progress;
    const Media media(*scene, progress);
    Statistics statistics;
    CHECK(find_scattering_lights(*scene, media, {}, {.of_light = {16}}, statistics).size() == 1); // their balls touch
    light.position.z = 9.0f;
    const auto farther = scene_of(light);
    const Media same(*farther, progress);
    CHECK(find_scattering_lights(*farther, same, {}, {.of_light = {16}}, statistics).empty());
    const std::vector<ViewRay> rays = rays_past(vec3(0.0f), 16);
    CHECK(mean(radiance(*scene, rays, {.method = Method::Exact, .light_samples = 16})) == 0.0);
}
TEST_CASE("however few its strata, an area light that shows a picture sends what the whole of it sends") {
    auto bright_corner = std::make_shared<Texture>();
    bright_corner->width = bright_corner->height = 64;
    bright_corner->extension = TextureExtension::Extend;
    std::vector<float> texels;
    for (int texel = 0; texel < 64 * 64; ++texel) {
        const bool is_bright = texel % 64 < 20 && texel / 64 < 11;
        texels.insert(texels.end(), {is_bright ? 9.0f : 0.0f, static_cast<float>(texel % 64), 1.0f, 1.0f});
    }
    bright_corner->floats = std::move(texels);
    Light light = cases()[0].light;
    light.strength = {1, 2, 3};
    light.texture = std::make_shared<const LightTexture>(LightTexture{
        .image = std::make_shared<const FilteredTexture>(bright_corner), .projection = LightProjection::Emitter});
    const std::unique_ptr<Scene> scene = scene_of(light);
    const Media media(*scene, Progress());
    const Rgb whole = light.strength * Rgb(9.0f * 20 * 11 / 4096, 31.5f, 1.0f);
    for (const std::uint32_t count : {1u, 4u, 16u, 256u}) {
        CAPTURE(count);
        Statistics statistics;
        StrataCounts counts;
        counts.of_light = {count};
        const auto lights = find_scattering_lights(*scene, media, {}, counts, statistics);
        REQUIRE(lights.size() == 1);
        Rgb sum(0.0f);
        for (const LightSample& sample : lights[0].samples) {
            sum += sample.strength;
            CHECK(sample.textured == nullptr);
        }
        CHECK(glm::length(sum / whole - 1.0f) < 1e-4f);
    }
}
} // namespace area_shafts_test
