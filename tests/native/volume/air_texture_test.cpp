// SPDX-License-Identifier: GPL-3.0-or-later
// What the texture of the air is at a point, and its mean along a ray, against closed forms.
#include "core/errors.hpp"
#include "core/simd.hpp"
#include "support/close_to.hpp"
#include "volume/air_texture.hpp"
#include <doctest/doctest.h>
#include <random>

namespace air_texture_test {
using namespace tyndall;
using tyndall::support::close_to;

namespace {
PaintedVolume volume_of(std::array<std::uint32_t, 3> size, const auto& value_at) {
    PaintedVolume volume{.size = size, .values = {}};
    for (std::uint32_t z = 0; z < size[2]; ++z)
        for (std::uint32_t y = 0; y < size[1]; ++y)
            for (std::uint32_t x = 0; x < size[0]; ++x)
                volume.values.push_back(value_at(x, y, z));
    return volume;
}
PaintedVolume constant(float value) {
    return volume_of({3, 2, 4}, [=](auto...) { return value; });
}
std::shared_ptr<const PaintedAir> painted(PaintedVolume amount, PaintedVolume level, PaintedVolume intensity) {
    return std::make_shared<const PaintedAir>(std::move(amount), std::move(level), std::move(intensity));
}
AirTexture texture_of(Heterogeneity heterogeneity) {
    heterogeneity.noise.resolution = 32;
    return {heterogeneity, Progress()};
}
/// Even weights along a ray.
float mean_along(const AirTexture& air, const vec3& origin, const vec3& direction, float length_m, std::size_t count) {
    std::vector<float> at_m, weights(count, 0.7f);
    for (std::size_t i = 0; i < count; ++i)
        at_m.push_back((static_cast<float>(i) + 0.5f) * length_m / static_cast<float>(count));
    return air.mean({origin, glm::normalize(direction), at_m, weights, length_m / static_cast<float>(count)});
}
std::vector<vec3> points_in_unit_box(std::size_t count) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> place(0.0f, 1.0f);
    std::vector<vec3> points;
    for (std::size_t i = 0; i < count; ++i)
        points.emplace_back(place(random), place(random), place(random));
    return points;
}
} // namespace

TEST_CASE("without an amount the air is its intensity, and painted intensities multiply it inside their box only") {
    for (const vec3& point : points_in_unit_box(50)) {
        CHECK(texture_of({.amount = 0.0f}).at(point, 0.0f, 0.5f) == 1.0f);
        CHECK(texture_of({.amount = 0.0f, .intensity = 3.0f}).at(point, 0.0f, 0.5f) == 3.0f);
        const AirTexture air =
            texture_of({.amount = 0.0f, .intensity = 3.0f, .painted = painted({}, {}, constant(0.25f))});
        CHECK(air.at(point, 0.0f, 0.5f) == 0.75f);
        CHECK(air.at(point + vec3(1.001f, 0, 0), 0.0f, 0.5f) == 3.0f);
        CHECK(mean_along(air, point, {0.3f, 0.2f, 1.0f}, 1e-3f, 64) == close_to(0.75, 1e-6));
    }
}

TEST_CASE("painted amounts are added and end at 0 and 1") {
    const auto at = [](float amount, float added, const vec3& point) {
        return texture_of({.amount = amount, .painted = painted(constant(added), {}, {})}).at(point, 0.0f, 0.5f);
    };
    for (const vec3& point : points_in_unit_box(20)) {
        const float noise = texture_of({}).at(point, 0.0f, 0.5f);
        CHECK(at(0.2f, 0.3f, point) == close_to(1.0 + 0.5 * (double{noise} - 1.0), 1e-6));
        CHECK(at(0.2f, -0.3f, point) == 1.0f);
        CHECK(at(0.8f, 0.7f, point) == close_to(double{noise}, 1e-6));
    }
}

TEST_CASE("painted levels smooth the noise until it is even") {
    for (const vec3& point : points_in_unit_box(20)) {
        const AirTexture smooth = texture_of({.level = 1.0f, .painted = painted({}, constant(1.0f), {})});
        CHECK(smooth.at(point, 0.0f, 0.5f) == texture_of({.level = 2.0f}).at(point, 0.0f, 0.5f));
        CHECK(std::abs(texture_of({.painted = painted({}, constant(8.0f), {})}).at(point, 0.0f, 0.5f) - 1.0f) < 1e-6f);
        CHECK(texture_of({.level = 2.0f, .painted = painted({}, constant(-8.0f), {})}).at(point, 0.0f, 0.5f) ==
              texture_of({}).at(point, 0.0f, 0.5f));
    }
}

