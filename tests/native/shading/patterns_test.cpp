// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/simd.hpp"
#include "shading/patterns/brick.hpp"
#include "shading/patterns/checker.hpp"
#include "shading/patterns/gabor.hpp"
#include "shading/patterns/gradient.hpp"
#include "shading/patterns/magic.hpp"
#include "shading/patterns/musgrave.hpp"
#include "shading/patterns/noise.hpp"
#include "shading/patterns/voronoi.hpp"
#include "shading/patterns/wave.hpp"
#include "shading/patterns/white_noise.hpp"
#include <doctest/doctest.h>
#include <random>

namespace patterns_test {
using namespace tyndall;
using namespace tyndall::patterns;

namespace {
struct Places {
    std::mt19937 random{7};
    float number(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); }
    template <int N>
    Point<N> point(float reach) {
        Point<N> at;
        for (int axis = 0; axis < N; ++axis)
            at[axis] = number(-reach, reach);
        return at;
    }
};

template <int N>
void check_gradient_noise() {
    CAPTURE(N);
    Places places;
    float lowest = 0.0f, highest = 0.0f, steepest = 0.0f;
    double sum = 0.0;
    constexpr int count = 20000;
    for (int i = 0; i < count; ++i) {
        const Point<N> at = places.point<N>(50.0f);
        CHECK(gradient_noise<N>(glm::floor(at)) == 0.0f);
        const float here = gradient_noise<N>(at);
        lowest = std::min(lowest, here);
        highest = std::max(highest, here);
        sum += double{here};
        constexpr float step = 0.001f;
        for (int axis = 0; axis < N; ++axis) {
            Point<N> beside = at;
            beside[axis] += step;
            steepest = std::max(steepest, std::abs(gradient_noise<N>(beside) - here) / step);
        }
    }
    // Its values fill most of [-1, 1] and do not leave it; a jump anywhere would show as a slope of 1 / step.
    CHECK(lowest > -1.0f);
    CHECK(lowest < -0.6f);
    CHECK(highest < 1.0f);
    CHECK(highest > 0.6f);
    CHECK(std::abs(sum / count) < 0.02);
    CHECK(steepest < 6.0f);
}

float voronoi_distance(const vec3& at, const VoronoiConfig& config) { return voronoi(at, config).distance; }
} // namespace

TEST_CASE("hashes of the same numbers in another order differ, and are spread evenly over their bits") {
    CHECK(patterns::hash(1u, 2u) != patterns::hash(2u, 1u));
    CHECK(patterns::hash(1u, 2u, 3u) != patterns::hash(3u, 2u, 1u));
    CHECK(patterns::hash(0u) != patterns::hash(0u, 0u));
    std::array<int, 32> set{};
    constexpr int count = 4096;
    for (std::uint32_t key = 0; key < count; ++key)
        for (std::size_t bit = 0; bit < set.size(); ++bit)
            set[bit] += static_cast<int>((patterns::hash(key, 7u, key >> 3, 1u) >> bit) & 1u);
    for (const int ones : set) // six deviations
        CHECK(std::abs(ones - count / 2) < 6 * 32);
}

// Seen to fail with an axis' two weights swapped, which jumps at every lattice plane.
TEST_CASE("gradient noise is 0 at lattice points, continuous, and within [-1, 1]") {
    check_gradient_noise<1>();
    check_gradient_noise<2>();
    check_gradient_noise<3>();
    check_gradient_noise<4>();
}

TEST_CASE("gradient noise has the same values on every instruction set, to rounding") {
    Places places;
    std::vector<Point<3>> points(300);
    for (Point<3>& point : points)
        point = places.point<3>(100.0f);
    std::vector<float> first;
    for (const SimdTarget target : available_simd_targets()) {
        const ForcedSimdTarget forced(target);
        std::vector<float> values(points.size());
        gradient_noise<3>(std::span<const Point<3>>(points), values.data());
        if (first.empty())
            first = values;
        for (std::size_t i = 0; i < values.size(); ++i)
            CHECK(std::abs(values[i] - first[i]) < 1e-6f);
    }
}

TEST_CASE("gradient noise takes any number, however large or undefined") {
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float at : {1e6f, -3e9f, 1e30f, infinity, -infinity, std::nanf("")})
        CHECK(std::abs(gradient_noise<3>(Point<3>(at, 0.3f, 0.7f))) < 1.0f);
    CHECK(gradient_noise<2>(Point<2>(infinity, 0.0f)) == 0.0f);
    CHECK(gradient_noise<1>(Point<1>(0.25f)) != 0.0f);
}

