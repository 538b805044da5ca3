// SPDX-License-Identifier: GPL-3.0-or-later
// Where a pixel's noise comes from its light, a camera ray is worth several shadow rays.
#include "render/best_ray_counts.hpp"
#include "render/shadow_ray_counts.hpp"
#include "shading/lobes/lobe_models.hpp"
#include "support/close_to.hpp"
#include "support/scenes.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <doctest/doctest.h>

namespace shadow_ray_counts_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
/// Looks straight down at the ground from under a lid with a slit, or from under the open sky.
std::unique_ptr<Scene> room_under_sky(bool has_lid, const Material& of_ground = {.name = "white"}) {
    std::vector<Part> parts{{.mesh = square(), .material = of_ground}};
    if (has_lid) // two halves of a lid above the ground, with a slit between them
        for (const float side : {-1.0f, 1.0f})
            parts.push_back({.mesh = square(), .world_from_object = translation({side * 1.2f, 0, 0.5f})});
    SceneDescription description = description_of(*make_scene(parts));
    description.world = World("sky", Rgb(1.0f));
    return std::make_unique<Scene>(std::move(description), Progress());
}
Camera camera_above_ground() {
    Camera camera;
    camera.world_from_camera = translation({0, 0, 0.4f});
    camera.clip_near_m = 0.01f;
    camera.width_px = camera.height_px = 40;
    return camera;
}
render::ShadowRayCounts rays_to_sky(const Scene& scene, bool may_share = false, std::uint32_t pixel_samples = 16) {
    const Media media(scene, Progress());
    Statistics statistics;
    const render::DirectLight light(scene, media, statistics);
    const render::FilterSampler filter(render::PixelFilter::BlackmanHarris, 1.5f);
    Progress progress;
    return render::count_shadow_rays(scene, media, light, nullptr, camera_above_ground(), filter,
                                     {.may_share_world = may_share, .pixel_samples = pixel_samples, .seed = 3}, {},
                                     progress);
}
/// On the ground, under the sky and the lid with a slit.
struct PointBelowSlit {
    std::unique_ptr<Scene> scene = room_under_sky(true);
    Media media{*scene, Progress()};
    Statistics statistics;
    render::DirectLight light{*scene, media, statistics};
    Ray down{.origin = {0.1f, 0.2f, 0.4f}, .direction = {0, 0, -1}};
    render::SurfacePoint point = render::surface_point(*scene, down, scene->closest_hit(down), 7);

    [[nodiscard]] glm::dvec3 irradiance(std::uint32_t sample) const {
        constexpr std::array<std::uint8_t, 1> only_light{1};
        render::DirectLight::Irradiance found;
        light.at({&point, 1}, {.sample_index = sample, .pair_index = 0}, only_light, {&found, 1});
        return glm::dvec3(found.sum());
    }
};
} // namespace

TEST_CASE("the best number of shadow rays is sqrt((v_light / c_light) / (v_camera / c_camera)), as powers of two go") {
    for (const double ratio : {0.01, 0.1, 0.4, 1.0, 3.0, 20.0, 1000.0})
        for (const double cost : {0.1, 1.0, 5.0}) {
            const std::array pixels{render::PixelVariances{.of_camera = 1.0, .of_light = {ratio}}};
            const std::uint32_t best = render::best_ray_counts(pixels, {8.0, {cost}}).front();
            const auto noise = [&](double count) { return (1.0 + ratio / count) * (8.0 + count * cost); };
            for (std::uint32_t other = 1; other <= 16; other *= 2)
                CHECK(noise(best) <= noise(other) * (1.0 + 1e-12));
        }
}