// Seen to fail with samples at i / n.
TEST_CASE("between samples what is painted is linear, and even beyond the outermost") {
    const AirTexture air = texture_of({.amount = 0.0f,
                                       .unit_from_scene = glm::inverse(glm::translate(mat4(1.0f), vec3(5, -2, 1)) *
                                                                       glm::scale(mat4(1.0f), vec3(8, 2, 4))),
                                       .painted = painted({}, {}, volume_of({4, 2, 3}, [](auto x, auto y, auto z) {
                                                              return 1.0f + 2.0f * static_cast<float>(x) +
                                                                     10.0f * static_cast<float>(y) +
                                                                     30.0f * static_cast<float>(z);
                                                          }))});
    for (const vec3& unit : points_in_unit_box(200)) {
        const vec3 index = glm::clamp(unit * vec3(4, 2, 3) - 0.5f, vec3(0.0f), vec3(3, 1, 2));
        const double expected = 1.0 + 2.0 * double{index.x} + 10.0 * double{index.y} + 30.0 * double{index.z};
        const double found = air.at(vec3(5, -2, 1) + unit * vec3(8, 2, 4), 0.0f, 0.5f);
        CHECK(std::abs(found / expected - 1.0) < 1e-5);
    }
}

// Seen to fail with a layer's share taken along y.
TEST_CASE("steps of a ray have what is painted around each of them, inside the box, by every vector of the machine") {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> value(0.0f, 5.0f);
    const PaintedVolume volume = volume_of({5, 7, 3}, [&](auto...) { return value(random); });
    const AirTexture air = texture_of({.amount = 0.0f, .intensity = 2.0f, .painted = painted({}, {}, volume)});
    const auto painted_at = [&](const glm::dvec3& place) {
        if (glm::any(glm::lessThan(place, glm::dvec3(0.0))) || glm::any(glm::greaterThan(place, glm::dvec3(1.0))))
            return 1.0;
        double sum = 0.0;
        for (std::size_t corner = 0; corner < 8; ++corner) {
            double weight = 1.0;
            std::array<std::size_t, 3> voxel{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double last = volume.size[axis] - 1.0;
                const double at = glm::clamp(place[int(axis)] * volume.size[axis] - 0.5, 0.0, last),
                             below = std::floor(at);
                const bool is_above = (corner >> axis & 1) != 0;
                voxel[axis] = static_cast<std::size_t>(std::min(last, below + (is_above ? 1.0 : 0.0)));
                weight *= is_above ? at - below : 1.0 - (at - below);
            }
            sum += weight * double{volume.values[(voxel[2] * 7 + voxel[1]) * 5 + voxel[0]]};
        }
        return sum;
    };
    for (const SimdTarget target : available_simd_targets()) {
        const ForcedSimdTarget forced(target);
        for (const vec3& towards : points_in_unit_box(20)) {
            const vec3 origin(-0.4f, 0.3f, -0.2f), direction = glm::normalize(towards - origin);
            std::vector<float> at_m, weights;
            for (std::size_t step = 0; step < 37; ++step) {
                at_m.push_back((static_cast<float>(step) + 0.5f) * 0.06f);
                weights.push_back(step % 5 == 0 ? 0.0f : 1.0f);
            }
            std::vector<float> values(at_m.size());
            air.find({origin, direction, at_m, weights, 0.06f}, values);
            for (std::size_t step = 0; step < at_m.size(); ++step) {
                const double expected = weights[step] == 0.0f
                                            ? 0.0
                                            : 2.0 * painted_at(dvec3(origin) + double{at_m[step]} * dvec3(direction));
                CHECK(std::abs(double{values[step]} - expected) < 2e-5);
            }
        }
    }
}

TEST_CASE("along a ray the mean of many steps is the integral") {
    // Linear in x from the centre of the first sample to that of the last one.
    const AirTexture air = texture_of(
        {.amount = 0.0f,
         .painted = painted({}, {}, volume_of({2, 1, 1}, [](auto x, auto...) { return x == 0 ? 0.0f : 4.0f; }))});
    // From (0.25, 0.5, 0.5) to x = 0.65: 0 to 3.2.
    CHECK(mean_along(air, {0.25f, 0.5f, 0.5f}, {1, 0, 0}, 0.4f, 64) == close_to(1.6, 1e-5));
}

