// SPDX-License-Identifier: GPL-3.0-or-later
// The air of a whole picture, looked up in columns, against the same rays asked one by one with many steps.
#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "light_shafts/coarse_rows.hpp"
#include "light_shafts/light_shafts.hpp"
#include "light_shafts/slope_rows_visibility.hpp"
#include "support/soup.hpp"
#include "volume/air_texture.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace picture_air_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
constexpr std::uint32_t width = 160, height = 90;

/// Looks along y into fog of [-4, 4]^3.
Camera camera_before(CameraKind kind) {
    Camera camera{.kind = kind, .width_px = width, .height_px = height};
    camera.world_from_camera = glm::rotate(support::translation({0.3f, -9, 0.5f}), 1.5f, vec3(1, 0, 0));
    const float half_width = kind == CameraKind::Orthographic ? 5.0f : 0.6f;
    camera.window_right = half_width;
    camera.window_top = half_width * height / width;
    camera.window_left = -camera.window_right;
    camera.window_bottom = -camera.window_top;
    return camera;
}
std::vector<ViewRay> rays_of(const Camera& camera) {
    support::SceneRandom random(7);
    std::vector<float> far_m;
    for (int square = 0; square < 12 * 20; ++square)
        far_m.push_back(6.0f + 9.0f * random.uniform());
    std::vector<ViewRay> rays;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            const Ray ray = camera.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
            rays.push_back({ray.origin, ray.direction, 0.0f, far_m[y / 8 * 20 + x / 8]});
        }
    return rays;
}
std::unique_ptr<Scene> fog_with(std::vector<Light> lights, const Rgb& sigma_s = Rgb(0.1f)) {
    return support::make_scene(
        {{.mesh = support::cube(),
          .world_from_object = glm::scale(mat4(1.0f), vec3(4.0f)),
          .material = {.name = "fog", .medium_index = 0, .has_surface = false}},
         {.mesh = support::soup_mesh(300, {.min = vec3(-5, -5, -2), .max = vec3(5, 5, 6)}, 1.5f, 9)}},
        {{.name = "fog", .lobes = {{sigma_s, 0.0f}}}}, std::move(lights));
}
Light sun(const vec3& towards_light, float half_angle_rad = 0.0f) {
    return {.name = "Sun",
            .kind = LightKind::Sun,
            .strength = Rgb(2.0f),
            .towards_light = glm::normalize(towards_light),
            .half_angle_rad = half_angle_rad};
}
Heterogeneity noisy(std::uint32_t step_count) {
    return {.noise = {.scale_m = 2.0f, .resolution = 64}, .step_count = step_count};
}

struct Frame {
    Camera camera;
    std::vector<ViewRay> rays;
    std::unique_ptr<Scene> scene;
    Progress progress;
    Media media;
    Shafts shafts;
    std::vector<Rgb> radiance;

    Frame(std::unique_ptr<Scene> made, const Camera& looking, const Config& config = {.resolution = 4096})
        : camera(looking), rays(rays_of(camera)), scene(std::move(made)), media(*scene, progress),
          shafts(*scene, media, view_of(camera), rays, config, progress), radiance(rays.size()) {
        shafts.scatter(rays, radiance, {}, progress);
    }
    [[nodiscard]] std::vector<float> of_picture(const Heterogeneity& heterogeneity, Turn turn = {}) const {
        const AirTexture air(heterogeneity, progress);
        const auto picture = shafts.picture_air(camera, air, turn);
        REQUIRE(picture != nullptr);
        std::vector<float> found(rays.size(), dark_air);
        shafts.find_heterogeneity(rays, air, found, progress, turn, picture.get());
        return found;
    }
    [[nodiscard]] std::vector<float> one_by_one(const Heterogeneity& heterogeneity, Turn turn = {}) const {
        return shafts.find_heterogeneity(rays, AirTexture(heterogeneity, progress), progress, turn);
    }
    struct Error {
        double rms, bias; ///< Of the light, relative to its mean.
    };
    [[nodiscard]] Error error_of(const std::vector<float>& found, const std::vector<float>& truth) const {
        double error2 = 0.0, away = 0.0, sum = 0.0;
        for (std::size_t ray = 0; ray < rays.size(); ++ray) {
            if (truth[ray] == dark_air)
                continue;
            const double light = double{average(radiance[ray])};
            const double difference = light * (double{found[ray]} - double{truth[ray]});
            error2 += difference * difference;
            away += difference;
            sum += light * double{truth[ray]};
        }
        const auto count = static_cast<double>(rays.size());
        return {std::sqrt(error2 / count) / (sum / count), away / sum};
    }
};
} // namespace

