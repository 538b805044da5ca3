// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "core/sobol.hpp"
#include "scene/camera.hpp"
#include "support/close_to.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <numbers>

namespace camera_test {
using namespace tyndall;
using tyndall::support::close_to;

static Camera camera(CameraKind kind) {
    Camera result{.kind = kind};
    result.world_from_camera = glm::rotate(glm::translate(mat4(1.0f), vec3(1, 2, 3)), 0.5f, vec3(0, 0, 1));
    result.window_left = -1.0f, result.window_right = 3.0f; // shifted to the right
    result.window_bottom = -1.0f, result.window_top = 1.0f;
    result.clip_near_m = 2.0f, result.clip_far_m = 50.0f;
    result.width_px = 400, result.height_px = 200;
    return result;
}
static vec3 in_camera(const Camera& camera, const vec3& point) {
    return vec3(glm::inverse(camera.world_from_camera) * vec4(point, 1.0f));
}

TEST_CASE("the raster's corners are the window's: (0, 0) is the lower left, and y rises") {
    for (const CameraKind kind : {CameraKind::Perspective, CameraKind::Orthographic}) {
        const Camera c = camera(kind);
        const auto at_one_metre = [&](float x_px, float y_px) {
            const Ray ray = c.ray(x_px, y_px);
            const float per_depth = -1.0f / (glm::inverse(glm::mat3(c.world_from_camera)) * ray.direction).z;
            return in_camera(c, ray.origin + per_depth * ray.direction);
        };
        CHECK(glm::distance(at_one_metre(0, 0), vec3(-1, -1, -1)) < 2e-6f);
        CHECK(glm::distance(at_one_metre(400, 200), vec3(3, 1, -1)) < 2e-6f);
        CHECK(glm::distance(at_one_metre(100, 150), vec3(0, 0.5f, -1)) < 2e-6f);
    }
}
TEST_CASE("clipping is a plane, as in Cycles: the same depth along -Z in the corner and in the middle") {
    for (const CameraKind kind : {CameraKind::Perspective, CameraKind::Orthographic}) {
        const Camera c = camera(kind);
        for (const float x_px : {0.0f, 100.0f, 400.0f}) {
            const Ray ray = c.ray(x_px, 3.0f);
            CHECK(std::abs(glm::length(ray.direction) - 1.0f) < 2e-7f);
            CHECK(std::abs(in_camera(c, ray.origin + ray.near_m * ray.direction).z + 2.0f) < 1e-5f);
            CHECK(std::abs(in_camera(c, ray.origin + ray.far_m * ray.direction).z + 50.0f) < 1e-4f);
        }
    }
}
TEST_CASE("an orthographic view that clips behind itself begins there, with a range from 0") {
    Camera c = camera(CameraKind::Orthographic);
    c.clip_near_m = -50.0f;
    const Ray ray = c.ray(7, 9);
    CHECK(ray.near_m == 0.0f);
    CHECK(ray.far_m == 100.0f);
    CHECK(std::abs(in_camera(c, ray.origin).z - 50.0f) < 1e-5f);
}

static Camera panorama(float left, float right, float bottom, float top) {
    Camera result = camera(CameraKind::Panoramic);
    result.window_left = left, result.window_right = right;
    result.window_bottom = bottom, result.window_top = top;
    return result;
}
TEST_CASE("a panorama's middle is ahead, its right a quarter turn further, its upper edge above") {
    const Camera c = panorama(-pi, pi, -0.5f * pi, 0.5f * pi);
    const auto direction = [&](float x_px, float y_px) {
        const Ray ray = c.ray(x_px, y_px);
        return in_camera(c, ray.origin + ray.direction);
    };
    CHECK(glm::distance(direction(200, 100), vec3(0, 0, -1)) < 1e-6f);
    CHECK(glm::distance(direction(300, 100), vec3(1, 0, 0)) < 1e-6f);
    CHECK(glm::distance(direction(100, 100), vec3(-1, 0, 0)) < 1e-6f);
    CHECK(glm::distance(direction(0, 100), vec3(0, 0, 1)) < 1e-6f);
    CHECK(glm::distance(direction(77, 200), vec3(0, 1, 0)) < 1e-6f);
    CHECK(glm::distance(direction(300, 150), vec3(std::sqrt(0.5f), std::sqrt(0.5f), 0)) < 1e-6f);
    CHECK(c.ray(5, 5).near_m == 2.0f); // along the ray
    CHECK(c.depth_m(c.position() + 3.0f * c.ray(9, 13).direction) == close_to(3.0f, 1e-5));
}
TEST_CASE("a point shows where the ray through it is, in every kind of camera") {
    for (const Camera& c :
         {camera(CameraKind::Perspective), camera(CameraKind::Orthographic), panorama(-pi, pi, -0.5f * pi, 0.5f * pi),
          panorama(2.0f, 2.0f + 2.0f * pi, -1.0f, 1.0f), panorama(1.0f, -2.0f, -1.0f, 0.5f)})
        for (const vec2 place_px : {vec2(3, 5), vec2(200, 100), vec2(390, 180)}) {
            const Ray ray = c.ray(place_px.x, place_px.y);
            const std::optional<vec2> found = c.raster_position(ray.origin + 7.0f * ray.direction);
            REQUIRE(found);
            CHECK(glm::distance(*found, place_px) < 2e-3f);
        }
    CHECK(!camera(CameraKind::Perspective).raster_position(vec3(1, 2, 9)));
}
TEST_CASE("all rays of a pixel through the lens meet in focus, and cover a disc as large as the aperture elsewhere") {
    for (const CameraKind kind : {CameraKind::Perspective, CameraKind::Orthographic}) {
        Camera c = camera(kind);
        c.lens = {.radius_m = 0.25f, .focus_m = 8.0f};
        const Ray sharp = c.ray(30, 120);
        const auto at_depth = [&](const Ray& ray, float depth_m) {
            const vec3 from = in_camera(c, ray.origin), to = in_camera(c, ray.origin + ray.direction);
            return vec2(from + (depth_m + from.z) / (from.z - to.z) * (to - from));
        };
        float largest_m = 0.0f;
        for (const vec2 u : {vec2(0.999999f, 0.1f), vec2(0.3f, 0.6f), vec2(0.999999f, 0.9f)}) {
            const Ray ray = c.through_lens(sharp, u);
            CHECK(std::abs(glm::length(ray.direction) - 1.0f) < 1e-6f);
            CHECK(glm::distance(at_depth(ray, 8.0f), at_depth(sharp, 8.0f)) < 2e-5f);
            CHECK(std::abs(in_camera(c, ray.origin + ray.near_m * ray.direction).z + 2.0f) < 1e-5f);
            // Twice as far as the focus the aperture is seen again, upside down.
            largest_m = std::max(largest_m, glm::distance(at_depth(ray, 16.0f), at_depth(sharp, 16.0f)));
            // Equal depth on both.
            const vec3 there = ray.origin + 20.0f * ray.direction,
                       here = sharp.origin + 20.0f * c.sharp_per_blurred_m(sharp, ray) * sharp.direction;
            CHECK(c.depth_m(there) == close_to(c.depth_m(here), 1e-5));
        }
        CHECK(largest_m == close_to(0.25f, 1e-3));
    }
}
TEST_CASE("what the air is seen by has the rays through a place on the lens") {
    Camera c = camera(CameraKind::Perspective);
    for (const std::uint32_t blades : {0u, 5u})
        for (const vec2 u : {vec2(0.0f, 0.0f), vec2(0.9f, 0.2f), vec2(0.4f, 0.7f)}) {
            c.lens = {.radius_m = 0.25f,
                      .focus_m = 3.0f,
                      .blades = blades,
                      .rotation_rad = 0.3f,
                      .inverse_ratio = 0.7f,
                      .air_u = u};
            const Camera pinhole = c.of_air();
            CHECK(pinhole.lens.is_pinhole());
            for (const vec2 at_px : {vec2(30, 120), vec2(0, 0), vec2(131, 57)}) {
                const Ray sharp = c.ray(at_px.x, at_px.y), expected = c.through_lens(sharp, u),
                          found = pinhole.ray(at_px.x, at_px.y);
                CHECK(glm::distance(found.origin, expected.origin) < 1e-6f);
                CHECK(glm::distance(found.direction, expected.direction) < 1e-6f);
                CHECK(found.near_m == close_to(expected.near_m, 1e-5));
                CHECK(found.far_m == close_to(expected.far_m, 1e-5));
                const vec3 in_focus = sharp.origin + 3.0f / glm::dot(sharp.direction, c.forward()) * sharp.direction;
                CHECK(glm::distance(*pinhole.raster_position(in_focus), at_px) < 0.01f);
            }
        }
    c.lens.air_u.reset();
    CHECK(c.of_air().window_left == c.window_left);
    CHECK(c.of_air().world_from_camera == c.world_from_camera);
    for (const auto& [kind, u] : {std::pair(CameraKind::Orthographic, vec2(0.5f)),
                                  {CameraKind::Perspective, vec2(1.0f)},
                                  {CameraKind::Perspective, vec2(-0.1f, 0.0f)}}) {
        Camera bad = camera(kind);
        bad.lens = {.radius_m = 0.25f, .air_u = u};
        CHECK_THROWS_AS(require_usable(bad), InvalidInput);
    }
}
TEST_CASE("places on an aperture are spread evenly over its disc or polygon") {
    constexpr int side = 64;
    for (const std::uint32_t blades : {0u, 3u, 5u, 8u}) {
        const Lens lens{.radius_m = 2.0f, .blades = blades, .rotation_rad = 0.4f, .inverse_ratio = 1.0f};
        dvec2 sum(0.0);
        double squares = 0.0;
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j) {
                const vec2 at = lens.sample_m((vec2(i, j) + 0.5f) / static_cast<float>(side));
                CHECK(glm::length(at) <= 2.0f);
                sum += dvec2(at);
                squares += glm::dot(at, at);
            }
        CHECK(glm::length(sum) / (side * side) < 0.03); // 64 is no multiple of 3 and 5
        // The mean square distance from the centre: r^2 / 2 of a disc, r^2 (2 + cos(2 pi / n)) / 6 of a polygon.
        const double expected = 4.0 * (blades < 3 ? 0.5 : (2.0 + std::cos(2.0 * std::numbers::pi / blades)) / 6.0);
        CHECK(squares / (side * side) == close_to(expected, 0.005));
    }
    const Lens wide{.radius_m = 2.0f, .inverse_ratio = 0.5f};
    CHECK(std::abs(wide.sample_m({0.999999f, 0.0f}).x) == close_to(1.0f, 1e-5));
}
TEST_CASE("what leaves a lens as near as it may focus goes ahead, and its range begins at 0 or later") {
    Camera close = camera(CameraKind::Perspective);
    close.clip_near_m = 0.1f;
    close.lens = {.radius_m = 1000.0f, .focus_m = 0.2f};
    require_usable(close);
    for (std::uint32_t i = 0; i < 4096; ++i) {
        const Ray sharp = close.ray(50.0f * static_cast<float>(i % 9), 100.0f);
        const Ray ray = close.through_lens(sharp, sobol_point(i, 1));
        CHECK(glm::dot(ray.direction, close.forward()) > 0.0f);
        CHECK(ray.near_m >= 0.0f);
    }
}
// Debian's Embree asserts that rays are valid: one that is not ends the whole process.
TEST_CASE("a camera whose rays would not be finite is refused") {
    for (const float bad : {NAN, INFINITY, 3.4e38f}) {
        Camera lost = camera(CameraKind::Perspective);
        lost.world_from_camera[3].y = bad;
        CHECK_THROWS_AS(require_usable(lost), InvalidInput);
        Camera wide = camera(CameraKind::Orthographic);
        wide.window_right = bad;
        CHECK_THROWS_AS(require_usable(wide), InvalidInput);
    }
    Camera flat = camera(CameraKind::Perspective);
    flat.world_from_camera[0] *= 0.0f;
    CHECK_THROWS_AS(require_usable(flat), InvalidInput);
    Camera blurred = camera(CameraKind::Perspective);
    blurred.lens = {.radius_m = 0.1f, .focus_m = 0.0f};
    CHECK_THROWS_AS(require_usable(blurred), InvalidInput);
    blurred.lens = {.radius_m = NAN, .focus_m = 1.0f};
    CHECK_THROWS_AS(require_usable(blurred), InvalidInput);
    blurred.lens = {.radius_m = 2500.0f, .focus_m = 0.2f};
    CHECK_THROWS_AS(require_usable(blurred), InvalidInput);
    blurred.lens = {.radius_m = 25.0f, .focus_m = 0.2f, .inverse_ratio = 100.0f};
    CHECK_THROWS_AS(require_usable(blurred), InvalidInput);
    CHECK_NOTHROW(require_usable(camera(CameraKind::Perspective)));
}
} // namespace camera_test
