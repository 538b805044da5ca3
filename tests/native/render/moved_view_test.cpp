// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/moved_view.hpp"
#include "render/pixel_samples.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>
#include <random>

namespace moved_view_test {
using namespace tyndall;
using namespace tyndall::render;
using namespace tyndall::support;

/// Whether a line from `origin` on meets the box, in double precision.
static bool meets(const Bounds3& box, const Ray& ray) {
    double near_m = 0.0, far_m = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double per_direction = 1.0 / static_cast<double>(ray.direction[axis]);
        const double to_min =
            (static_cast<double>(box.min[axis]) - static_cast<double>(ray.origin[axis])) * per_direction;
        const double to_max =
            (static_cast<double>(box.max[axis]) - static_cast<double>(ray.origin[axis])) * per_direction;
        near_m = std::max(near_m, std::min(to_min, to_max));
        far_m = std::min(far_m, std::max(to_min, to_max));
    }
    return near_m <= far_m;
}

TEST_CASE("no ray of a pixel outside of the rectangle meets the box, before, beside, behind and around the camera") {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> one(-1.0f, 1.0f);
    const auto any = [&] { return vec3(one(random), one(random), one(random)); };
    std::size_t seen = 0, left_out = 0, empty = 0;
    for (int trial = 0; trial < 300; ++trial) {
        Camera camera{.kind = trial % 3 == 0 ? CameraKind::Orthographic : CameraKind::Perspective,
                      .world_from_camera = translation(any()) * glm::rotate(mat4(1.0f), 3.0f * one(random), any()),
                      .window_left = -0.7f,
                      .window_right = 0.5f,
                      .window_bottom = -0.3f,
                      .window_top = 0.6f,
                      .width_px = 24,
                      .height_px = 17};
        Bounds3 box;
        const vec3 centre = 3.0f * any(), half = vec3(0.01f) + glm::abs(any());
        box.grow(centre - half);
        box.grow(centre + half);
        const float reach_px = trial % 2 == 0 ? 0.0f : 2.0f;
        const Region shown = pixels_that_may_see(box, camera, reach_px);
        empty += shown.x0 == shown.x1 ? 1 : 0;
        for (std::uint32_t y = 0; y < camera.height_px; ++y)
            for (std::uint32_t x = 0; x < camera.width_px; ++x) {
                const bool is_shown = shown.x0 <= x && x < shown.x1 && shown.y0 <= y && y < shown.y1;
                left_out += is_shown ? 0 : 1;
                for (int sample = 0; sample < 8; ++sample) {
                    const bool is_seen = meets(box, pixel_ray(camera, x, y, reach_px * vec2(one(random), one(random))));
                    seen += is_seen ? 1 : 0;
                    if (is_seen)
                        CHECK(is_shown);
                }
            }
    }
    CHECK(seen > 10000);
    CHECK(left_out > 10000);
    CHECK(empty > 10);
}
} // namespace moved_view_test
