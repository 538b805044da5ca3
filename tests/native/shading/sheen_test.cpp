// SPDX-License-Identifier: GPL-3.0-or-later
// What sheen must be wherever its numbers come from: its albedo, all of it above the surface, and drawn as it reflects.
#include "core/random.hpp"
#include "shading/lobes/lobe_models.hpp"
#include "shading/lobes/lobe_set.hpp"
#include "shading/lobes/sheen.hpp"
#include "shading/material.hpp"
#include "support/angles.hpp"
#include "support/chi_square.hpp"
#include "support/close_to.hpp"
#include <doctest/doctest.h>
#include <functional>
#include <numbers>

namespace sheen_test {
using namespace tyndall;
using support::at_angle;
using tyndall::support::close_to;

namespace {
constexpr vec3 up(0, 0, 1);
constexpr Rgb white(1.0f), none(0.0f);

/// Over the hemisphere, by a grid that is even in azimuth and in the root of the height: sheen lies along the surface.
double over_hemisphere(const std::function<double(const vec3&)>& value, int side = 300) {
    double sum = 0.0;
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const double root = (row + 0.5) / side, around = 2.0 * std::numbers::pi * (column + 0.5) / side;
            const double height = root * root, sine = std::sqrt(1.0 - height * height);
            sum += 2.0 * root * value(vec3(sine * std::cos(around), sine * std::sin(around), height));
        }
    return sum * 2.0 * std::numbers::pi / (static_cast<double>(side) * side);
}

double albedo(const LobeSet& set) {
    return over_hemisphere([&](const vec3& incoming) { return set.per_irradiance(incoming).x * incoming.z; });
}

SurfaceClosures built(LobeModel model, const std::vector<Rgb>& inputs, const vec3& outgoing, Lobes& lobes,
                      const vec3& normal = vec3(0.0f)) {
    LobeInputs values{};
    REQUIRE(inputs.size() == input_count(model));
    std::ranges::copy(inputs, values.begin());
    ShadingPoint point;
    point.view_cosine = std::max(outgoing.z, 0.0f);
    SurfaceClosures closures;
    closures.transparent = Rgb(0.25f); // of transmission: see below
    add_lobes({.model = model}, values, point, closures, &lobes, {.diffuse = normal, .outgoing = outgoing});
    return closures;
}

/// Principled, white and diffuse, below a sheen of this colour.
std::vector<Rgb> white_below(const Rgb& sheen, float roughness) {
    return {white, white,     none,      Rgb(0.5f), none, white, none,  Rgb(1.5f),
            none,  Rgb(0.5f), Rgb(1.5f), white,     none, none,  sheen, Rgb(roughness)};
}
} // namespace

TEST_CASE("a sheen sends back its albedo, and nothing comes from below the surface") {
    for (const float roughness : {0.15f, 0.5f, 1.0f})
        for (const float degrees : {0.0f, 55.0f, 84.0f, 89.9f}) {
            CAPTURE(roughness);
            CAPTURE(degrees);
            const vec3 outgoing = at_angle(degrees, 0.7f);
            const sheen::Shape shape = sheen::shape(roughness, outgoing.z);
            Lobe lobe{.kind = Lobe::Kind::Sheen, .alpha = shape.a, .ior = shape.b, .weight = white};
            const LobeSet set{.lobes = {&lobe, 1}, .normal = up, .outgoing = outgoing};
            CHECK(albedo(set) == close_to(1.0, 2e-3));
            CHECK(set.per_irradiance(at_angle(95.0f)) == none);
        }
}

TEST_CASE("rougher sheen is brighter, and brighter the flatter it is seen") {
    for (const float roughness : {0.2f, 0.5f, 0.9f})
        for (const float cosine : {0.05f, 0.4f, 0.8f}) {
            const float here = sheen::shape(roughness, cosine).albedo;
            CHECK(here > 0.0f);
            CHECK(sheen::shape(roughness + 0.1f, cosine).albedo > here);
            CHECK(sheen::shape(roughness, cosine - 0.05f).albedo > here);
        }
    CHECK(sheen::shape(1.0f, 0.0f).albedo < 0.8f);
    CHECK(sheen::shape(5.0f, 2.0f).albedo == sheen::shape(1.0f, 1.0f).albedo); // clamped
    CHECK(sheen::shape(-1.0f, -1.0f).albedo == sheen::shape(sheen::least_roughness, 0.0f).albedo);
}

TEST_CASE("a white surface below a white sheen is white") {
    for (const float degrees : {0.0f, 60.0f, 80.0f}) {
        Lobes lobes;
        const vec3 outgoing = at_angle(degrees);
        const SurfaceClosures closures = built(LobeModel::PrincipledSheen, white_below(white, 0.6f), outgoing, lobes);
        CHECK(closures.diffuse_albedo.x + albedo({.lobes = lobes, .normal = up, .outgoing = outgoing}) ==
              close_to(1.0, 2e-3));
    }
}

TEST_CASE("what lies below is dimmed by the strongest channel of the sheen alike") {
    const Rgb tint(0.9f, 0.4f, 0.0f);
    const vec3 outgoing = at_angle(70.0f);
    const float share = sheen::shape(0.6f, outgoing.z).albedo;
    Lobes lobes;
    std::vector<Rgb> inputs = white_below(tint, 0.6f);
    inputs[principled_emission] = Rgb(2.0f, 3.0f, 4.0f);
    const SurfaceClosures closures = built(LobeModel::PrincipledSheen, inputs, outgoing, lobes);
    for (int channel = 0; channel < 3; ++channel) {
        CHECK(closures.diffuse_albedo[channel] == close_to(1.0f - 0.9f * share, 1e-5));
        CHECK(closures.emission[channel] ==
              close_to((2.0f + static_cast<float>(channel)) * (1.0f - 0.9f * share), 1e-5));
        CHECK(lobes.at(0).weight[channel] == close_to(tint[channel] * share, 1e-5));
    }
    inputs[6] = Rgb(0.25f); // what lets light pass is among what is transparent already
    lobes.clear();
    const Rgb passing = built(LobeModel::PrincipledSheen, inputs, outgoing, lobes).transparent;
    inputs[14] = none;
    lobes.clear();
    CHECK(passing.x ==
          close_to((1.0f - 0.9f * share) * built(LobeModel::PrincipledSheen, inputs, outgoing, lobes).transparent.x,
                   1e-5));
}