TEST_CASE("one octave of normalized noise is gradient noise brought to [0, 1], and a share of an octave lies between") {
    Places places;
    for (int i = 0; i < 100; ++i) {
        const vec3 at = places.point<3>(5.0f);
        NoiseConfig config{.scale = 1.0f};
        config.octaves.detail = 0.0f;
        CHECK(std::abs(noise(at, config) - (0.5f * gradient_noise<3>(at) + 0.5f)) < 1e-6f);
        const auto with_detail = [&](float detail) {
            config.octaves.detail = detail;
            return noise(at, config);
        };
        CHECK(std::abs(with_detail(2.25f) - (0.75f * with_detail(2.0f) + 0.25f * with_detail(3.0f))) < 1e-6f);
    }
}

TEST_CASE("every fractal continues from whole to broken numbers of octaves") {
    Places places;
    for (const Fractal fractal :
         {Fractal::Multifractal, Fractal::Fbm, Fractal::HybridMultifractal, Fractal::HeteroTerrain})
        for (int i = 0; i < 50; ++i) {
            const vec3 at = places.point<3>(5.0f);
            const auto with_detail = [&](float detail) {
                return noise(at, {.fractal = fractal,
                                  .is_normalized = false,
                                  .octaves = {.detail = detail, .offset = 0.7f, .gain = 1.3f}});
            };
            CAPTURE(static_cast<int>(fractal));
            CHECK(std::abs(with_detail(2.99999f) - with_detail(3.0f)) < 1e-3f);
            CHECK(std::abs(with_detail(3.00001f) - with_detail(3.0f)) < 1e-3f);
        }
}

TEST_CASE("Musgrave's octaves beyond none are the Noise node's, one fewer") {
    Places places;
    for (const Fractal fractal :
         {Fractal::Multifractal, Fractal::Fbm, Fractal::RidgedMultifractal, Fractal::HeteroTerrain})
        for (int i = 0; i < 50; ++i) {
            const vec3 at = places.point<3>(5.0f);
            const float by_musgrave =
                musgrave(at, {.fractal = fractal, .detail = 3.5f, .dimension = 1.0f, .offset = 0.4f});
            const NoiseConfig config{.fractal = fractal,
                                     .is_normalized = false,
                                     .octaves = {.detail = 2.5f, .factor = 0.5f, .offset = 0.4f, .gain = 1.0f}};
            CHECK(std::abs(by_musgrave - noise(at, config)) < 1e-5f * std::max(1.0f, std::abs(by_musgrave)));
        }
}

TEST_CASE("distortion displaces noise by noise of about its strength") {
    Places places;
    int moved = 0;
    for (int i = 0; i < 100; ++i) {
        const vec3 at = places.point<3>(5.0f);
        const float plain = noise(at, {}), bent = noise(at, {.distortion = 1.0f});
        const float hardly = noise(at, {.distortion = 1e-5f});
        CHECK(std::abs(hardly - plain) < 1e-4f);
        moved += std::abs(bent - plain) > 0.01f;
    }
    CHECK(moved > 70);
}

// Seen to fail with F2 answering for F1.
TEST_CASE(
    "F1 is the nearest of all points, F2 the second: brute force, with points that stay near their cells' corners") {
    Places places;
    for (int i = 0; i < 300; ++i) {
        const vec3 at = places.point<3>(20.0f);
        VoronoiConfig config{.scale = 1.0f, .randomness = 0.4f}; // so that no nearer point lies further off
        // With a place on the point itself F1 is 0: that is how each point is found.
        float first = 1e9f, second = 1e9f;
        for (int cell = 0; cell < 125; ++cell) {
            const vec3 corner = glm::floor(at) + vec3(cell % 5 - 2, cell / 5 % 5 - 2, cell / 25 - 2);
            const vec3 point(voronoi(corner + 0.2f, config).place);
            REQUIRE(voronoi_distance(point, config) < 1e-5f);
            if (glm::floor(point) != corner)
                continue;
            const float distance = glm::length(point - at);
            second = std::min(second, std::max(first, distance));
            first = std::min(first, distance);
        }
        CHECK(std::abs(voronoi_distance(at, config) - first) < 1e-5f);
        config.feature = VoronoiConfig::Feature::F2;
        CHECK(std::abs(voronoi_distance(at, config) - second) < 1e-5f);
        config.feature = VoronoiConfig::Feature::SmoothF1;
        config.smoothness = 1e-4f;
        CHECK(std::abs(voronoi_distance(at, config) - first) < 1e-3f);
    }
}