TEST_CASE("a picture's rays find what they would find one by one, whatever camera, sun and instruction set") {
    struct Case {
        const char* name;
        CameraKind kind;
        std::vector<Light> lights;
        Rgb sigma_s;
    };
    for (const Case& check :
         {Case{"perspective", CameraKind::Perspective, {sun({0.3f, -0.2f, 1})}, Rgb(0.1f)},
          Case{"orthographic", CameraKind::Orthographic, {sun({0.3f, -0.2f, 1})}, Rgb(0.1f)},
          Case{"sun in the picture", CameraKind::Perspective, {sun({0.2f, 1, 0.15f})}, Rgb(0.1f)},
          Case{"soft sun", CameraKind::Perspective, {sun({0.3f, -0.2f, 1}, 0.05f)}, Rgb(0.1f)},
          Case{"two suns", CameraKind::Perspective, {sun({0.3f, -0.2f, 1}), sun({-1, 0.4f, 1})}, Rgb(0.1f)},
          Case{"dense, coloured", CameraKind::Perspective, {sun({0.3f, -0.2f, 1})}, Rgb(0.2f, 0.7f, 1.5f)}}) {
        CAPTURE(check.name);
        const Frame frame(fog_with(check.lights, check.sigma_s), camera_before(check.kind),
                          {.resolution = 4096, .light_samples = 4, .shares_strata = false});
        const std::vector<float> truth = frame.one_by_one(noisy(1024));
        std::vector<float> first;
        for (const SimdTarget target : available_simd_targets()) {
            const ForcedSimdTarget forced(target);
            CAPTURE(simd_target_name());
            const std::vector<float> found = frame.of_picture(noisy(64));
            const auto [rms, bias] = frame.error_of(found, truth);
            // Rays next to the sun cross few lines of their rows.
            const bool sees_sun = check.name == std::string("sun in the picture");
            CHECK(rms < (sees_sun ? 0.025 : 0.013));
            CHECK(std::abs(bias) < (sees_sun ? 0.004 : 0.002));
            if (first.empty())
                first = found;
            // Vectors of other lengths put other rays between two columns.
            CHECK(frame.error_of(found, first).rms < 0.003);
        }
    }
}

TEST_CASE("shafts thinner than a block of lines meet the air where they are, not its mean over the block") {
    auto scene = support::make_scene(
        {{.mesh = support::cube(),
          .world_from_object = glm::scale(mat4(1.0f), vec3(4.0f)),
          .material = {.name = "fog", .medium_index = 0, .has_surface = false}},
         {.mesh = support::soup_mesh(20000, {.min = vec3(-6, -6, 4.2f), .max = vec3(6, 6, 4.4f)}, 0.35f, 9)}},
        {{.name = "fog", .lobes = {{Rgb(0.1f), 0.0f}}}}, {sun({0.3f, -0.2f, 1})});
    const Frame frame(std::move(scene), camera_before(CameraKind::Perspective), {.resolution = 1024});
    Heterogeneity air = noisy(128);
    air.noise.scale_m = 2.0f;
    air.noise.contrast = 2.0f;
    const std::vector<float> found = frame.of_picture(air);
    air.step_count = 1024;
    const auto [rms, bias] = frame.error_of(found, frame.one_by_one(air));
    CHECK(rms < 0.012); // 0.020 with the mean over the block
    CHECK(std::abs(bias) < 0.004);
}

TEST_CASE("more steps come closer, and passes over the same pixels agree") {
    const Frame frame(fog_with({sun({0.3f, -0.2f, 1})}), camera_before(CameraKind::Perspective));
    const std::vector<float> truth = frame.one_by_one(noisy(1024));
    double before = 1.0;
    for (const std::uint32_t step_count : {4u, 16u, 64u}) {
        const double rms = frame.error_of(frame.of_picture(noisy(step_count)), truth).rms;
        CHECK(rms < 0.75 * before);
        before = rms;
    }
    // Their points lie elsewhere in the same steps, which are as coarse.
    for (std::uint32_t pass = 0; pass < 4; ++pass)
        CHECK(frame.error_of(frame.of_picture(noisy(64), {pass, 4}), truth).rms < 3.0 * before);
}

TEST_CASE("air that is even multiplies by its intensity: exactly 1, or a power of two, and dark rays stay dark") {
    const Frame frame(fog_with({sun({0.3f, -0.2f, 1})}), camera_before(CameraKind::Perspective));
    for (const float intensity : {1.0f, 4.0f}) {
        const std::vector<float> found = frame.of_picture({.amount = 0.0f, .intensity = intensity});
        int lit = 0;
        for (std::size_t ray = 0; ray < found.size(); ++ray)
            if (found[ray] != dark_air) {
                REQUIRE(found[ray] == intensity);
                ++lit;
            } else {
                REQUIRE(double{average(frame.radiance[ray])} < 1e-4);
            }
        CHECK(lit > 5000);
    }
}

