// SPDX-License-Identifier: GPL-3.0-or-later
// An equirectangular sky: what it shows where, and that importance sampling neither loses nor invents light.
#include "core/errors.hpp"
#include "core/sampling.hpp"
#include "core/sobol.hpp"
#include "scene/world.hpp"
#include "support/chi_square.hpp"
#include "support/environment_images.hpp"
#include <algorithm>
#include <doctest/doctest.h>

namespace world_test {
using namespace tyndall;

/// A dim sky, a bright sun of one texel and a black ground.
static std::vector<Rgb> sky_colours(std::uint32_t width = 16, std::uint32_t height = 8) {
    std::vector<Rgb> colours;
    for (std::uint32_t row = 0; row < height; ++row)
        for (std::uint32_t column = 0; column < width; ++column)
            colours.push_back(row < height / 2 ? Rgb(0.0f) : Rgb(0.1f, 0.2f, 0.1f * static_cast<float>(column)));
    colours[(height * 3 / 4) * width + 2] = Rgb(500.0f, 400.0f, 300.0f);
    return colours;
}
static std::shared_ptr<const EnvironmentImage> sky(std::uint32_t width = 16, std::uint32_t height = 8) {
    return support::environment_image(width, height, sky_colours(width, height));
}
static const glm::mat3 turn(glm::rotate(glm::mat4(1.0f), 1.0f, glm::vec3(0.3f, 0.5f, 1.0f)));

/// Calls visit(direction, solid angle) for a fine grid of the sphere.
template <typename Visit>
static void over_sphere(int rows, const Visit& visit) {
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < 2 * rows; ++column) {
            const double z = -1.0 + 2.0 * (row + 0.5) / rows, longitude = std::numbers::pi * (column + 0.5) / rows;
            const double radius = std::sqrt(1.0 - z * z);
            visit(vec3(dvec3(radius * std::cos(longitude), radius * std::sin(longitude), z)),
                  2.0 * std::numbers::pi / (rows * rows));
        }
}