TEST_CASE("directions come as often as a sheen reflects there, and no density is above its bound") {
    for (const float roughness : {0.12f, 0.35f, 0.8f})
        for (const float degrees : {0.0f, 50.0f, 80.0f})
            for (const vec3& normal : {vec3(0.0f), at_angle(30.0f, 2.0f)}) {
                CAPTURE(roughness);
                CAPTURE(degrees);
                CAPTURE(normal.x);
                const vec3 outgoing = at_angle(degrees, 0.4f);
                Lobes lobes;
                built(LobeModel::Sheen, {white, white, Rgb(roughness)}, outgoing, lobes, normal);
                if (lobes.empty()) // hardly any comes back
                    continue;
                const vec3 axis = lobes[0].has_own_normal() ? normal : up;
                const LobeSet set{.lobes = lobes, .normal = axis, .outgoing = outgoing};
                // Seen around its own normal, where all of it is.
                const auto [tangent, bitangent] = orthonormal_basis(axis);
                const auto to_world = [&, t = tangent, b = bitangent](const vec3& d) {
                    return d.x * t + d.y * b + d.z * axis;
                };
                const float most = sheen::most_pdf_per_sr(lobes[0].alpha, lobes[0].ior);
                double above_most = 0.0, lowest = 1.0;
                constexpr int rows = 12, columns = 8, fine = 24;
                constexpr std::uint32_t count = 100'000;
                std::vector<double> expected(rows * columns), observed(rows * columns);
                const auto cell = [](double root, double around) {
                    return static_cast<std::size_t>(std::min(rows - 1, static_cast<int>(root * rows)) * columns +
                                                    std::min(columns - 1, static_cast<int>(around * columns)));
                };
                for (int row = 0; row < rows * fine; ++row)
                    for (int column = 0; column < columns * fine; ++column) {
                        const double root = (row + 0.5) / (rows * fine), turn = (column + 0.5) / (columns * fine);
                        const double height = root * root, sine = std::sqrt(1.0 - height * height);
                        const vec3 direction = to_world(vec3(sine * std::cos(2.0 * std::numbers::pi * turn),
                                                             sine * std::sin(2.0 * std::numbers::pi * turn), height));
                        const float pdf = set.pdf_per_sr(direction);
                        above_most = std::max(above_most, static_cast<double>(pdf / most));
                        expected[cell(root, turn)] +=
                            pdf * count * 2.0 * root * 2.0 * std::numbers::pi / (rows * fine * columns * fine);
                    }
                for (std::uint32_t index = 0; index < count; ++index) {
                    const auto unit = [](std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; };
                    const vec3 drawn = set.sample({unit(hash(1, index)), unit(hash(2, index))});
                    const double height = glm::dot(drawn, axis);
                    lowest = std::min(lowest, height);
                    double turn =
                        std::atan2(glm::dot(drawn, bitangent), glm::dot(drawn, tangent)) / (2.0 * std::numbers::pi);
                    turn -= std::floor(turn);
                    observed[cell(std::sqrt(std::max(height, 0.0)), turn)] += 1.0;
                }
                double promised = 0.0;
                for (const double one : expected)
                    promised += one / count;
                CHECK(promised == close_to(1.0, 3e-3));
                CHECK(above_most <= 1.0);
                CHECK(lowest >= 0.0);
                CHECK(support::chi_square_p_value(observed, expected) > 1e-4);
                // What is reflected is the density, times what is reflected of all.
                const vec3 incoming = to_world(at_angle(60.0f, 1.0f));
                CHECK(set.per_irradiance(incoming).x * glm::dot(axis, incoming) ==
                      close_to(lobes[0].weight.x * set.pdf_per_sr(incoming), 1e-4));
            }
}

TEST_CASE("a roughness that is no number is none") {
    Lobes lobes;
    built(LobeModel::Sheen, {white, white, Rgb(std::nanf(""))}, at_angle(89.9f), lobes);
    for (const Lobe& lobe : lobes)
        CHECK(lobe.weight.x == sheen::shape(0.0f, at_angle(89.9f).z).albedo);
}

TEST_CASE("a sheen that is seen from behind its own normal is as bright as along it") {
    const vec3 outgoing = at_angle(60.0f), normal = at_angle(-50.0f); // 110 degrees apart
    Lobes lobes;
    built(LobeModel::Sheen, {white, white, Rgb(0.5f)}, outgoing, lobes, normal);
    REQUIRE(lobes.size() == 1);
    CHECK(lobes[0].weight.x == close_to(sheen::shape(0.5f, 0.0f).albedo, 1e-5));
    const LobeSet set{.lobes = lobes, .normal = up, .outgoing = outgoing};
    const vec3 incoming = at_angle(-20.0f, 0.3f);
    CHECK(set.pdf_per_sr(incoming) > 0.0f);
    CHECK(set.per_irradiance(incoming).x * incoming.z == close_to(lobes[0].weight.x * set.pdf_per_sr(incoming), 1e-4));
}
} // namespace sheen_test
