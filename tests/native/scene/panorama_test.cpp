// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/camera.hpp"
#include "support/close_to.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

namespace panorama_test {
using namespace tyndall;
using tyndall::support::close_to;

struct Shown {
    std::string name;
    Panorama panorama;
    vec2 low, high; ///< Of the window.
};

/// Of each kind one that looks all around, and one that is cut, shifted or mirrored.
static const std::vector<Shown>& all_kinds() {
    using Kind = PanoramaKind;
    const float quarter = 0.25f * pi;
    static const std::vector<Shown> kinds{
        {"equirectangular", {}, vec2(-pi, -0.5f * pi), vec2(pi, 0.5f * pi)},
        {"equirectangular, beyond half a turn", {}, vec2(2.0f, -1.0f), vec2(8.0f, 1.0f)},
        {"equidistant", {.kind = Kind::FisheyeEquidistant, .rim = 3.0f}, vec2(-3.0f), vec2(3.0f)},
        {"equidistant, shifted", {.kind = Kind::FisheyeEquidistant, .rim = 1.2f}, vec2(-2.0f, 0), vec2(0.5f, 1.2f)},
        {"equisolid", {.kind = Kind::FisheyeEquisolid, .rim = 0.99f}, vec2(-1.0f, -0.7f), vec2(1.0f, 0.7f)},
        {"equisolid, mirrored", {.kind = Kind::FisheyeEquisolid, .rim = 0.5f}, vec2(0.6f, -0.4f), vec2(-0.6f, 0.4f)},
        {"polynomial",
         {.kind = Kind::FisheyePolynomial, .rim = 2.0f, .angle_by_radius = {1e-5f, 0.05f, 1e-4f, -3e-6f, 3e-8f}},
         vec2(-18.0f, -12.0f),
         vec2(18.0f, 12.0f)},
        {"polynomial that looks aside in its middle",
         {.kind = Kind::FisheyePolynomial, .rim = 1.5f, .angle_by_radius = {0.2f, 0.06f, 0, 0, 0}},
         vec2(-18.0f, -12.0f),
         vec2(18.0f, 12.0f)},
        {"polynomial that looks to the other side",
         {.kind = Kind::FisheyePolynomial, .rim = 1.5f, .angle_by_radius = {0.5f, -0.1f, 0, 0, 0}},
         vec2(-15.0f, -12.0f),
         vec2(15.0f, 12.0f)},
        {"polynomial that turns back",
         {.kind = Kind::FisheyePolynomial, .rim = 1.5f, .angle_by_radius = {0, 0.15f, -5e-3f, 0, 0}},
         vec2(-18.0f, -12.0f),
         vec2(18.0f, 12.0f)},
        {"mirror ball", {.kind = Kind::MirrorBall, .rim = 1.0f}, vec2(-1.0f), vec2(1.0f)},
        {"cube face", {.kind = Kind::EquiangularCubemapFace}, vec2(-quarter), vec2(quarter)},
        {"cube face, shifted", {.kind = Kind::EquiangularCubemapFace}, vec2(0.6f, -1.0f), vec2(2.2f, 0.6f)},
        {"cylinder", {.kind = Kind::CentralCylindrical}, vec2(-pi, -1.0f), vec2(pi, 1.0f)},
        {"cylinder, beyond half a turn", {.kind = Kind::CentralCylindrical}, vec2(2.5f, -0.2f), vec2(5.0f, 3.0f)}};
    return kinds;
}

/// visit(at, direction) for places all over the window that have one.
template <typename Visit>
static void for_places(const Shown& shown, const Visit& visit) {
    constexpr int side = 23;
    int count = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const vec2 at = glm::mix(shown.low, shown.high, (vec2(x, y) + vec2(0.37f, 0.61f)) / float{side});
            if (const auto direction = shown.panorama.direction(at)) {
                visit(at, glm::normalize(*direction));
                ++count;
            }
        }
    CHECK(count > side * side / 3);
}

static float angle_from_ahead(const vec3& direction) {
    return std::atan2(std::hypot(direction.x, direction.y), -direction.z);
}

/// Two places may show the same.
static bool is_unique(const Shown& shown) {
    return shown.name != "polynomial that looks to the other side" && shown.name != "polynomial that turns back";
}