TEST_CASE("Blender's convention: +X is the image's middle, +Y lies left of it, up is the top row") {
    // Columns from left: -X to +Y, +Y to +X, +X to -Y, -Y to -X. Rows from below.
    const auto image = support::environment_image(
        4, 2, {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}, {0, 4, 0}});
    const World world("w", Rgb(1.0f), image);
    const auto texel_centre = [](double longitude, double latitude) {
        return vec3(dvec3(std::cos(longitude) * std::cos(latitude), std::sin(longitude) * std::cos(latitude),
                          std::sin(latitude)));
    };
    CHECK(glm::distance(world.radiance(texel_centre(0.25 * std::numbers::pi, 0.25 * std::numbers::pi)), Rgb(0, 2, 0)) <
          1e-5f);
    CHECK(glm::distance(world.radiance(texel_centre(-0.25 * std::numbers::pi, 0.25 * std::numbers::pi)), Rgb(0, 3, 0)) <
          1e-5f);
    CHECK(glm::distance(world.radiance(texel_centre(0.75 * std::numbers::pi, -0.25 * std::numbers::pi)), Rgb(1, 0, 0)) <
          1e-5f);
    CHECK(glm::distance(world.radiance(texel_centre(0.0, -0.25 * std::numbers::pi)), Rgb(2.5f, 0, 0)) < 1e-5f);
    CHECK(glm::distance(world.radiance(texel_centre(std::numbers::pi, -0.25 * std::numbers::pi)), Rgb(2.5f, 0, 0)) <
          1e-5f); // across the seam
}
TEST_CASE("the PDF integrates to 1, for a colour, an image and a black image") {
    const auto black = support::environment_image(16, 8, std::vector<Rgb>(16 * 8, Rgb(0.0f)));
    for (const World& world :
         {World("colour", Rgb(1, 2, 3)), World("image", Rgb(1.0f), sky(), turn), World("black", Rgb(1.0f), black)}) {
        CAPTURE(world.name());
        double integral = 0.0;
        over_sphere(1000,
                    [&](vec3 direction, double solid_angle) { integral += world.pdf_per_sr(direction) * solid_angle; });
        CHECK(std::abs(integral - 1.0) < 2e-3); // the midpoints of 4 million boxes know a texel's edge no better
        CHECK(world.is_black() == (world.name() == "black"));
    }
}
TEST_CASE("directions fall where the PDF says, by chi-square, and the PDF of a sample is that of its direction") {
    const World world("image", Rgb(1.0f), sky(), turn);
    constexpr int rows = 24, fine = 20;
    std::vector<double> observed(rows * rows * 2), expected(observed.size());
    const auto cell = [](vec3 d) {
        const int row = std::min(rows - 1, static_cast<int>((d.z + 1.0f) * 0.5f * rows));
        const double longitude = std::atan2(-d.y, -d.x) / (2.0 * std::numbers::pi) + 0.5;
        return static_cast<std::size_t>(row * 2 * rows +
                                        std::min(2 * rows - 1, static_cast<int>(longitude * 2 * rows)));
    };
    constexpr std::uint32_t count = 40000;
    over_sphere(rows * fine,
                [&](vec3 d, double solid_angle) { expected[cell(d)] += count * solid_angle * world.pdf_per_sr(d); });
    for (std::uint32_t index = 0; index < count; ++index) {
        const auto bits = pcg4d({index, 7, 7, 7});
        const World::DirectionSample sample = world.sample({unit_float(bits[0]), unit_float(bits[1])});
        observed[cell(sample.direction)] += 1.0;
        const float pdf = world.pdf_per_sr(sample.direction);
        const bool is_on_an_edge = bits[0] % 97 == 0; // rounding may put such a direction into the next texel
        if (!is_on_an_edge && std::abs(pdf / sample.pdf_per_sr - 1.0f) > 1e-4f)
            FAIL_CHECK("a sample's PDF is ", sample.pdf_per_sr, ", its direction's ", pdf);
    }
    CHECK(support::is_plausible(support::chi_square_p_value(observed, expected), 1));
}
// Seen to fail with the PDF of the texel alone: the sun's bilinear skirt over the black ground is lost.
TEST_CASE("sampled light adds up to the light that is there, the bilinear skirt of the sun included") {
    for (const bool is_alone : {false, true}) {
        std::vector<Rgb> colours = sky_colours();
        if (is_alone) // nothing but the sun, so that all around it only its skirt shines
            for (Rgb& colour : colours)
                colour = colour.x > 1.0f ? colour : Rgb(0.0f);
        const World world("image", Rgb(2.0f), support::environment_image(16, 8, colours), turn);
        dvec3 exact(0.0), sampled(0.0);
        over_sphere(
            2000, [&](vec3 direction, double solid_angle) { exact += dvec3(world.radiance(direction)) * solid_angle; });
        constexpr std::uint32_t count = 1 << 16;
        for (std::uint32_t index = 0; index < count; ++index) {
            const World::DirectionSample sample = world.sample(sobol_point(index, 1));
            sampled += dvec3(sample.radiance) / (double{sample.pdf_per_sr} * count);
        }
        CHECK(glm::length(sampled / exact - 1.0) < 3e-3);
    }
}
TEST_CASE("pixels that are not finite are black; a world that cannot be is named") {
    std::vector<Rgb> colours = sky_colours();
    colours[100] = Rgb(std::numeric_limits<float>::quiet_NaN(), 1, 1);
    colours[101] = Rgb(std::numeric_limits<float>::infinity());
    const World world("W", Rgb(1.0f), support::environment_image(16, 8, colours));
    for (std::uint32_t index = 0; index < 1000; ++index)
        CHECK(glm::length(world.sample(sobol_point(index, 2)).radiance) < 1e4f);
    CHECK_THROWS_WITH_AS(World("W", Rgb(std::nanf(""))), "world 'W': its radiance is not finite", InvalidInput);
    colours.pop_back();
    CHECK_THROWS_AS(World("W", Rgb(1.0f), support::environment_image(16, 8, colours)), InvalidInput);
}

TEST_CASE("cameras may see another image than the one that gives light") {
    const std::shared_ptr<const EnvironmentImage> lit = sky(), seen = sky(8, 4);
    const World world("world", Rgb(2.0f), lit, turn, {.image = seen}), as_lit("lit", Rgb(2.0f), lit, turn),
        as_seen("seen", Rgb(2.0f), seen, turn);
    for (const vec3& direction : {vec3(1, 0, 0), vec3(0, 0, 1), glm::normalize(vec3(-1, 2, 0.5f))}) {
        CHECK(world.radiance(direction) == as_lit.radiance(direction));
        CHECK(world.seen_radiance(direction) == as_seen.radiance(direction));
        CHECK(as_lit.seen_radiance(direction) == as_lit.radiance(direction));
        CHECK(world.pdf_per_sr(direction) == as_lit.pdf_per_sr(direction));
    }
    CHECK(!world.shines_as(as_lit));
    const auto short_one = support::environment_image(8, 4, std::vector<Rgb>(31));
    CHECK_THROWS_AS(World("world", Rgb(1.0f), lit, turn, SeenWorld{.image = short_one}), InvalidInput);
}
} // namespace world_test
