// SPDX-License-Identifier: GPL-3.0-or-later
// What the light shafts of a ray are multiplied by, against closed forms and against a march that knows nothing of steps,
// shares or lit intervals: the ray is cut into pieces, each is asked what it scatters and looks up the air in its middle.
#include "light_shafts/light_shafts.hpp"
#include "support/soup.hpp"
#include "volume/air_texture.hpp"
#include <doctest/doctest.h>
#include <random>

namespace heterogeneity_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
constexpr float sigma_per_m = 0.3f;
Medium fog(const Rgb& sigma_s = Rgb(sigma_per_m)) { return {.name = "fog", .lobes = {{sigma_s, 0.0f}}}; }
/// [-4, 4]^3.
support::Part fog_box() {
    return {.mesh = support::cube(),
            .world_from_object = glm::scale(mat4(1.0f), vec3(4.0f)),
            .material = {.name = "fog", .medium_index = 0, .has_surface = false}};
}
Light sun(const vec3& towards_light, float half_angle_rad = 0.0f) {
    return {.name = "Sun",
            .kind = LightKind::Sun,
            .strength = Rgb(2.0f),
            .towards_light = glm::normalize(towards_light),
            .half_angle_rad = half_angle_rad};
}
Light lamp(const vec3& position, float radius_m = 0.0f) {
    return {
        .name = "Lamp", .kind = LightKind::Point, .strength = Rgb(4.0f), .position = position, .radius_m = radius_m};
}
/// Squares of 2 m x 2 m that stand in the light of the ray along x.
std::vector<support::Part> with_plates() {
    std::vector<support::Part> parts{fog_box()};
    for (const vec3& centre : {vec3(-1.5f, 0, 2), vec3(2, 0, 1), vec3(-3.5f, 0, -1)})
        parts.push_back({.mesh = support::square(),
                         .world_from_object = glm::scale(support::translation(centre), vec3(0.5f, 2.0f, 1.0f))});
    return parts;
}
ViewRay ray_along_x() { return {.origin = {-10, 0.1f, 0.2f}, .direction = {1, 0, 0}, .near_m = 0.0f, .far_m = 100.0f}; }

struct Frame {
    std::unique_ptr<Scene> scene;
    Progress progress;
    Media media;
    Shafts shafts;
    inline static const Config config{.method = Method::Exact, .light_samples = 4, .shares_strata = false};

    Frame(std::unique_ptr<Scene> made, std::span<const ViewRay> rays)
        : scene(std::move(made)), media(*scene, progress),
          shafts(*scene, media, {.position = rays[0].origin}, rays, config, progress) {}
    [[nodiscard]] double of(const ViewRay& ray, const Heterogeneity& heterogeneity, Turn turn = {}) const {
        return double{shafts.find_heterogeneity({&ray, 1}, AirTexture(heterogeneity, progress), progress, turn)[0]};
    }
};

/// Intensity 1 + x / 4 within the fog: linear between the centres of 2 samples at x = -4 and 4.
Heterogeneity brighter_along_x() {
    PaintedVolume intensity{.size = {2, 1, 1}, .values = {0.0f, 2.0f}};
    Heterogeneity heterogeneity{.amount = 0.0f, .step_count = 512};
    heterogeneity.noise.resolution = 32;
    heterogeneity.unit_from_scene =
        glm::inverse(glm::scale(mat4(1.0f), vec3(16, 16, 16)) * support::translation(vec3(-0.5f)));
    heterogeneity.painted = std::make_shared<const PaintedAir>(PaintedVolume{}, PaintedVolume{}, intensity);
    return heterogeneity;
}
Heterogeneity noisy(std::uint32_t step_count) {
    Heterogeneity heterogeneity{.noise = {.scale_m = 1.5f, .resolution = 64}, .step_count = step_count};
    return heterogeneity;
}

