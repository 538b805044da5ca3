// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes of a textured sun: a white texture gives the untextured radiance, a linear one the exact integral, and what
// changes within a step errs as the midpoint rule does.
#include "light_shafts/texture_steps.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <numeric>

namespace texture_steps_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
constexpr PlanarPlacement placement{
    .u_per_m = {0.4f, 0.0f, 0.0f}, .v_per_m = {0.0f, 0.3f, 0.1f}, .uv_at_origin = {0.2f, 0.7f}};
const ViewRay ray{.origin = {1, 2, 3}, .direction = glm::normalize(vec3(1, 2, -2)), .near_m = 0.5f, .far_m = 14.0f};
/// Two pieces, the depth of one of them falling in one channel, and lit intervals that cross the seam, one of them tinted.
const std::vector<ScatterPiece> pieces{{.near_m = 0.5f,
                                        .far_m = 6.0f,
                                        .source_per_m = {1, 2, 3},
                                        .depth_at_near = {2, 0.1f, 0},
                                        .depth_per_m = {-0.2f, 1e-7f, 1}},
                                       {.near_m = 6.0f,
                                        .far_m = 14.0f,
                                        .source_per_m = Rgb(0.5f),
                                        .depth_at_near = {1, 0.1f, 5.5f},
                                        .depth_per_m = Rgb(0.05f)}};
const std::vector<LitInterval> lit{{.near_m = 1.0f, .far_m = 2.5f},
                                   {.near_m = 4.0f, .far_m = 9.0f, .transmittance = {0.5f, 1.0f, 0.25f}},
                                   {.near_m = 9.5f, .far_m = 20.0f}};

std::vector<TextureStep> steps_of(float step_m) {
    std::vector<TextureStep> steps;
    append_texture_steps(ray, pieces, lit, placement, step_m, steps);
    return steps;
}
/// In double: thousands of steps would drift in float.
template <class Texture>
dvec3 sum_of(const std::vector<TextureStep>& steps, const Texture& texture) {
    return std::accumulate(steps.begin(), steps.end(), dvec3(0.0), [&](const dvec3& sum, const TextureStep& step) {
        return sum + dvec3(step.weight) * double{texture(step.uv)};
    });
}
/// The lit parts' radiance by Gauss's two points in 1,024 parts, in double.
template <class Texture>
dvec3 integral(const Texture& texture) {
    dvec3 sum(0.0);
    for (const ScatterPiece& piece : pieces)
        for (const LitInterval& interval : lit) {
            const double near_m = std::max(piece.near_m, interval.near_m),
                         far_m = std::min(piece.far_m, interval.far_m);
            constexpr int parts = 1024;
            const double part_m = (far_m - near_m) / parts;
            for (int point = 0; near_m < far_m && point < 2 * parts; ++point) {
                const double at_m = near_m + part_m * (point / 2 + 0.5 + (point % 2 - 0.5) / std::sqrt(3.0));
                const dvec3 depth = dvec3(piece.depth_at_near) + (at_m - piece.near_m) * dvec3(piece.depth_per_m);
                const double share = texture(placement.uv(ray.origin + static_cast<float>(at_m) * ray.direction));
                sum += dvec3(interval.transmittance * piece.source_per_m) * glm::exp(-depth) * (0.5 * part_m * share);
            }
        }
    return sum;
}
double relative_error(const dvec3& sum, const dvec3& expected) {
    const dvec3 error = glm::abs(sum / expected - 1.0);
    return std::max({error.x, error.y, error.z});
}
} // namespace

TEST_CASE("under a white texture the nodes add up to the untextured radiance, however long the steps are") {
    const dvec3 expected = integral([](vec2) { return 1.0; });
    for (const float step_m : {100.0f, 1.0f, 0.03f, 1e-3f}) {
        CAPTURE(step_m);
        CHECK(relative_error(sum_of(steps_of(step_m), [](vec2) { return 1.0f; }), expected) < 2e-6);
    }
}
// Seen to fail with the node in the middle of its step: 0.4 % at 100 m.
TEST_CASE("a texture that is linear along the ray has no error, whatever the optical depth of a step") {
    const std::vector<ScatterPiece> grey{
        {.near_m = 0.5f, .far_m = 14.0f, .source_per_m = Rgb(1), .depth_per_m = Rgb(0.7f)}};
    const LitInterval whole{.near_m = 0.5f, .far_m = 14.0f};
    const auto texture = [](vec2 uv) { return 1.0f + uv.x; };
    const auto sum = [&](float step_m) {
        std::vector<TextureStep> steps;
        append_texture_steps(ray, grey, {&whole, 1}, placement, step_m, steps);
        return sum_of(steps, texture).x;
    };
    CHECK(std::abs(sum(100.0f) / sum(1e-3f) - 1.0) < 1e-6);
    CHECK(std::abs(sum(1.0f) / sum(1e-3f) - 1.0) < 1e-6);
}
TEST_CASE("what bends within a step errs as a midpoint rule: a quarter at half the step") {
    const auto texture = [](vec2 uv) { return 1.0f + std::sin(9.0f * uv.x); };
    const dvec3 expected = integral(texture);
    const double at_40_cm = relative_error(sum_of(steps_of(0.4f), texture), expected);
    const double at_20_cm = relative_error(sum_of(steps_of(0.2f), texture), expected);
    CHECK(at_40_cm < 0.01);
    CHECK(at_20_cm < 0.3 * at_40_cm);
}
TEST_CASE("nodes lie in the lit parts of the ray, and no step is longer than was asked for") {
    const std::vector<TextureStep> steps = steps_of(0.25f);
    CHECK(steps.size() == 6 + 8 + 12 + 18); // 1.5, 2, 3 and 4.5 m
    for (const TextureStep& step : steps) {
        const float at_m = (step.uv.x - placement.uv(ray.origin).x) / placement.uv_per_m(ray.direction).x;
        CHECK(std::any_of(lit.begin(), lit.end(), [&](const LitInterval& part) {
            return part.near_m < at_m && at_m < std::min(part.far_m, ray.far_m);
        }));
    }
}
TEST_CASE("the place of the mean is exact for any depth, and has no seam") {
    for (const double depth : {-30.0, -1.0, -0.1001, -0.0999, -1e-4, 0.0, 1e-4, 0.0999, 0.1001, 1.0, 30.0, 700.0}) {
        CAPTURE(depth);
        double weight = 0.0, moment = 0.0;
        constexpr int parts = 1 << 16;
        for (int part = 0; part < parts; ++part) {
            const double at = (part + 0.5) / parts, here = std::exp(-depth * at);
            weight += here, moment += here * at;
        }
        CHECK(std::abs(mean_place(static_cast<float>(depth)) - moment / weight) <
              1e-6 + 1e-5 * std::abs(moment / weight));
    }
}
} // namespace texture_steps_test