TEST_CASE("only what carries weight is looked up, in proportion") {
    const AirTexture air = texture_of({.noise = {.scale_m = 0.3f}});
    const std::vector<float> at_m{0.1f, 0.2f, 0.3f, 0.4f};
    const auto mean = [&](std::vector<float> weights) {
        return double{air.mean({{1, 2, 3}, {0, 0, 1}, at_m, weights, 0.01f})};
    };
    CHECK(mean({0, 0, 0, 0}) == 1.0);
    const double second = mean({0, 5, 0, 0}), last = mean({0, 0, 0, 2});
    CHECK(std::abs(second - last) > 1e-3);
    CHECK(mean({0, 1, 0, 3}) == close_to(0.25 * second + 0.75 * last, 1e-5));
}

// Seen to fail with the wind in single precision.
TEST_CASE("wind carries the noise along, for years without losing detail") {
    const Heterogeneity still{.noise = {.scale_m = 0.5f}};
    const AirTexture air = texture_of(still);
    for (const dvec3& moved_m : {dvec3(0.3, -0.2, 0.1), dvec3(12.5, 3.0, -40.0)}) {
        Heterogeneity moving = still;
        moving.moved_m = moved_m;
        for (const vec3& point : points_in_unit_box(20))
            CHECK(texture_of(moving).at(point + vec3(moved_m), 0.0f, 0.5f) ==
                  close_to(double{air.at(point, 0.0f, 0.5f)}, 1e-3));
    }
    // 30 years at 10 m/s, and a millimetre: as smooth as at the start.
    Heterogeneity before = still, after = still;
    before.moved_m = dvec3(9.4608e9, 1e9, -3e9);
    after.moved_m = before.moved_m + dvec3(1e-3, 0.0, 0.0);
    const AirTexture a = texture_of(before), b = texture_of(after);
    double largest = 0.0, smallest = 1e9;
    for (const vec3& point : points_in_unit_box(200)) {
        const double step = std::abs(double{b.at(point, 0.0f, 0.5f)} - double{a.at(point, 0.0f, 0.5f)});
        largest = std::max(largest, step);
        smallest = std::min(smallest, step);
    }
    CHECK(largest < 0.05);
    CHECK(largest > 1e-4);
}

TEST_CASE("the mean of the noise over many rays is 1") {
    const AirTexture air = texture_of({.noise = {.scale_m = 0.2f}});
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> place(-50.0f, 50.0f);
    double sum = 0.0, sum2 = 0.0;
    constexpr int count = 4000;
    for (int ray = 0; ray < count; ++ray) {
        const vec3 origin(place(random), place(random), place(random));
        const double mean = mean_along(air, origin, {normal(random), normal(random), normal(random)}, 3.0f, 64);
        sum += mean;
        sum2 += mean * mean;
    }
    const double mean = sum / count, deviation = std::sqrt((sum2 / count - mean * mean) / count);
    CAPTURE(deviation);
    CHECK(std::abs(mean - 1.0) < 4.0 * deviation);
    CHECK(deviation < 2e-3);
}

TEST_CASE("a texture that cannot be is refused by name") {
    const auto refused = [](const Heterogeneity& heterogeneity, const char* message) {
        CHECK_THROWS_WITH_AS(require_usable(heterogeneity), message, InvalidInput);
    };
    refused({.amount = 2.0f}, "amount of heterogeneity is 2, outside [0, 1]");
    refused({.level = -1.0f}, "level of heterogeneity is -1, outside [0, 8]");
    refused({.intensity = 2000.0f}, "intensity of heterogeneity is 2000, outside [0, 1000]");
    refused({.step_count = 5000}, "step_count of heterogeneity is 5000, outside [1, 4096]");
    refused({.upsampling = 6}, "upsampling of heterogeneity is 6, not 1, 2, 4, 8 or 16");
    refused({.noise = {.scale_m = 2e6f}}, "scale_m of the air's noise is 2e+06, outside [1.17549e-38, 1e+06]");
    refused({.moved_m = {0.0, std::numeric_limits<double>::quiet_NaN(), 0.0}}, "moved_m of the air is (0, nan, 0)");
    mat4 broken(1.0f);
    broken[1][2] = std::numeric_limits<float>::infinity();
    refused({.unit_from_scene = broken, .painted = painted({}, {}, {})},
            "unit_from_scene of the painted air is not finite");
    CHECK_THROWS_WITH_AS((void)painted({.size = {2, 2, 2}, .values = {1.0f}}, {}, {}),
                         "the painted amount has 1 values, but a size of 2 x 2 x 2", InvalidInput);
    CHECK_THROWS_WITH_AS(
        (void)painted({}, {}, volume_of({2, 1, 1}, [](auto x, auto...) { return x == 0 ? 1.0f : -2.0f; })),
        "the painted intensity is -2 at voxel (1, 0, 0), outside [0, 1000]", InvalidInput);
}
} // namespace air_texture_test
