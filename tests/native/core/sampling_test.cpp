// SPDX-License-Identifier: GPL-3.0-or-later
// A sampling function and its PDF are two accounts of one distribution: the PDF integrates to 1, and samples fall into
// each part of the sphere as often as the PDF's integral over it says.
#include "core/sampling.hpp"
#include "core/sobol.hpp"
#include "support/chi_square.hpp"
#include <array>
#include <doctest/doctest.h>
#include <functional>

namespace sampling_test {
using namespace tyndall;

struct Sampler {
    const char* name;
    std::function<vec3(vec2)> sample;
    std::function<double(vec3)> pdf_per_sr;
};
static const std::array<Sampler, 4> samplers{{
    {"cosine hemisphere", sample_cosine_hemisphere, [](vec3 d) { return cosine_hemisphere_pdf_per_sr(d.z); }},
    {"sphere", sample_uniform_sphere, [](vec3) { return uniform_cone_pdf_per_sr(2.0f); }},
    {"cone of 60 degrees", [](vec2 u) { return sample_uniform_cone(u, 0.5f); },
     [](vec3 d) { return d.z > 0.5f ? uniform_cone_pdf_per_sr(0.5f) : 0.0f; }},
    {"cone beyond a hemisphere", [](vec2 u) { return sample_uniform_cone(u, 1.5f); },
     [](vec3 d) { return d.z > -0.5f ? uniform_cone_pdf_per_sr(1.5f) : 0.0f; }},
}};
constexpr int heights = 20, longitudes = 40; // cells of equal solid angle; 0.5 and -0.5 are edges between rows

/// The integral of the PDF over each cell, by 16 x 16 midpoints.
static std::vector<double> expected_shares(const Sampler& sampler) {
    std::vector<double> shares(heights * longitudes);
    constexpr int steps = 16;
    for (int row = 0; row < heights * steps; ++row)
        for (int column = 0; column < longitudes * steps; ++column) {
            const double z = -1.0 + 2.0 * (row + 0.5) / (heights * steps);
            const double longitude = 2.0 * std::numbers::pi * (column + 0.5) / (longitudes * steps);
            const double radius = std::sqrt(1.0 - z * z);
            const vec3 direction(dvec3(radius * std::cos(longitude), radius * std::sin(longitude), z));
            const double solid_angle_sr = 4.0 * std::numbers::pi / (heights * longitudes * steps * steps);
            shares[static_cast<std::size_t>(row / steps * longitudes + column / steps)] +=
                sampler.pdf_per_sr(direction) * solid_angle_sr;
        }
    return shares;
}

TEST_CASE("the PDF of every sampler of directions integrates to 1") {
    for (const Sampler& sampler : samplers) {
        CAPTURE(sampler.name);
        const std::vector<double> shares = expected_shares(sampler);
        CHECK(std::abs(std::accumulate(shares.begin(), shares.end(), 0.0) - 1.0) < 1e-5);
    }
}
// Seen to fail for the cosine hemisphere with uniform_cone in its place, and for the cone with cos and 1 - cos mixed up.
TEST_CASE("directions fall where the PDF says, by chi-square") {
    constexpr int count = 200000;
    for (const Sampler& sampler : samplers) {
        CAPTURE(sampler.name);
        std::vector<double> observed(heights * longitudes), expected = expected_shares(sampler);
        for (std::uint32_t index = 0; index < count; ++index) {
            // Independent numbers: low discrepancy would be more even than chi-square allows for.
            const auto bits = pcg4d({index, 1, 2, 3});
            const vec3 direction = sampler.sample({unit_float(bits[0]), unit_float(bits[1])});
            CHECK(std::abs(glm::length(direction) - 1.0f) < 4e-7f);
            const double longitude = std::atan2(direction.y, direction.x) / (2.0 * std::numbers::pi) + 0.5;
            const int row = std::min(heights - 1, static_cast<int>((direction.z + 1.0) * 0.5 * heights));
            const int column = (static_cast<int>(longitude * longitudes) + longitudes / 2) % longitudes;
            observed[static_cast<std::size_t>(row * longitudes + column)] += 1.0;
        }
        for (double& share : expected)
            share *= count;
        CHECK(support::is_plausible(support::chi_square_p_value(observed, expected), samplers.size()));
    }
}
TEST_CASE("the disc is uniform: any circle around the centre holds its share of the area") {
    constexpr std::uint32_t count = 1 << 14;
    for (const float radius : {0.25f, 0.5f, 0.9f}) {
        float inside = 0;
        for (std::uint32_t index = 0; index < count; ++index)
            inside += glm::length(sample_concentric_disc(sobol_point(index, 7))) < radius ? 1.0f : 0.0f;
        // A curve of length 2 pi r splits at most about that many of the 128 x 128 boxes of the net.
        CHECK(std::abs(inside - static_cast<float>(count) * radius * radius) < 2.0f * 128.0f * radius);
    }
}
TEST_CASE("the sun's cone keeps its width where float's cosine has two digits") {
    const float half_angle = 0.00465f; // radians
    float widest = 0.0f;
    for (const vec2 u : {vec2(0, 0.5f), vec2(0.99999994f, 0.5f), vec2(0.5f, 0)}) {
        const vec3 direction = sample_uniform_cone(u, one_minus_cos(half_angle));
        widest = std::max(widest, std::hypot(direction.x, direction.y));
    }
    CHECK(std::abs(widest / std::sin(half_angle) - 1.0f) < 1e-6f);
}
TEST_CASE("a frame is orthonormal and right-handed around every axis, the poles included") {
    for (std::uint32_t index = 0; index < 1000; ++index) {
        vec3 axis = sample_uniform_sphere(sobol_point(index, 3));
        if (index < 2)
            axis = {0, 0, index == 0 ? -1 : 1};
        const vec3 x = from_frame(axis, {1, 0, 0}), y = from_frame(axis, {0, 1, 0});
        CHECK(std::abs(glm::dot(x, y)) < 3e-7f);
        CHECK(glm::distance(glm::cross(x, y), axis) < 1e-6f);
    }
}
} // namespace sampling_test