TEST_CASE("painted air shows in a picture as it does to its rays") {
    const Frame frame(fog_with({sun({0.3f, -0.2f, 1})}), camera_before(CameraKind::Perspective));
    Heterogeneity air = noisy(64);
    air.amount = 0.3f;
    air.unit_from_scene = glm::inverse(support::translation({-2, -3, -3}) * glm::scale(mat4(1.0f), vec3(5, 6, 6)));
    air.painted = std::make_shared<const PaintedAir>(PaintedVolume{.size = {2, 1, 1}, .values = {-0.3f, 0.7f}},
                                                     PaintedVolume{.size = {1, 2, 1}, .values = {0.0f, 3.0f}},
                                                     PaintedVolume{.size = {1, 1, 2}, .values = {0.2f, 2.0f}});
    const std::vector<float> found = frame.of_picture(air);
    air.step_count = 1024;
    const auto [rms, bias] = frame.error_of(found, frame.one_by_one(air));
    CHECK(rms < 0.02);
    CHECK(std::abs(bias) < 0.004);
}

TEST_CASE("a picture's bits do not depend on threads") {
    const Frame frame(fog_with({sun({0.3f, -0.2f, 1})}), camera_before(CameraKind::Perspective));
    std::vector<float> one, many;
    with_threads(1, [&] { one = frame.of_picture(noisy(64)); });
    with_threads(4, [&] { many = frame.of_picture(noisy(64)); });
    CHECK(one == many);
}

TEST_CASE(
    "rays are asked one by one where a picture has no rows of a sun, or wants more steps than columns are worth") {
    const auto is_looked_up = [](std::vector<Light> lights, const Config& config, const Heterogeneity& air) {
        const Frame frame(fog_with(std::move(lights)), camera_before(CameraKind::Perspective), config);
        return frame.shafts.picture_air(frame.camera, AirTexture(air, frame.progress), {}) != nullptr;
    };
    const Light lamp{
        .name = "Lamp", .kind = LightKind::Point, .strength = Rgb(4.0f), .position = {0, 0, 1}, .radius_m = 0.0f};
    CHECK(is_looked_up({sun({0.3f, -0.2f, 1})}, {}, noisy(64)));
    CHECK_FALSE(is_looked_up({sun({0.3f, -0.2f, 1}), lamp}, {}, noisy(64)));
    CHECK_FALSE(is_looked_up({sun({0.3f, -0.2f, 1})}, {.method = Method::Exact}, noisy(64)));
    CHECK_FALSE(is_looked_up({sun({0.3f, -0.2f, 1})}, {}, noisy(512)));
    CHECK_FALSE(is_looked_up({}, {}, noisy(64)));
}

TEST_CASE("coarse rows are every so many lines of every so many rows, and their blocks know their least and largest") {
    const Frame frame(fog_with({sun({0.3f, -0.2f, 1})}), camera_before(CameraKind::Perspective));
    Progress progress;
    const auto visibility = make_epipolar(*frame.scene, view_of(frame.camera),
                                          LightSample{.towards_light = glm::normalize(vec3(0.3f, -0.2f, 1))},
                                          frame.rays, {.resolution = 1024}, progress);
    const auto* const from_rows = dynamic_cast<const RowsVisibility*>(visibility.get());
    REQUIRE(from_rows != nullptr);
    const slope_rows::Rows& rows = from_rows->rows();
    for (const std::int32_t stride : {1, 3, 4}) {
        CAPTURE(stride);
        const CoarseRows coarse = make_coarse_rows(rows, (rows.layout.line_count + stride - 1) / stride);
        REQUIRE(coarse.stride == stride);
        const std::int32_t count = (rows.layout.slice_count() + stride - 1) / stride;
        for (std::int32_t index = 0; index < count; ++index) {
            const auto fine = rows.row(std::min(index * stride + stride / 2, rows.layout.slice_count() - 1));
            const auto row = coarse.row(index);
            REQUIRE(row.first * stride <= fine.first);
            REQUIRE(row.end * stride >= fine.end);
            for (std::int32_t line = row.first; line < row.end; ++line) {
                const std::int32_t of_fine = line * stride + stride / 2;
                const std::int32_t block = (line - row.first) / slope_rows::block_lines;
                const float slope = row.slopes[line - row.first];
                if (fine.first <= of_fine && of_fine < fine.end)
                    REQUIRE(slope == fine.slopes[of_fine - fine.first]);
                REQUIRE(row.lowest[block] <= slope);
                REQUIRE(slope <= row.highest[block]);
            }
        }
    }
}
} // namespace picture_air_test
