// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "scene/camera.hpp"
#include <cmath>
#include <doctest/doctest.h>

using namespace tyndall;

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
    CHECK_NOTHROW(require_usable(camera(CameraKind::Perspective)));
}