TEST_CASE("each light gets its own number, and pixels without light have no say") {
    const std::vector<render::PixelVariances> pixels(
        9, render::PixelVariances{.of_camera = 0.01, .of_light = {0.0, 0.5, 0.01}});
    const std::vector<std::uint32_t> counts = render::best_ray_counts(pixels, {8.0, {1.0, 1.0, 1.0}});
    CHECK(counts[0] == 1);
    CHECK(counts[1] > counts[2]);
    CHECK(render::best_ray_counts({}, {8.0, {1.0, 1.0}}) == std::vector<std::uint32_t>{1, 1});
}

TEST_CASE("rays are doubled only where that saves as much of the noise as is asked") {
    const std::array pixels{render::PixelVariances{.of_camera = 0.0, .of_light = {1.0}}};
    // Of camera rays as long as 8 shadow rays: 2 save 25 % of the noise in a fixed time, 4 again 23 %, 8 18, 16 13.
    CHECK(render::best_ray_counts(pixels, {8.0, {1.0}}).front() == 16);
    CHECK(render::best_ray_counts(pixels, {8.0, {1.0}, {0.15}}).front() == 8);
    CHECK(render::best_ray_counts(pixels, {8.0, {1.0}, {0.2}}).front() == 4);
    CHECK(render::best_ray_counts(pixels, {8.0, {1.0}, {0.5}}).front() == 1);
}

TEST_CASE("lights take the turns with the least noise in a fixed time, and none where that is little") {
    // By one camera ray, by the choice on a light, and by what lies beside: of a camera ray as long as ten shadow rays.
    for (const double by_camera : {0.0, 0.1, 1.0})
        for (const double by_light : {0.01, 0.3, 1.0}) {
            const std::array pixels{
                render::PixelVariances{.of_camera = 1.0, .of_light = {by_light}, .of_camera_by_light = {by_camera}}};
            for (const double cost : {0.5, 20.0}) {
                const std::uint32_t best =
                    render::best_turns(pixels, {10.0, {cost}}, std::array<std::uint32_t, 1>{1}, 8).front();
                const auto noise = [&](double turn) {
                    return std::sqrt((1.0 + by_light + (turn - 1.0) * (by_light + by_camera)) * (10.0 + cost / turn));
                };
                double least = noise(1);
                for (std::uint32_t turn = 2; turn <= 8; turn *= 2)
                    least = std::min(least, noise(turn));
                CHECK(noise(best) == close_to(least > 0.92 * noise(1) ? noise(1) : least, 1e-5));
            }
        }
    const std::vector<render::PixelVariances> pixels(
        4, render::PixelVariances{.of_camera = 1.0, .of_light = {1e-4, 3.0, 1e-4}});
    const std::vector<std::uint32_t> turns =
        render::best_turns(pixels, {4.0, {8.0, 4.0, 4.0}}, std::array<std::uint32_t, 3>{1, 1, 2}, 4);
    CHECK(turns == std::vector<std::uint32_t>{4, 1, 1}); // a light of several rays is worth one at each sample
    CHECK(render::best_turns({}, {4.0, {4.0}}, std::array<std::uint32_t, 1>{1}, 4).front() == 1);
}

TEST_CASE("a light's turn is worth its samples, and each comes once in as many") {
    PointBelowSlit below;
    for (const std::uint32_t first : {0u, 1u, 6u}) {
        double in_turns = 0.0;
        std::uint32_t asked = 0;
        below.light.set_turns({4});
        for (std::uint32_t sample = first; sample < first + 16; ++sample) {
            const double found = below.irradiance(sample).x;
            in_turns += found;
            asked += found > 0.0 ? 1 : 0;
            CHECK((found == 0.0 || sample % 4 == 0));
        }
        below.light.set_turns({1});
        double each = 0.0;
        const std::uint32_t first_turn = (first + 3) / 4;
        for (std::uint32_t turn = first_turn; turn < first_turn + 4; ++turn)
            each += 4.0 * below.irradiance(turn).x;
        CHECK(asked > 0);
        CHECK(in_turns == close_to(each, 1e-6));
    }
}