TEST_CASE("metrics are ordered: Chebychev <= Euclidean <= Manhattan, and Minkowski with 1 and 2 is two of them") {
    Places places;
    using Metric = VoronoiConfig::Metric;
    for (int dimensions = 1; dimensions <= 4; ++dimensions)
        for (int i = 0; i < 100; ++i) {
            const vec3 at = places.point<3>(20.0f);
            const auto by = [&](Metric metric, float exponent = 1.0f) {
                return voronoi_distance(at, {.dimensions = dimensions,
                                             .metric = metric,
                                             .w = at.y,
                                             .scale = 1.0f,
                                             .randomness = 0.9f,
                                             .exponent = exponent});
            };
            CHECK(by(Metric::Chebychev) <= by(Metric::Euclidean) + 1e-6f);
            CHECK(by(Metric::Euclidean) <= by(Metric::Manhattan) + 1e-6f);
            CHECK(std::abs(by(Metric::Minkowski, 1.0f) - by(Metric::Manhattan)) < 1e-5f);
            CHECK(std::abs(by(Metric::Minkowski, 2.0f) - by(Metric::Euclidean)) < 1e-5f);
        }
}

TEST_CASE("half way between the two nearest points the distance to the edge is 0; without randomness cells are cubes") {
    Places places;
    for (const bool has_permuted_points : {false, true})
        for (int i = 0; i < 200; ++i) {
            const vec3 at = places.point<3>(20.0f);
            VoronoiConfig config{.has_permuted_points = has_permuted_points, .scale = 1.0f, .randomness = 0.4f};
            const vec3 first(voronoi(at, config).place);
            config.feature = VoronoiConfig::Feature::F2;
            const vec3 second(voronoi(at, config).place);
            const float to_middle_plane = glm::dot((first + second) * 0.5f - at, glm::normalize(second - first));
            config.feature = VoronoiConfig::Feature::DistanceToEdge;
            CHECK(voronoi_distance(at, config) <= to_middle_plane + 1e-5f);
            config.randomness = 0.0f;
            const vec3 to_faces = 0.5f - glm::abs(at - glm::round(at));
            const float nearest = std::min(std::min(to_faces.x, to_faces.y), to_faces.z);
            CHECK(std::abs(voronoi_distance(at, config) - nearest) < 1e-4f);
            config.feature = VoronoiConfig::Feature::SphereRadius;
            CHECK(std::abs(voronoi_distance(at, config) - 0.5f) < 1e-4f);
        }
}

TEST_CASE("normalized distances stay within [0, 1], whatever the octaves") {
    Places places;
    using Feature = VoronoiConfig::Feature;
    for (const Feature feature : {Feature::F1, Feature::F2, Feature::SmoothF1, Feature::DistanceToEdge})
        for (int dimensions = 1; dimensions <= 4; ++dimensions)
            for (int i = 0; i < 50; ++i) {
                const vec3 at = places.point<3>(20.0f);
                const float distance = voronoi_distance(at, {.dimensions = dimensions,
                                                             .feature = feature,
                                                             .is_normalized = true,
                                                             .w = at.z,
                                                             .randomness = places.number(0.0f, 1.0f),
                                                             .detail = places.number(0.0f, 3.0f)});
                CHECK(distance >= -0.2f); // smoothing takes a little from all
                CHECK(distance <= 1.0f);
            }
}

// Seen to fail with the shift by a millionth left out.
TEST_CASE("checkers alternate along every axis, and a floor at 0 is not torn by rounding") {
    for (int x = -3; x < 3; ++x)
        for (int y = -3; y < 3; ++y)
            for (int z = -3; z < 3; ++z) {
                const vec3 at = vec3(x, y, z) + 0.5f;
                for (const vec3& step : {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)})
                    CHECK(checker(at, 1.0f) != checker(at + step, 1.0f));
            }
    for (const float rounding : {-5e-7f, -1e-9f, 0.0f, 1e-9f, 5e-7f})
        CHECK(checker({0.5f, 0.5f, rounding}, 1.0f) == checker({0.5f, 0.5f, 0.5f}, 1.0f));
}

TEST_CASE("bricks repeat with their pattern, and mortar surrounds them") {
    const BrickConfig config{.scale = 1.0f};
    Places places;
    for (int i = 0; i < 500; ++i) {
        const vec3 at = places.point<3>(20.0f);
        const Brick found = brick(at, config);
        CHECK(found.tint >= 0.0f);
        CHECK(found.tint <= 1.0f);
        // Two rows up is the same joint; a row up, half a brick aside.
        CHECK(std::abs(brick(at + vec3(0.0f, 0.5f, 0.0f), config).mortar_share - found.mortar_share) < 0.01f);
        CHECK(std::abs(brick(at + vec3(0.25f, 0.25f, 0.0f), config).mortar_share - found.mortar_share) < 0.01f);
    }
    CHECK(brick({0.1f, 0.2501f, 0.0f}, config).mortar_share == 1.0f);
    CHECK(brick({0.1f, 0.375f, 0.0f}, config).mortar_share == 0.0f);
    CHECK(brick({std::nanf(""), 1e30f, 0.0f}, config).tint >= 0.0f);
}