// Seen to fail with Newton's steps alone: they end on the wrong side of the middle.
TEST_CASE("a panorama shows each direction where it looks that way") {
    for (const Shown& shown : all_kinds()) {
        CAPTURE(shown.name);
        const float unit = glm::length(shown.high - shown.low);
        for_places(shown, [&](const vec2& at, const vec3& direction) {
            const auto place = shown.panorama.place(2.5f * direction, shown.low, shown.high);
            REQUIRE(place);
            const auto there = shown.panorama.direction(*place);
            CHECK((!is_unique(shown) || glm::distance(*place, at) < 2e-4f * unit));
            CHECK((!there || glm::distance(glm::normalize(*there), direction) < 0.02f)); // a ball is steep at its rim
        });
    }
}
TEST_CASE("a panorama's directions turn by as much as it says from place to place") {
    for (const Shown& shown : all_kinds()) {
        CAPTURE(shown.name);
        if (!is_unique(shown))
            continue; // nor is how it turns
        const vec2 step = 1e-3f * glm::abs(shown.high - shown.low);
        for_places(shown, [&](const vec2& at, const vec3& direction) {
            const vec2 turns = shown.panorama.turns(direction);
            for (int axis = 0; axis < 2; ++axis) {
                vec2 aside(0.0f);
                aside[axis] = 0.5f * step[axis];
                const auto before = shown.panorama.direction(at - aside), after = shown.panorama.direction(at + aside);
                if (!before || !after || (shown.panorama.kind == PanoramaKind::MirrorBall && glm::length(at) > 0.95f))
                    continue; // the rim passes here; or a step turns without bound
                const float turned = glm::distance(glm::normalize(*before), glm::normalize(*after)) / step[axis];
                CHECK(std::abs(turns[axis] - turned) < 0.01f * turned + 1e-4f);
            }
        });
    }
}
TEST_CASE("fisheyes keep angles, or areas") {
    const Panorama equidistant{.kind = PanoramaKind::FisheyeEquidistant, .rim = 3.1f};
    const Panorama equisolid{.kind = PanoramaKind::FisheyeEquisolid, .rim = 1.0f};
    for (const float angle_rad : {0.0f, 1e-3f, 0.3f, 1.5f, 2.0f, 3.0f})
        for (const vec2 unit : {vec2(1, 0), vec2(0, -1), vec2(0.6f, 0.8f)}) {
            CAPTURE(angle_rad);
            const vec3 there(std::sin(angle_rad) * unit, -std::cos(angle_rad));
            CHECK(glm::distance(*equidistant.direction(angle_rad * unit), there) < 1e-6f);
            CHECK(glm::distance(*equisolid.direction(std::sin(0.5f * angle_rad) * unit), there) < 1e-6f);
        }
    CHECK(!equidistant.direction({3.0f, 0.9f}));
    CHECK(!equisolid.direction({0.8f, 0.7f}));
}
TEST_CASE("a mirror ball shows what its surface mirrors") {
    const Panorama ball{.kind = PanoramaKind::MirrorBall, .rim = 1.0f};
    const vec3 to_eye(0, 0, -1);
    for (const vec2 at : {vec2(0), vec2(0.3f, -0.8f), vec2(-0.9f, 0.1f), vec2(0, 0.999f)}) {
        const vec3 normal(at, -std::sqrt(1.0f - glm::dot(at, at)));
        CHECK(glm::distance(*ball.direction(at), 2.0f * glm::dot(normal, to_eye) * normal - to_eye) < 1e-6f);
    }
    CHECK(!ball.direction({0.8f, 0.61f}));
}
TEST_CASE("a cube's face ends at its corners, and a cylinder's heights are slopes") {
    const Panorama face{.kind = PanoramaKind::EquiangularCubemapFace},
        cylinder{.kind = PanoramaKind::CentralCylindrical};
    CHECK(glm::distance(*face.direction(vec2(0.25f * pi)), vec3(1, 1, -1)) < 1e-6f);
    CHECK(angle_from_ahead(*face.direction({0.3f, 0.0f})) == close_to(0.3f, 1e-5));
    CHECK(glm::distance(*cylinder.direction({0.5f * pi, 2.0f}), vec3(1, 2, 0)) < 1e-6f);
    CHECK(!cylinder.place({0, 1, 0}, vec2(-pi), vec2(pi)));
    CHECK(!face.place({0.1f, 0, 1}, vec2(-1), vec2(1)));
}
TEST_CASE("a lens polynomial ends at an angle, and the middle of one that looks aside is above") {
    const Panorama lens{.kind = PanoramaKind::FisheyePolynomial, .rim = 1.0f, .angle_by_radius = {0.2f, 0.1f, 0, 0, 0}};
    CHECK(angle_from_ahead(*lens.direction({7.9f, 0})) == close_to(0.99f, 1e-5));
    CHECK(!lens.direction({8.1f, 0}));
    CHECK(glm::distance(*lens.direction({0, 0}), vec3(0, std::sin(0.2f), -std::cos(0.2f))) < 1e-6f);
    for (const float aside_rad : {1e-5f, -1e-5f}) { // as Blender's default has it; ahead is not quite in the middle
        const Panorama usual{
            .kind = PanoramaKind::FisheyePolynomial, .rim = 1.0f, .angle_by_radius = {aside_rad, 0.02f, 0, 0, 0}};
        CHECK(glm::distance(usual.turns({0, 0, -1}), vec2(0.02f)) < 1e-4f);
    }
    Panorama steep = lens;
    steep.rim = std::numeric_limits<float>::infinity();
    steep.angle_by_radius[4] = 1e30f;
    CHECK(!steep.direction({1e6f, 0})); // whose angle is not finite
}
TEST_CASE("beside a fisheye's circle a camera has no ray, nor through any place of its lens") {
    const Camera camera{.kind = CameraKind::Panoramic,
                        .world_from_camera = glm::translate(mat4(1.0f), vec3(1, 2, 3)),
                        .window_left = -1.0f,
                        .window_right = 1.0f,
                        .window_bottom = -1.0f,
                        .window_top = 1.0f,
                        .width_px = 100,
                        .height_px = 100,
                        .lens = {.radius_m = 0.1f},
                        .panorama = {.kind = PanoramaKind::FisheyeEquidistant, .rim = 1.0f}};
    CHECK(camera.ray(50, 99).exists());
    const Ray none = camera.ray(90, 90);
    CHECK(!none.exists());
    CHECK(!camera.through_lens(none, {0.3f, 0.7f}).exists());
    CHECK(std::abs(glm::length(none.direction) - 1.0f) < 1e-6f);
    const Ray at_rim = camera.ray_or_rim(90, 90);
    CHECK(at_rim.exists());
    CHECK(angle_from_ahead(at_rim.direction) == close_to(1.01f, 1e-5));
    const auto beyond = camera.raster_position(camera.position() + vec3(1, 1, -0.2f)); // motion vectors lead there
    REQUIRE(beyond);
    CHECK(!camera.ray(beyond->x, beyond->y).exists());
}
} // namespace panorama_test