TEST_CASE("under an open sky one ray says all, below a slit it takes many") {
    CHECK(rays_to_sky(*room_under_sky(false)).of_light.back() == 1);
    CHECK(rays_to_sky(*room_under_sky(true)).of_light.back() >= 4);
}

TEST_CASE("blades of grass in bright fog are edges between more and less of it, which no shadow ray smooths") {
    const auto rays_in_fog = [](float lamp_w) {
        std::vector<Part> parts{{.mesh = square()}};
        for (const float side : {-1.0f, 1.0f})
            parts.push_back({.mesh = square(), .world_from_object = translation({side * 1.2f, 0, 0.5f})});
        for (int blade = -20; blade <= 20; ++blade) // half a pixel wide, far above the ground
            parts.push_back({.mesh = square(),
                             .world_from_object = glm::scale(translation({0.01f * static_cast<float>(blade), 0, 0.2f}),
                                                             vec3(0.0025f, 1.0f, 1.0f))});
        Part fog{.mesh = cube()};
        fog.material = {.name = "fog", .medium_index = 0, .has_surface = false};
        parts.push_back(fog);
        Medium medium{.name = "fog", .lobes = {{.sigma_s_per_m = Rgb(0.5f)}}};
        Light lamp{.name = "lamp",
                   .kind = LightKind::Point,
                   .strength = Rgb(lamp_w),
                   .position = {0, 0, 0.45f},
                   .lights_surfaces = {false, false, false}};
        SceneDescription description = description_of(*make_scene(parts, {medium}, {lamp}));
        description.world = World("sky", Rgb(1.0f));
        return rays_to_sky(Scene(std::move(description), Progress())).of_light.back();
    };
    CHECK(rays_in_fog(0.0f) >= 2 * rays_in_fog(100.0f));
}

TEST_CASE("with what neighbours find, a pixel needs fewer; where one ray says all, nothing is shared") {
    const auto open = rays_to_sky(*room_under_sky(false), true), room = rays_to_sky(*room_under_sky(true), true);
    CHECK(!open.is_world_shared);
    CHECK(room.is_world_shared);
    CHECK(room.of_light.back() < rays_to_sky(*room_under_sky(true)).of_light.back());
}

TEST_CASE("who asks for many samples gets the rays with the least noise, who asks for few gets fewer") {
    const auto rays = [](std::uint32_t pixel_samples) {
        return rays_to_sky(*room_under_sky(true), false, pixel_samples).of_light.back();
    };
    CHECK(rays(1) == rays(16));
    CHECK(rays(16) < rays(1024));
}

TEST_CASE("what shines by lobes alone counts, and sharp ones, which look one way, need fewer rays than rough ones") {
    const auto rays = [](float roughness) {
        const Material gloss{.name = "gloss",
                             .constant = {.diffuse_albedo = Rgb(0.0f)},
                             .lobe_sources = {{.model = LobeModel::Glossy,
                                               .constants = {Rgb(1.0f), Rgb(0.8f), Rgb(roughness)},
                                               .registers = std::vector<std::uint16_t>(3, LobeSource::no_register)}}};
        return rays_to_sky(*room_under_sky(true, gloss), false, 1024).of_light.back();
    };
    CHECK(rays(0.05f) < rays(0.9f)); // not so while lobes counted as diffuse
}

TEST_CASE("several shadow rays are the mean of as many samples with one") {
    PointBelowSlit below;
    for (const std::uint32_t sample : {0u, 1u, 5u}) {
        glm::dvec3 mean(0.0);
        below.light.set_ray_counts({1});
        for (std::uint32_t ray = 0; ray < 8; ++ray)
            mean += below.irradiance(sample * 8 + ray) / 8.0;
        below.light.set_ray_counts({8});
        CHECK(mean.x > 0.0);
        CHECK(glm::length(below.irradiance(sample) - mean) < 1e-6 * glm::length(mean));
    }
}
} // namespace shadow_ray_counts_test