/// Mean of the air over pieces of the ray, by what each piece scatters.
double marched(const Frame& frame, const ViewRay& ray, const AirTexture& air, int count) {
    std::vector<ViewRay> pieces;
    const float begin_m = 6.0f, length_m = 8.0f; // of the ray in the fog
    for (int piece = 0; piece < count; ++piece)
        pieces.push_back({ray.origin, ray.direction,
                          begin_m + length_m * static_cast<float>(piece) / static_cast<float>(count),
                          begin_m + length_m * static_cast<float>(piece + 1) / static_cast<float>(count)});
    std::vector<Rgb> radiance(pieces.size());
    frame.shafts.scatter(pieces, radiance, {}, frame.progress);
    double sum = 0.0, weight_sum = 0.0;
    for (std::size_t piece = 0; piece < pieces.size(); ++piece) {
        const float middle_m = 0.5f * (pieces[piece].near_m + pieces[piece].far_m);
        const Rgb before = frame.media.transmittance(
            {.origin = ray.origin, .direction = ray.direction, .near_m = 0.0f, .far_m = pieces[piece].near_m});
        const double weight = double{average(before * radiance[piece])};
        sum += weight * double{air.at(ray.origin + middle_m * ray.direction, 0.0f, 0.0f)};
        weight_sum += weight;
    }
    return sum / weight_sum;
}
} // namespace

TEST_CASE("without an amount the light stays what it is, and an even intensity scales it") {
    const Frame frame(support::make_scene(with_plates(), {fog()}, {sun({0.2f, 0, 1}), lamp({0, 1, 2})}),
                      std::array{ray_along_x()});
    CHECK(frame.of(ray_along_x(), {.amount = 0.0f}) == 1.0);
    CHECK(frame.of(ray_along_x(), {.amount = 0.0f, .intensity = 4.0f}) == 4.0);
    CHECK(std::abs(frame.of(ray_along_x(), {.amount = 0.0f, .intensity = 0.3f}) / 0.3 - 1.0) < 1e-6);
}

TEST_CASE("a sun through even fog weighs the air by the transmittance to the camera and to the sun") {
    // The sun shines along the ray: the way to it shortens as that to the camera grows, so that all points count alike.
    const Frame against(support::make_scene({fog_box()}, {fog()}, {sun({1, 0, 0})}), std::array{ray_along_x()});
    CHECK(std::abs(against.of(ray_along_x(), brighter_along_x()) - 1.0) < 1e-4);
    // From behind: exp(-2 sigma t), of which the mean t is 1 / (2 sigma) - L / (exp(2 sigma L) - 1).
    const Frame along(support::make_scene({fog_box()}, {fog()}, {sun({-1, 0, 0})}), std::array{ray_along_x()});
    const double k = 2.0 * double{sigma_per_m}, mean_m = 1.0 / k - 8.0 / std::expm1(k * 8.0);
    CHECK(std::abs(along.of(ray_along_x(), brighter_along_x()) - (1.0 + (mean_m - 4.0) / 4.0)) < 1e-4);
    Heterogeneity whole = brighter_along_x();
    whole.weighting = Heterogeneity::Weighting::WholeRay;
    CHECK(std::abs(along.of(ray_along_x(), whole) - 1.0) < 1e-4);
}

TEST_CASE("only what is lit counts: the air of shadows does not show") {
    std::vector<support::Part> parts{fog_box()};
    // A wall across x > 0 hides the sun from above; the ray is lit from x = -4 to 0.
    parts.push_back(
        {.mesh = support::square(), .world_from_object = glm::scale(support::translation({4, 0, 3}), vec3(4, 5, 1))});
    const Frame frame(support::make_scene(parts, {fog(Rgb(1e-4f))}, {sun({0, 0, 1})}), std::array{ray_along_x()});
    Heterogeneity air = brighter_along_x();
    CHECK(std::abs(frame.of(ray_along_x(), air) - 0.5) < 1e-3); // the mean of 1 + x / 4 over [-4, 0]
    air.weighting = Heterogeneity::Weighting::WholeRay;
    CHECK(std::abs(frame.of(ray_along_x(), air) - 1.0) < 1e-4);
    // 8 m in 3 steps: 1.5 of them are lit, the middles at x = -2.67 and 0 count 1 and 1/2.
    air = brighter_along_x();
    air.step_count = 3;
    CHECK(std::abs(frame.of(ray_along_x(), air) - (1.0 + (-8.0 / 3.0) / 1.5 / 4.0)) < 1e-3);
}