TEST_CASE("a sine wave has 20 radians per unit, and triangles are straight") {
    const WaveConfig sine{.scale = 1.0f};
    WaveConfig triangle = sine, rings = sine;
    triangle.profile = WaveConfig::Profile::Triangle;
    rings.kind = WaveConfig::Kind::Rings;
    rings.direction = WaveConfig::Direction::Z;
    constexpr float period = std::numbers::pi_v<float> / 10.0f;
    for (float x = 0.01f; x < 1.0f; x += 0.07f) {
        CHECK(std::abs(wave({x, 0, 0}, sine) - wave({x + period, 5, 9}, sine)) < 1e-4f);
        CHECK(std::abs(wave({x, 0, 0}, sine) - wave({0, x, 3}, rings)) < 1e-4f);
    }
    CHECK(std::abs(wave({period * 0.25f, 0, 0}, triangle) - 0.5f) < 1e-4f);
    CHECK(std::abs(wave({period * 0.5f, 0, 0}, triangle) - 1.0f) < 1e-4f);
}

TEST_CASE("gradients are what their names say") {
    CHECK(gradient({0.3f, 9, 9}, Gradient::Linear) == 0.3f);
    CHECK(gradient({-1, 0, 0}, Gradient::Linear) == 0.0f);
    CHECK(gradient({0.5f, 0, 0}, Gradient::Quadratic) == 0.25f);
    CHECK(gradient({0.5f, 0, 0}, Gradient::Easing) == 0.5f);
    CHECK(gradient({0.5f, 0.25f, 0}, Gradient::Diagonal) == 0.375f);
    CHECK(std::abs(gradient({0, 1, 0}, Gradient::Radial) - 0.75f) < 1e-6f);
    CHECK(std::abs(gradient({0.6f, 0, 0}, Gradient::Spherical) - 0.4f) < 2e-6f);
    CHECK(gradient({1, 0, 0}, Gradient::QuadraticSphere) == 0.0f);
}

TEST_CASE("Gabor noise has its frequency along its direction, and none across it") {
    GaborConfig config{.scale = 1.0f, .frequency = 3.0f, .angle_rad = 0.0f};
    double along = 0.0, across = 0.0;
    Places places;
    for (int i = 0; i < 4000; ++i) {
        const vec3 at = places.point<3>(20.0f);
        const auto turn = [&](const vec3& step) {
            const float change = gabor(at + step, config).phase - gabor(at, config).phase;
            return double{change - std::round(change)};
        };
        along += turn({0.02f, 0, 0}) / 0.02;
        across += turn({0, 0.02f, 0}) / 0.02;
        CHECK(std::abs(gabor(at, config).value - 0.5f) <= 0.5f * gabor(at, config).intensity + 1e-5f);
    }
    CHECK(std::abs(along / 4000 - 3.0) < 0.15);
    CHECK(std::abs(across / 4000) < 0.15);
}

TEST_CASE("magic starts as waves along the diagonals, 1 / 2 strong around a half") {
    Places places;
    for (int i = 0; i < 100; ++i) {
        const vec3 at = places.point<3>(1.0f);
        const Rgb colour = magic(at, 1.0f, 1.0f, 0);
        CHECK(std::abs(colour.x - (0.5f - 0.5f * std::sin((at.x + at.y + at.z) * 5.0f))) < 1e-5f);
        for (int depth = 0; depth <= 10; ++depth)
            for (int channel = 0; channel < 3; ++channel)
                CHECK(std::abs(magic(at, 5.0f, 1.5f, depth)[channel] - 0.5f) <= 0.5001f);
    }
}

TEST_CASE("white noise has no two places alike") {
    const float here = white_noise({1.0f, 2.0f, 3.0f}, 4.0f, 4);
    CHECK(white_noise({1.0f, 2.0f, 3.0f}, 4.0f, 4) == here);
    CHECK(white_noise({1.0f, 2.0f, std::nextafter(3.0f, 4.0f)}, 4.0f, 4) != here);
    CHECK(white_noise({9.0f, 9.0f, 9.0f}, 4.0f, 1) == white_noise({1.0f, 2.0f, 3.0f}, 4.0f, 1));
}
} // namespace patterns_test
