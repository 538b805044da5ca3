// SPDX-License-Identifier: GPL-3.0-or-later
// Skies by what physics says of them: columns of air, symmetry, the colours of molecules, aerosols and ozone.
#include "core/errors.hpp"
#include "shading/direction_program.hpp"
#include "shading/sky/sky_model.hpp"
#include "support/close_to.hpp"
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <numbers>

namespace sky_test {
using namespace tyndall;
using tyndall::support::close_to;
using namespace tyndall::sky;
constexpr float degree = std::numbers::pi_v<float> / 180.0f;
constexpr std::array models = {Model::SingleScattering3, Model::SingleScattering, Model::MultipleScattering};

static vec3 at(const std::vector<vec3>& pixels, std::uint32_t column, std::uint32_t row) {
    return pixels[row * picture_width + column];
}

TEST_CASE("without air the sun is white at every height, and the sky is black") {
    const Air none{.altitude_m = 0.0f, .molecules = 0.0f, .aerosols = 0.0f, .ozone = 0.0f};
    for (const Model model : models) {
        const vec3 high = sun_irradiance_xyz(model, none, 90.0f * degree),
                   low = sun_irradiance_xyz(model, none, 5.0f * degree);
        CHECK(glm::distance(high, low) < 1e-4f * glm::length(high));
        CHECK(high.y > 100.0f);
        if (model != Model::MultipleScattering) // whose ground shines
            CHECK(glm::length(at(picture(model, none, 1.0f, Progress()), 100, 200)) == 0.0f);
    }
}
TEST_CASE("what dims the sun multiplies: twice the aerosols take the square of the share that one lets pass") {
    for (const Model model : models)
        for (const float elevation : {90.0f, 20.0f}) {
            const auto luminance = [&](float aerosols) {
                return sun_irradiance_xyz(model, {.molecules = 0.0f, .aerosols = aerosols, .ozone = 0.0f},
                                          elevation * degree)
                    .y;
            };
            const float once = luminance(1.0f) / luminance(0.0f), twice = luminance(2.0f) / luminance(0.0f);
            CHECK(twice == close_to(once * once, 0.01));
            CHECK(once < 0.99f);
        }
}
TEST_CASE("aerosols that thin out by a height let pass exp(-extinction * height) of a sun at the zenith") {
    const Air aerosols{.altitude_m = 1.0f, .molecules = 0.0f, .aerosols = 1.0f, .ozone = 0.0f};
    const Air none{.altitude_m = 1.0f, .molecules = 0.0f, .aerosols = 0.0f, .ozone = 0.0f};
    const float passing = sun_irradiance_xyz(Model::SingleScattering, aerosols, 90.0f * degree).y /
                          sun_irradiance_xyz(Model::SingleScattering, none, 90.0f * degree).y;
    CHECK(passing == close_to(std::exp(-1.11 * 2e-5 * 1200.0), 0.01));
}
TEST_CASE("both sides of the sun look alike, and it is brightest beside it") {
    for (const Model model : models) {
        const auto pixels = picture(model, {.altitude_m = 100.0f}, 20.0f * degree, Progress());
        REQUIRE(pixels.size() == picture_width * picture_height);
        for (const std::uint32_t row : {60u, 130u, 170u, 250u})
            for (const std::uint32_t column : {0u, 17u, 200u, 255u}) {
                CHECK(at(pixels, column, row) == at(pixels, picture_width - 1 - column, row));
                CHECK(std::isfinite(glm::length(at(pixels, column, row))));
                if (row > 128 && row < 200)
                    CHECK(at(pixels, 255, row).y >= at(pixels, column, row).y);
            }
    }
}
TEST_CASE("a high sun's sky is blue, a low sun red; ozone makes twilight bluer") {
    for (const Model model : models) {
        const auto noon = picture(model, {}, 60.0f * degree, Progress());
        CHECK(at(noon, 0, 200).z > 1.2f * at(noon, 0, 200).x);
        const vec3 low = sun_irradiance_xyz(model, {}, 1.0f * degree), high = sun_irradiance_xyz(model, {}, 1.0f);
        CHECK(low.z / low.x < 0.5f * high.z / high.x);
        const vec3 without = at(picture(model, {.ozone = 0.0f}, -3.0f * degree, Progress()), 0, 250),
                   with = at(picture(model, {.ozone = 2.0f}, -3.0f * degree, Progress()), 0, 250);
        CHECK(with.z / with.x > 1.1f * without.z / without.x);
    }
}
TEST_CASE("a setting that is no number, or less than no air, is refused") {
    CHECK_THROWS_AS(static_cast<void>(sun_irradiance_xyz(Model::SingleScattering, {.molecules = -1.0f}, 1.0f)),
                    InvalidInput);
    CHECK_THROWS_AS(
        static_cast<void>(picture(Model::MultipleScattering, {}, std::numeric_limits<float>::quiet_NaN(), Progress())),
        InvalidInput);
}
TEST_CASE("a program of directions reads each as its point, and images hold the middles of their texels") {
    Material material{.name = "directions"};
    material.program = {{.code = SurfaceOp::Code::Input, .option = 0, .out = 0},
                        {.code = SurfaceOp::Code::Input, .option = 14, .selector = 1, .out = 1},
                        {.code = SurfaceOp::Code::Add, .out = 0, .a = 0, .b = 1}};
    const DirectionProgram program(material);
    const vec3 towards(0.6f, 0.0f, 0.8f);
    CHECK(program.radiance(towards, RayKind::Diffuse) == Rgb(0.6f, 0.0f, 0.8f));
    CHECK(program.radiance(towards, RayKind::Camera) == Rgb(1.6f, 1.0f, 1.8f)); // it asks for camera rays
    const std::vector<Rgb> image = program.image(8, 4, RayKind::Camera, Progress());
    const float latitude = -0.375f * std::numbers::pi_v<float>, longitude = 0.875f * std::numbers::pi_v<float>;
    const Rgb first = 1.0f + vec3(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                                  std::sin(latitude));
    CHECK(glm::distance(image[0], glm::max(first, 0.0f)) < 1e-5f);
}
} // namespace sky_test
