// SPDX-License-Identifier: GPL-3.0-or-later
// What hair must be by its own laws: all light leaves a fibre that absorbs none, mirrors lie where geometry says, and
// directions are drawn as often as light is sent there.
#include "core/random.hpp"
#include "shading/lobes/fibre.hpp"
#include "shading/lobes/hair_models.hpp"
#include "shading/lobes/lobe_set.hpp"
#include "shading/material.hpp"
#include "support/chi_square.hpp"
#include "support/close_to.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <numbers>

namespace hair_test {
using namespace tyndall;
using tyndall::support::close_to;

namespace {
constexpr double tau = 2.0 * std::numbers::pi;
const vec3 along = glm::normalize(vec3(0.3f, -0.5f, 0.8f));

/// The viewer, in the plane of the fibre and `towards`, this far out of the plane across it.
vec3 viewer_at(float degrees) {
    const vec3 across = orthonormal_basis(along).first;
    const float angle = glm::radians(degrees);
    return glm::normalize(std::sin(angle) * along + std::cos(angle) * across);
}
/// Of a round fibre, at this share of its width.
vec3 normal_at(float share, const vec3& outgoing) {
    const fibre::Frame frame(along, outgoing);
    return share * frame.across + std::sqrt(1.0f - share * share) * frame.towards_viewer;
}

struct Hair {
    float roughness = 0.3f, radial = 0.3f, coat = 0.0f, ior = 1.55f, offset_rad = glm::radians(2.0f);
    Rgb absorption{0.0f};
};
Lobes lobes_of(const Hair& hair, const vec3& normal, const vec3& outgoing) {
    LobeInputs inputs{};
    const std::array<Rgb, 13> values{Rgb(1.0f),      hair.absorption,     Rgb(0.0f),
                                     Rgb(0.0f),      Rgb(hair.roughness), Rgb(hair.radial),
                                     Rgb(hair.coat), Rgb(hair.ior),       Rgb(hair.offset_rad),
                                     Rgb(0.5f),      Rgb(0.0f),           Rgb(0.0f),
                                     3.0f * along};
    std::ranges::copy(values, inputs.begin());
    ShadingPoint point;
    point.geometric_normal = point.shading_normal = normal;
    SurfaceClosures closures;
    Lobes lobes;
    add_lobes({.model = LobeModel::HairOfAbsorption, .preserves_energy = true}, inputs, point, closures, &lobes,
              {.outgoing = outgoing});
    return lobes;
}
Lobe of_hair_bsdf(Lobe::Kind kind, float roughness_along, float roughness_around, float offset_rad) {
    return {.kind = kind,
            .alpha = roughness_along,
            .ior = roughness_around,
            .sampling = 1.0f,
            .weight = Rgb(1.0f),
            .a = {offset_rad, 0.0f, 0.0f},
            .normal = along};
}

/// Over all directions, by a grid that is even in both angles: value(direction) is summed up by what of them it stands for.
template <typename Value>
double over_sphere(const vec3& outgoing, int side, const Value& value) {
    const fibre::Frame frame(along, outgoing);
    double sum = 0.0;
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const double theta = std::numbers::pi * ((row + 0.5) / side - 0.5),
                         phi = tau * ((column + 0.5) / side - 0.5);
            const double solid_angle_sr = std::cos(theta) * std::numbers::pi * tau / (static_cast<double>(side) * side);
            sum += solid_angle_sr * value(frame.direction(static_cast<float>(std::sin(theta)),
                                                          static_cast<float>(std::cos(theta)), static_cast<float>(phi)),
                                          solid_angle_sr);
        }
    return sum;
}

float unit(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

/// Drawn directions in cells over theta and phi, beside what the density promises.
void check_directions(const LobeSet& set) {
    constexpr int rows = 12, columns = 12, fine = 40;
    constexpr std::uint32_t count = 100'000;
    std::vector<double> expected(rows * columns), observed(rows * columns);
    const fibre::Frame frame(along, set.outgoing);
    const auto cell = [&](const vec3& direction) {
        const fibre::Angles at = fibre::angles_of(frame, direction);
        const int row = static_cast<int>(rows * (std::asin(at.sine_theta) / std::numbers::pi_v<float> + 0.5f)),
                  column = static_cast<int>(columns * (at.phi / static_cast<float>(tau) + 0.5f));
        return static_cast<std::size_t>(std::min(row, rows - 1) * columns + std::min(column, columns - 1));
    };
    double most = 0.0, promised = 0.0;
    over_sphere(set.outgoing, rows * fine, [&](const vec3& direction, double solid_angle_sr) {
        const double pdf = set.pdf_per_sr(direction);
        most = std::max(most, pdf);
        expected[cell(direction)] += pdf * count * solid_angle_sr;
        return 0.0;
    });
    for (std::uint32_t index = 0; index < count; ++index)
        observed[cell(set.sample({unit(hash(1, index)), unit(hash(2, index))}))] += 1.0;
    for (const double one : expected)
        promised += one / count;
    CHECK(promised == close_to(1.0, 2e-3));
    CHECK(support::chi_square_p_value(observed, expected) > 1e-4);
    double bound = 0.0, all = 0.0;
    for (const Lobe& lobe : set.lobes) {
        bound += static_cast<double>(lobe.sampling * fibre::most_pdf_per_sr(lobe, set.outgoing));
        all += static_cast<double>(lobe.sampling);
    }
    CHECK(most <= 1.0001 * bound / all);
}
} // namespace

TEST_CASE("Bessel's function is its integral") {
    for (const double x : {0.0, 0.1, 1.0, 3.7, 3.8, 11.0, 90.0, 5000.0}) {
        double sum = 0.0;
        constexpr int steps = 20000;
        for (int step = 0; step < steps; ++step)
            sum += std::exp(x * (std::cos(std::numbers::pi * (step + 0.5) / steps) - 1.0)) / steps;
        CHECK(static_cast<double>(fibre::scaled_bessel_i0(static_cast<float>(x))) == close_to(sum, 2e-6));
    }
}

TEST_CASE("what a fibre mirrors and lets pass is all of the light, less what it absorbs") {
    for (const float sine : {0.0f, -0.4f, 0.99f})
        for (const float gamma : {0.0f, 0.7f, -1.5f})
            for (const float ior : {1.0f, 1.55f, 2.5f}) {
                const hair::Shares clear = hair::shares(sine, std::sqrt(1 - sine * sine), gamma, Rgb(0.0f), ior);
                CHECK(clear.mirrored.x + clear.through.x + clear.mirrored_inside.x + clear.further.x ==
                      close_to(1.0, 1e-5));
                // Twice the absorption is as if the light passed it twice.
                const hair::Shares once = hair::shares(sine, std::sqrt(1 - sine * sine), gamma, Rgb(0.3f), ior),
                                   twice = hair::shares(sine, std::sqrt(1 - sine * sine), gamma, Rgb(0.6f), ior);
                CHECK(once.mirrored.x == clear.mirrored.x);
                CHECK(once.through.x * once.through.x == close_to(twice.through.x * clear.through.x, 1e-5));
                CHECK(once.mirrored_inside.x <= clear.mirrored_inside.x);
            }
    // At the middle of its width, straight through is the whole diameter.
    CHECK(hair::shares(0.0f, 1.0f, 0.0f, Rgb(0.5f), 1.0f).through.x == close_to(std::exp(-1.0), 1e-5));
}

TEST_CASE("hair that absorbs nothing is as bright as what is around it") {
    for (const float roughness : {0.1f, 0.35f, 0.9f})
        for (const float degrees : {0.0f, 40.0f, -75.0f})
            for (const float share : {-0.6f, 0.98f})
                for (const float offset : {0.0f, 0.15f}) {
                    CAPTURE(roughness);
                    CAPTURE(degrees);
                    CAPTURE(share);
                    const vec3 outgoing = viewer_at(degrees), normal = normal_at(share, outgoing);
                    const Lobes lobes =
                        lobes_of({.roughness = roughness, .radial = roughness, .offset_rad = offset}, normal, outgoing);
                    // As the renderer asks it: by the light's cosine on either side of the point.
                    const LobeSet seen{.lobes = lobes, .normal = normal, .outgoing = outgoing},
                        behind{.lobes = lobes, .normal = -normal, .outgoing = outgoing};
                    CHECK(over_sphere(outgoing, roughness < 0.2f ? 300 : 120, [&](const vec3& incoming, double) {
                              const float cosine = glm::dot(incoming, normal);
                              return static_cast<double>(cosine > 0.0f ? cosine * seen.per_irradiance(incoming).x
                                                                       : -cosine * behind.per_irradiance(incoming).x);
                          }) == close_to(1.0, 2e-3));
                }
}

TEST_CASE("both ways of light along a fibre are alike") {
    for (const float a : {-1.2f, 0.1f, 0.8f})
        for (const float b : {-0.9f, 0.4f, 1.5f})
            for (const float variance : {1e-3f, 0.05f, 2.0f})
                CHECK(fibre::along_fibre(std::sin(a), std::cos(a), std::sin(b), std::cos(b), variance) ==
                      fibre::along_fibre(std::sin(b), std::cos(b), std::sin(a), std::cos(a), variance));
}

TEST_CASE("smooth hair mirrors as its surface does, and lets light pass straight where it does not refract") {
    for (const float degrees : {0.0f, 35.0f, -60.0f})
        for (const float share : {0.0f, 0.5f, -0.9f}) {
            const vec3 outgoing = viewer_at(degrees), normal = normal_at(share, outgoing);
            Lobes lobes = lobes_of({.roughness = 0.01f, .radial = 0.01f, .offset_rad = 0.0f}, normal, outgoing);
            REQUIRE(lobes.size() == 4);
            const vec3 mirrored = fibre::sample(lobes[0], outgoing, {0.5f, 0.5f});
            CHECK(glm::length(mirrored - (2.0f * glm::dot(outgoing, normal) * normal - outgoing)) < 0.03f);
            lobes = lobes_of({.roughness = 0.01f, .radial = 0.01f, .ior = 1.0f, .offset_rad = 0.0f}, normal, outgoing);
            REQUIRE(lobes.size() == 1);
            CHECK(glm::length(fibre::sample(lobes[0], outgoing, {0.5f, 0.5f}) + outgoing) < 0.03f);
        }
}

TEST_CASE(
    "scales tilt the first mirror image towards the root by twice their angle, the second to the tip by four times") {
    const vec3 outgoing = viewer_at(20.0f);
    const Lobes lobes =
        lobes_of({.roughness = 0.01f, .radial = 0.01f, .offset_rad = 0.1f}, normal_at(0.3f, outgoing), outgoing);
    const float viewer = glm::radians(20.0f);
    const auto theta = [&](std::size_t lobe) {
        return std::asin(glm::dot(fibre::sample(lobes.at(lobe), outgoing, {0.5f, 0.75f}), along));
    };
    CHECK(theta(0) == close_to(-viewer - 0.2f, 0.05));
    CHECK(theta(1) == close_to(-viewer + 0.1f, 0.05));
    CHECK(theta(2) == close_to(-viewer + 0.4f, 0.3));
}

TEST_CASE("a colour's absorption gives that colour back to many hairs") {
    for (const float radial : {0.1f, 0.3f, 0.9f}) {
        const float fit = 5.969f - 0.215f * radial + 2.532f * radial * radial - 10.73f * radial * radial * radial +
                          5.574f * std::pow(radial, 4.0f) + 0.245f * std::pow(radial, 5.0f);
        const Rgb back = glm::exp(-glm::sqrt(hair::absorption_of_colour({0.7f, 0.4f, 0.1f}, radial)) * fit);
        CHECK(glm::length(back - Rgb(0.7f, 0.4f, 0.1f)) < 1e-5f);
    }
    CHECK(hair::absorption_of_melanin(0.0f, 0.5f) == Rgb(0.0f));
}

TEST_CASE("principled hair's directions come as often as its density says") {
    for (const auto& [roughness, radial] : {std::pair{0.25f, 0.3f}, {0.6f, 0.15f}, {0.95f, 0.9f}})
        for (const float degrees : {10.0f, -70.0f}) {
            CAPTURE(roughness);
            CAPTURE(degrees);
            const vec3 outgoing = viewer_at(degrees), normal = normal_at(0.55f, outgoing);
            const Lobes lobes =
                lobes_of({.roughness = roughness, .radial = radial, .offset_rad = 0.12f, .absorption = Rgb(0.2f)},
                         normal, outgoing);
            const LobeSet set{.lobes = lobes, .normal = normal, .outgoing = outgoing};
            check_directions(set);
            // And the density is what is sent back.
            const vec3 incoming = viewer_at(-degrees);
            for (const Lobe& lobe : lobes)
                CHECK(fibre::scattered(lobe, {along, outgoing, incoming}) ==
                      fibre::pdf_per_sr(lobe, {along, outgoing, incoming}));
        }
}

TEST_CASE(
    "up to Blender 3.x scales tilt the light's angle: as the viewer's, were both to change places along the fibre") {
    const vec3 outgoing = viewer_at(35.0f), incoming = viewer_at(-20.0f);
    for (Lobe lobe : lobes_of({.offset_rad = 0.1f}, normal_at(0.0f, outgoing), outgoing)) {
        lobe.a.z = 0.0f; // both are in one plane with the fibre
        const float since = fibre::scattered(lobe, {along, incoming, outgoing});
        lobe.is_separable = true;
        CHECK(fibre::scattered(lobe, {along, outgoing, incoming}) == close_to(since, 1e-4));
        lobe.is_separable = false;
        CHECK(fibre::pdf_per_sr(lobe, {along, outgoing, incoming}) ==
              fibre::scattered(lobe, {along, outgoing, incoming}));
    }
}

TEST_CASE("the Hair BSDF's directions come as often as its density says, which is its brightness where it is lit") {
    for (const Lobe::Kind kind : {Lobe::Kind::FibreReflection, Lobe::Kind::FibreTransmission})
        for (const auto& [roughness_along, roughness_around] : {std::pair{0.3f, 0.4f}, {0.15f, 1.0f}})
            for (const float degrees : {0.0f, 50.0f}) {
                const Lobe lobe = of_hair_bsdf(kind, roughness_along, roughness_around, 0.2f);
                const vec3 outgoing = viewer_at(degrees);
                check_directions({.lobes = {&lobe, 1}, .normal = normal_at(0.2f, outgoing), .outgoing = outgoing});
                const vec3 side = orthonormal_basis(along).second;
                for (const float towards : {0.3f, -0.3f}) {
                    const vec3 incoming = glm::normalize(side + towards * outgoing + 0.2f * along);
                    const bool is_lit = (towards > 0.0f) == (kind == Lobe::Kind::FibreReflection);
                    const float seen = fibre::scattered(lobe, {along, outgoing, incoming});
                    if (is_lit)
                        CHECK(seen == fibre::pdf_per_sr(lobe, {along, outgoing, incoming}));
                }
            }
}

TEST_CASE("hair without a direction, or of absurd numbers, is finite") {
    const float nan = std::nanf("");
    for (const float wild : {nan, -5.0f, 0.0f, 1e30f})
        for (const LobeModel model : {LobeModel::HairOfColour, LobeModel::HairOfMelanin, LobeModel::HairOfAbsorption,
                                      LobeModel::HairReflection, LobeModel::HairTransmission})
            for (std::size_t input = 1; input < input_count(model); ++input) {
                CAPTURE(wild);
                CAPTURE(input);
                CAPTURE(static_cast<int>(model));
                LobeInputs inputs{};
                inputs.fill(Rgb(0.4f));
                inputs[input] = Rgb(wild);
                SurfaceClosures closures;
                Lobes lobes;
                const vec3 outgoing = glm::normalize(vec3(0.2f, 0.1f, 1.0f));
                add_lobes({.model = model}, inputs, {}, closures, &lobes, {.outgoing = outgoing});
                const LobeSet set{.lobes = lobes, .normal = {0, 0, 1}, .outgoing = outgoing};
                for (std::uint32_t index = 0; index < 50; ++index) {
                    const vec3 incoming =
                        set.has_directions() ? set.sample({unit(hash(3, index)), unit(hash(4, index))}) : vec3(0, 0, 1);
                    CHECK(glm::length(incoming) == close_to(1.0, 1e-3));
                    const Rgb sent = set.per_irradiance(incoming);
                    CHECK(std::isfinite(sent.x + sent.y + sent.z));
                    CHECK(std::isfinite(set.pdf_per_sr(incoming)));
                }
                add_lobes({.model = model}, inputs, {}, closures, nullptr, {.outgoing = outgoing});
                CHECK(std::isfinite(closures.diffuse_albedo.x));
            }
}
} // namespace hair_test