TEST_CASE("a ray that no light reaches is dark, and so is one without air") {
    std::vector<support::Part> parts{fog_box()};
    parts.push_back(
        {.mesh = support::square(), .world_from_object = glm::scale(support::translation({0, 0, 3}), vec3(20, 20, 1))});
    const Frame frame(support::make_scene(parts, {fog()}, {sun({0, 0, 1})}), std::array{ray_along_x()});
    CHECK(frame.of(ray_along_x(), noisy(64)) == double{dark_air});
    CHECK(frame.of({.origin = {-10, 0, 20}, .direction = {1, 0, 0}, .near_m = 0, .far_m = 50}, noisy(64)) ==
          double{dark_air});
}

TEST_CASE("against a march, suns, lamps and both: the light of several is the mean by their radiance") {
    struct Case {
        const char* name;
        std::vector<Light> lights;
        double error;
    };
    // A lamp's light loses in its step's medium on the whole way: right here, where fog is all around.
    for (const Case& check :
         {Case{"sun", {sun({0.3f, 0.1f, 1})}, 2e-3}, Case{"soft sun", {sun({0.3f, 0.1f, 1}, 0.2f)}, 2e-3},
          Case{"lamp", {lamp({1, 0.5f, 1.5f})}, 3e-3}, Case{"near lamp", {lamp({0.5f, 0.2f, 0.2f})}, 3e-3},
          Case{"ball", {lamp({1, 0.5f, 1.5f}, 0.4f)}, 3e-3},
          Case{"both", {sun({0.3f, 0.1f, 1}), lamp({-2, 0.5f, 0.7f})}, 3e-3}}) {
        CAPTURE(check.name);
        const Frame frame(support::make_scene(with_plates(), {fog()}, check.lights), std::array{ray_along_x()});
        for (const Heterogeneity& air : {brighter_along_x(), noisy(512)})
            CHECK(std::abs(frame.of(ray_along_x(), air) /
                               marched(frame, ray_along_x(), AirTexture(air, frame.progress), 2000) -
                           1.0) < check.error);
    }
}

TEST_CASE("steps converge, and those of a pixel's passes together are more steps") {
    const Frame frame(support::make_scene(with_plates(), {fog()}, {sun({0.3f, 0.1f, 1})}), std::array{ray_along_x()});
    const double truth = frame.of(ray_along_x(), noisy(4096));
    CHECK(std::abs(frame.of(ray_along_x(), noisy(1024)) / truth - 1.0) < 1e-3);
    CHECK(std::abs(frame.of(ray_along_x(), noisy(64)) / truth - 1.0) < 2e-2);
    double sum = 0.0;
    for (std::uint32_t pass = 0; pass < 16; ++pass)
        sum += frame.of(ray_along_x(), noisy(64), {pass, 16}) / 16;
    CHECK(std::abs(sum / truth - 1.0) < 5e-3);
}

TEST_CASE("over many rays the mean is 1, and each ray's bits are its own") {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    std::vector<ViewRay> rays;
    for (int ray = 0; ray < 3000; ++ray)
        rays.push_back(
            {.origin = vec3(-10, 0.1f, 0.2f),
             .direction = glm::normalize(vec3(10, 0, 0) + 2.0f * vec3(normal(random), normal(random), normal(random))),
             .near_m = 0.0f,
             .far_m = 100.0f});
    const Frame frame(support::make_scene(with_plates(), {fog()}, {sun({0.3f, 0.1f, 1})}), rays);
    Heterogeneity air = noisy(64);
    air.noise.scale_m = 0.2f;
    const AirTexture texture(air, frame.progress);
    const std::vector<float> all = frame.shafts.find_heterogeneity(rays, texture, frame.progress);
    double sum = 0.0, sum2 = 0.0, count = 0.0;
    for (const float value : all)
        if (value != dark_air)
            sum += double{value}, sum2 += double{value} * double{value}, ++count;
    REQUIRE(count > 1000);
    // Rays that share a feature are not independent: in the fog it is some 1 in 30 of a ray's features away.
    const double mean = sum / count, deviation = std::sqrt((sum2 / count - mean * mean) / (count / 30.0));
    CHECK(std::abs(mean - 1.0) < 4.0 * deviation);
    CHECK(deviation < 0.02);
    const std::vector<float> part =
        frame.shafts.find_heterogeneity(std::span(rays).subspan(701, 100), texture, frame.progress);
    for (std::size_t ray = 0; ray < part.size(); ++ray)
        REQUIRE(part[ray] == all[701 + ray]);
}
} // namespace heterogeneity_test
