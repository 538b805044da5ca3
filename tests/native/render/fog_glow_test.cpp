// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/random.hpp"
#include "core/sobol.hpp"
#include "render/fog_glow.hpp"
#include "render/glow_distances.hpp"
#include "support/chi_square.hpp"
#include "support/close_to.hpp"
#include "support/density_grids.hpp"
#include "support/fog_draws.hpp"
#include "support/one_point.hpp"
#include "volume/phase_function.hpp"
#include <array>
#include <doctest/doctest.h>
#include <functional>

namespace fog_glow_test {
using namespace tyndall;
using namespace tyndall::support;
using render::FogGlow;
using render::GlowDistances;
using render::MediaLine;
using render::MeshEmitters;

namespace {
Medium fog_of(const Rgb& sigma_s_per_m, float asymmetry_g = 0.0f, const Rgb& sigma_a_per_m = Rgb(0.0f)) {
    return {.name = "fog", .lobes = {{sigma_s_per_m, asymmetry_g}}, .sigma_a_per_m = sigma_a_per_m};
}
/// Of what all see of this part.
DrawnMean mean_of(const Scene& scene, const light_shafts::ViewRay& part, bool attenuates_light = true,
                  std::uint32_t pixels = 64) {
    const Media media(scene, Progress());
    const MeshEmitters emitters(scene);
    Statistics statistics;
    const FogGlow glow(scene, media, emitters, attenuates_light, statistics);
    REQUIRE(!glow.is_empty());
    MediaLine line;
    glow.assign(line, part);
    return mean_of_draws(pixels, [&](const FogGlow::Numbers& numbers, std::vector<FogGlow::Found>& found) {
        glow.draw(line, numbers, found);
    });
}
void check_within_noise(const DrawnMean& mean, const glm::dvec3& truth, double most_sigma) {
    CAPTURE(mean.value.x / truth.x - 1.0);
    CAPTURE(mean.sigma.x / truth.x);
    for (int channel = 0; channel < 3; ++channel) {
        CHECK(mean.sigma[channel] < most_sigma * truth[channel]);
        CHECK(std::abs(mean.value[channel] - truth[channel]) < 4.0 * mean.sigma[channel] + 2e-5 * truth[channel]);
    }
}
/// By Simpson's rule.
glm::dvec3 integral(double from, double to, const std::function<glm::dvec3(double)>& value) {
    constexpr int panels = 20'000;
    glm::dvec3 sum(0.0);
    for (int index = 0; index <= panels; ++index) {
        const double weight = index == 0 || index == panels ? 1.0 : index % 2 == 1 ? 4.0 : 2.0;
        sum += weight * value(from + (to - from) * index / panels);
    }
    return sum * (to - from) / (3.0 * panels);
}
const light_shafts::ViewRay along_x{vec3(-3.0f, 0.0f, 0.0f), vec3(1, 0, 0), 0.0f, 6.0f};
} // namespace

// Seen to fail with the phase function's cosine turned around, and without the media on the light's way.
TEST_CASE(
    "a plate that is small beside its distance lights fog as a lamp with a cosine does, near it and deep in fog") {
    const Rgb radiance(300.0f, 200.0f, 100.0f);
    constexpr float half_side = 1e-3f;
    for (const float density : {0.05f, 1.5f})
        for (const float asymmetry_g : {0.0f, 0.6f})
            for (const float height : {0.2f, 2.0f}) {
                CAPTURE(density);
                CAPTURE(asymmetry_g);
                CAPTURE(height);
                const glm::dvec3 sigma_s = double(density) * glm::dvec3(1.0, 0.7, 0.4), sigma_a(0.1, 0.0, 0.2),
                                 sigma_t = sigma_s + sigma_a;
                const auto scene =
                    make_scene({floor_at(vec3(0.5f, 0.0f, height), half_side, diffuse(Rgb(0.0f), radiance)),
                                box_of(0, vec3(0.0f), vec3(3.0f, 4.0f, 4.0f))},
                               {fog_of(Rgb(sigma_s), asymmetry_g, Rgb(sigma_a))});
                const auto scattered = [&](double at) {
                    const double x = 3.5 - at, distance2 = x * x + double(height) * height,
                                 distance = std::sqrt(distance2);
                    const double area = 4.0 * half_side * half_side;
                    return glm::dvec3(radiance) * area * (height / distance) / distance2 * sigma_s *
                           double(henyey_greenstein_per_sr(static_cast<float>(x / distance), asymmetry_g)) *
                           glm::exp(-sigma_t * (at + distance));
                };
                check_within_noise(mean_of(*scene, along_x), integral(0.0, 6.0, scattered), 1e-2);
            }
}

// Seen to fail with a density per metre that forgets the share that is spread blindly, with directions that are not
// weighed against triangles, and with Draine's factor in the density of directions that are drawn without it.
TEST_CASE(
    "fog in a furnace scatters what it takes away: a closed room that glows evenly, and light that is not dimmed") {
    const Rgb radiance(1.0f, 0.5f, 0.25f);
    const glm::dvec3 sigma_s(0.3, 0.2, 0.6);
    for (const auto [asymmetry_g, draine_alpha] : {vec2(0.0f), vec2(-0.5f, 0.0f), vec2(0.8f, 0.0f), vec2(0.6f, 9.0f)}) {
        // Around the fog and far from its middle, all glowing inwards through the backs of its faces.
        Part room{.mesh = cube(), .world_from_object = glm::scale(translation({2.0f, 1.0f, 0.5f}), vec3(8, 6, 3))};
        room.material = diffuse(Rgb(0.0f), radiance);
        Medium fog = fog_of(Rgb(sigma_s), asymmetry_g);
        fog.lobes[0].draine_alpha = draine_alpha;
        const auto scene = make_scene({room, box_of(0, vec3(0.0f), vec3(2.0f))}, {fog});
        // Of 6 m the fog has 4.
        const glm::dvec3 truth = glm::dvec3(radiance) * (1.0 - glm::exp(-sigma_s * 4.0));
        check_within_noise(mean_of(*scene, along_x, false), truth, 2e-2);
    }
}

TEST_CASE("fog against a wall that glows all around it has half of a furnace's light, however near the wall is") {
    for (const float height : {0.01f, 1.0f}) {
        CAPTURE(height);
        const auto scene = make_scene(
            {floor_at({0, 0, height}, 1e4f, diffuse(Rgb(0.0f), Rgb(1.0f))), box_of(0, {0, 0, -3}, {3, 3, 3.005f})},
            {fog_of(Rgb(0.2f))});
        // The floor is 20 km wide; isotropic fog sees it in half of all directions.
        check_within_noise(mean_of(*scene, along_x, false), glm::dvec3(0.5 * (1.0 - std::exp(-0.2 * 6.0))), 2e-2);
    }
}

TEST_CASE("what lies between takes its share: a pane in its colours, fog boxes one by one, a gap without fog nothing") {
    const Rgb radiance(50.0f), through(0.9f, 0.4f, 0.1f);
    const Part plate = floor_at({0, 0, 2.0f}, 0.01f, diffuse(Rgb(0.0f), radiance));
    const std::vector<Part> fog{box_of(0, {-2, 0, 0}, {1, 4, 0.5f}), box_of(1, {2.5f, 0, 0}, {0.5f, 4, 1})};
    const std::vector<Medium> media{fog_of(Rgb(0.5f, 1.0f, 0.2f)), fog_of(Rgb(0.8f), 0.4f)};
    std::vector<Part> parts{plate, fog[0], fog[1]};
    const DrawnMean clear = mean_of(*make_scene(parts, media), along_x);
    parts.push_back(floor_at({0, 0, 1.5f}, 4.0f, pane(through)));
    const DrawnMean tinted = mean_of(*make_scene(parts, media), along_x);
    for (int channel = 0; channel < 3; ++channel)
        CHECK(tinted.value[channel] == close_to(through[channel] * clear.value[channel], 1e-5));
    const auto scattered = [&](double at) {
        const bool is_first = at > 0.0 && at<2.0, is_second = at> 5.0;
        if (!is_first && !is_second)
            return glm::dvec3(0.0);
        const double x = 3.0 - at, distance = std::sqrt(x * x + 4.0), up = 2.0 / distance;
        const glm::dvec3 first(0.5, 1.0, 0.2), second(0.8);
        // On the way to the plate the first box ends half a metre up, or a metre before the plate's foot.
        const double in_first = is_first ? std::min(0.5 / up, x > 1.0 ? (x - 1.0) / x * distance : 1e9) : 0.0;
        const double in_second = is_second ? std::min(1.0 / up, -x > 2.0 ? (-x - 2.0) / -x * distance : 1e9) : 0.0;
        const glm::dvec3 depth =
            first * (std::min(at, 2.0) + in_first) + second * (std::max(0.0, at - 5.0) + in_second);
        const double phase = henyey_greenstein_per_sr(static_cast<float>(x / distance), is_first ? 0.0f : 0.4f);
        return glm::dvec3(radiance) * (4e-4 * up / (distance * distance)) * (is_first ? first : second) * phase *
               glm::exp(-depth);
    };
    const glm::dvec3 truth = integral(0.0, 2.0, scattered) + integral(5.0 + 1e-9, 6.0, scattered);
    check_within_noise(clear, truth, 1e-2);
}

TEST_CASE("a scene of any size sends the same light where its fog is as much thinner") {
    const auto light_at = [](float scale, float asymmetry_g) {
        const auto scene =
            make_scene({floor_at(scale * vec3(0.5f, 0.1f, 0.4f), scale * 0.3f, diffuse(Rgb(0.0f), Rgb(2.0f))),
                        box_of(0, vec3(0.0f), scale * vec3(3.0f, 4.0f, 4.0f))},
                       {fog_of(Rgb(0.3f / scale), asymmetry_g)});
        return mean_of(*scene, {scale * along_x.origin, along_x.direction, 0.0f, scale * along_x.far_m}, true, 4)
            .value.x;
    };
    for (const float asymmetry_g : {0.0f, 0.7f}) {
        const double at_1_m = light_at(1.0f, asymmetry_g);
        CHECK(at_1_m > 0.01);
        for (const float scale : {1e-4f, 1e-2f, 1e2f, 1e4f, 1e6f}) {
            CAPTURE(scale);
            CHECK(light_at(scale, asymmetry_g) == close_to(at_1_m, 6e-3));
        }
    }
}

TEST_CASE("smoke of a density grid is lit as the march of its densities says") {
    const auto density = [](int x, int y, int z) { return blob(16, x, y, z); };
    SceneDescription description = description_of(*make_scene(
        {floor_at({0.3f, 0.2f, 1.5f}, 0.01f, diffuse(Rgb(0.0f), Rgb(400.0f)))}, {fog_of(Rgb(2.0f, 1.0f, 4.0f), 0.3f)}));
    const std::shared_ptr<const DensityGrid> grid = unit_grid(16, density);
    description.volumes.push_back({.name = "smoke", .grid = grid, .medium_index = 0});
    const Scene scene(std::move(description), Progress());
    const Media media(scene, Progress());
    const auto scattered = [&](double at) {
        const vec3 point = along_x.origin + static_cast<float>(at) * along_x.direction,
                   way = vec3(0.3f, 0.2f, 1.5f) - point;
        const float distance = glm::length(way);
        const vec3 local = vec3(media.grids().all()[0].line(point, way).origin);
        const Rgb sigma_s = Rgb(2.0f, 1.0f, 4.0f) * grid->at(local).x;
        const Rgb passing = media.transmittance({along_x.origin, along_x.direction, 0.0f, static_cast<float>(at)}) *
                            media.transmittance({point, way / distance, 0.0f, distance});
        return glm::dvec3(Rgb(400.0f) * (4e-4f * way.z / (distance * distance * distance)) * sigma_s * passing *
                          henyey_greenstein_per_sr(way.x / distance, 0.3f));
    };
    check_within_noise(mean_of(scene, along_x), integral(2.0, 4.0, scattered), 1e-2);
}

TEST_CASE("emitters light the media of objects that their links name, and only instances that may light media") {
    const Part plate = floor_at({0, 0, 2.0f}, 0.5f, diffuse(Rgb(0.0f), Rgb(1.0f)));
    std::vector<Medium> media{fog_of(Rgb(0.5f)), fog_of(Rgb(0.5f))};
    media[1].receiver_set = 1;
    const auto described = [&](std::uint64_t receiver_sets) {
        SceneDescription description = description_of(
            *make_scene({plate, box_of(0, {-2, 0, 0}, {1, 1, 1}), box_of(1, {2, 0, 0}, {1, 1, 1})}, media));
        description.object_infos.resize(description.object_names.size());
        description.object_infos[0].links.receiver_sets = receiver_sets;
        return description;
    };
    const auto light_of = [&](std::uint64_t receiver_sets) {
        return mean_of(Scene(described(receiver_sets), Progress()), along_x).value.x;
    };
    const double both = light_of(~0ull), first = light_of(1), second = light_of(2);
    CHECK(first > 0.2 * both);
    CHECK(second > 0.2 * both);
    CHECK(first + second == close_to(both, 2e-2));

    SceneDescription hidden = described(~0ull);
    hidden.instances[0].lights_media = false;
    const Scene scene(std::move(hidden), Progress());
    const Media of_scene(scene, Progress());
    const MeshEmitters emitters(scene);
    Statistics statistics;
    CHECK(FogGlow(scene, of_scene, emitters, true, statistics).is_empty());
    CHECK(emitters.triangles().size() == 2); // they light surfaces
}

// Seen to fail where only the noise of what glows counts.
TEST_CASE("what glows in fog is drawn as often as it is worth beside the other noise of its pixels") {
    const auto scene =
        make_scene({floor_at({0.3f, 0, 0.5f}, 0.1f, diffuse(Rgb(0.0f), Rgb(10.0f))), box_of(0, {0, 0, 0}, {2, 2, 2})},
                   {fog_of(Rgb(0.3f))});
    const Media media(*scene, Progress());
    const MeshEmitters emitters(*scene);
    Statistics statistics;
    FogGlow glow(*scene, media, emitters, true, statistics);
    const double light = mean_of(*scene, along_x).value.x;
    const auto draws_beside = [&](double brightness, double noise, double cost, std::uint32_t longest_turn) {
        const render::PilotPixel pixel{along_x, brightness * light, noise * noise * light * light};
        glow.prepare({std::vector(64, pixel), cost, longest_turn}, Progress());
        return static_cast<double>(glow.draw_count()) / glow.turn();
    };
    CHECK(glow.draw_count() == 1);
    CHECK(draws_beside(0.0, 0.0, 20.0, 4) == FogGlow::most_draws); // nothing else is there
    CHECK(draws_beside(1000.0, 100.0, 20.0, 4) == 0.25);           // nobody sees its noise
    CHECK(draws_beside(1000.0, 100.0, 20.0, 1) == 1.0);            // as few as one sample can have
    CHECK(draws_beside(1.0, 0.0, 1e4, 4) == FogGlow::most_draws);  // all else takes more time
    CHECK(draws_beside(0.0, 0.0, 20.0, 4) >= draws_beside(1.0, 0.3, 20.0, 4));
    glow.prepare({}, Progress()); // no pilot
    CHECK(glow.draw_count() == 1);
    CHECK(glow.turn() == 1);
}

TEST_CASE("a tree of lights chooses along a line as often as it says, every light that may shine there") {
    std::vector<render::LightBounds> lights;
    for (std::uint32_t index = 0; index < 300; ++index) {
        const vec2 u = sobol_point(index, 1u), v = sobol_point(index, 2u), w = sobol_point(index, 3u);
        render::LightBounds light;
        light.box.grow(vec3(8.0f * u - 4.0f, 3.0f * v.x));
        light.box.grow(vec3(8.0f * u - 4.0f, 3.0f * v.x) + vec3(0.1f, 0.2f, 0.1f));
        light.axis = sample_uniform_sphere(w);
        light.reach_rad = 0.5f * pi;
        light.power = 0.1f + v.y;
        light.back = index % 2 == 0 ? 1.0f : 0.05f;
        lights.push_back(light);
    }
    const render::LightTree tree(lights);
    for (const float sigma_t : {0.0f, 1.0f}) {
        constexpr std::uint32_t draws = 100'000;
        std::vector<double> seen(lights.size()), expected(lights.size());
        for (std::uint32_t draw = 0; draw < draws; ++draw) {
            const auto [light, probability] =
                tree.choose_along({vec3(-4, 0, 1), vec3(1, 0, 0), 0.5f, 7.0f, sigma_t}, unit_float(hash(draw, 9u)));
            REQUIRE(light != render::LightTree::none);
            expected[light] = probability * draws;
            seen[light] += 1.0;
        }
        double sum = 0.0;
        for (const double value : expected)
            sum += value / draws;
        CHECK(sum == close_to(1.0, 1e-3)); // lights that were never drawn are missing
        CHECK(is_plausible(chi_square_p_value(seen, expected), 2));
    }
}

TEST_CASE("distances are drawn as often as their density says, in every piece, in thin fog and in thick") {
    const auto scene = make_scene({floor_at({1, 0, 0.3f}, 0.1f, diffuse(Rgb(0.0f), Rgb(1.0f))),
                                   box_of(0, {-2, 0, 0}, {1, 1, 1}), box_of(1, {1, 0, 0}, {1, 1, 1})},
                                  {fog_of(Rgb(2.0f, 0.1f, 0.5f), 0.7f), fog_of(Rgb(0.3f))});
    const Media media(*scene, Progress());
    const MeshEmitters emitters(*scene);
    MediaLine line;
    line.assign(media, along_x, StepLimits{});
    REQUIRE(line.pieces().size() == 2);
    const GlowDistances distances(line, emitters.triangles()[0], &media);
    constexpr int bins = 180, draws = 200'000;
    std::vector<double> seen(bins), expected(bins);
    for (int draw = 0; draw < draws; ++draw) {
        const GlowDistances::Distance at = distances.at((static_cast<float>(draw) + 0.5f) / draws);
        CHECK(at.pdf_per_m > 0.0f);
        CHECK((at.at_m <= 2.0f || (at.at_m >= 3.0f && at.at_m <= 5.0f)));
        const auto bin = static_cast<std::size_t>(std::min(bins - 1.0f, at.at_m * bins / 6.0f));
        seen[bin] += 1.0 / draws;
        expected[bin] += 1.0 / (double(at.pdf_per_m) * draws); // the length of the bin that lies in fog
    }
    double length_m = 0.0;
    for (int bin = 0; bin < bins; ++bin) {
        length_m += expected[static_cast<std::size_t>(bin)];
        const double from = bin * 6.0 / bins;
        const bool is_in_fog = from < 2.0 - 1e-6 || (from > 3.0 - 1e-6 && from < 5.0 - 1e-6);
        CHECK(expected[static_cast<std::size_t>(bin)] == close_to(is_in_fog ? 6.0 / bins : 0.0, 0.03));
    }
    CHECK(length_m == close_to(4.0, 1e-3));
}

// Seen to fail with a density that forgets what the fog takes.
TEST_CASE("places and directions of the phase function are drawn as often as their density says") {
    const auto scene = make_scene({box_of(0, {-2, 0, 0}, {1, 1, 1}), box_of(1, {1, 0, 0}, {1, 1, 1})},
                                  {fog_of(Rgb(1.5f, 0.5f, 1.0f), 0.5f), fog_of(Rgb(0.3f), -0.3f)});
    const Media media(*scene, Progress());
    MediaLine line;
    line.assign(media, along_x, StepLimits{});
    CHECK(line.has_peak());
    const render::PhaseDirections directions(line);
    constexpr int draws = 400'000;
    std::array<double, 8> measure{}; // of both pieces, in halves, onwards and back
    for (std::uint32_t draw = 0; draw < draws; ++draw) {
        const auto [piece, at_m, direction] = directions.at(sobol_point(draw, 1u), sobol_point(draw, 2u));
        REQUIRE(piece != nullptr);
        const std::size_t half = (at_m - piece->near_m > 1.0f ? 1u : 0u) + (direction.x > 0.0f ? 2u : 0u);
        measure[half + (piece == &line.pieces()[0] ? 0u : 4u)] +=
            1.0 / (double(directions.density(*piece, at_m, direction)) * draws);
    }
    for (const double m_sr : measure)
        CHECK(m_sr == close_to(2.0 * pi, 0.02)); // of 1 m and half of all directions
}

TEST_CASE(
    "a frame shows what glows in fog as its light shafts, by light groups, in the same bits on any number of threads") {
    SceneDescription description =
        description_of(*make_scene({floor_at({0, 0, -1}, 4.0f, diffuse(Rgb(0.0f))),
                                    floor_at({0.2f, 0, 1.0f}, 0.3f, diffuse(Rgb(0.0f), Rgb(5.0f, 2.0f, 1.0f))),
                                    floor_at({-0.6f, 0, 0.7f}, 0.2f, diffuse(Rgb(0.0f), Rgb(1.0f, 2.0f, 5.0f))),
                                    box_of(0, vec3(0.0f), {2.0f, 2.0f, 1.5f})},
                                   {fog_of(Rgb(0.2f))}));
    description.object_infos.resize(description.object_names.size());
    description.object_infos[1].light_group = 0;
    description.object_infos[2].light_group = 1;
    const Scene scene(std::move(description), Progress());
    Camera camera = camera_on(vec3(0.0f), 2.0f);
    camera.window_left = camera.window_bottom = -1.0f;
    camera.window_right = camera.window_top = 1.0f;
    camera.width_px = 12, camera.height_px = 10;
    render::FrameConfig config;
    config.pixel_samples = 4;
    config.passes.add(render::Pass::Shafts);
    config.light_groups = {"warm", "cold"};
    config.thread_count = 1;
    const render::Film one = film_of(scene, camera, config);
    config.thread_count = 2;
    const render::Film two = film_of(scene, camera, config);
    const std::vector<float>& shafts = one.find(render::Pass::Shafts)->values;
    CHECK(shafts == two.find(render::Pass::Shafts)->values);
    CHECK(one.find(render::Pass::Combined)->values == two.find(render::Pass::Combined)->values);
    CHECK(*std::ranges::min_element(shafts) > 0.0f);
    const auto plane_of = [&](std::string_view name) -> const std::vector<float>& {
        const auto plane = std::ranges::find(one.data_planes, name, &render::NamedPlane::name);
        REQUIRE(plane != one.data_planes.end());
        return plane->values;
    };
    const std::vector<float>&warm = plane_of("Shafts_warm"), &cold = plane_of("Shafts_cold");
    double warm_sum = 0.0, cold_sum = 0.0;
    for (std::size_t index = 0; index < shafts.size(); ++index) {
        CHECK(warm[index] + cold[index] == close_to(shafts[index], 1e-5));
        warm_sum += warm[index], cold_sum += cold[index];
    }
    CHECK(warm_sum > 0.1 * cold_sum);
    CHECK(cold_sum > 0.1 * warm_sum);
    const auto drawn = std::ranges::find(one.statistics.counts, "glow in fog: draws per ray",
                                         [](const auto& entry) { return entry.name; });
    CHECK(drawn != one.statistics.counts.end());
}
} // namespace fog_glow_test
