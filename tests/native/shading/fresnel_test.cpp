// SPDX-License-Identifier: GPL-3.0-or-later
// What a dielectric mirrors, against what Fresnel's equations come to where they are short.
#include "core/errors.hpp"
#include "shading/fresnel.hpp"
#include "shading/surface_program.hpp"
#include "support/close_to.hpp"
#include <doctest/doctest.h>

namespace fresnel_test {
using namespace tyndall;
using tyndall::support::close_to;

TEST_CASE(
    "seen straight a dielectric mirrors ((n - 1) / (n + 1))^2, grazing all, and in Brewster's angle half of one") {
    for (const double ior : {1.001, 1.33, 1.5, 2.4, 20.0}) {
        CAPTURE(ior);
        const auto index = static_cast<float>(ior);
        const double straight = (ior - 1) / (ior + 1) * (ior - 1) / (ior + 1);
        CHECK(std::abs(fresnel_dielectric(1.0f, index) - straight) < 1e-6);
        CHECK(fresnel_dielectric(0.0f, index) == 1.0f);
        // There tan = n, and light that swings along the plane of incidence is not mirrored at all.
        const auto brewster = static_cast<float>(1.0 / std::sqrt(1.0 + ior * ior));
        const double across = (ior * ior - 1) / (ior * ior + 1);
        CHECK(std::abs(fresnel_dielectric(brewster, index) - 0.5 * across * across) < 1e-6);
    }
    CHECK(fresnel_dielectric(0.5f, 1.0f) == 0.0f); // nothing but air
    CHECK(fresnel_dielectric(0.0f, 1.0f) == 1.0f);
}

TEST_CASE("the rise goes from 0 to 1, and a dielectric's own share rises by it") {
    for (const float ior : {0.0f, 1.3f, 1.5f}) {
        CHECK(fresnel_rise(1.0f, ior) == 0.0f);
        CHECK(fresnel_rise(0.0f, ior) == close_to(1.0, 1e-5));
    }
    const float straight = fresnel_dielectric(1.0f, 1.5f);
    CHECK(straight + (1.0f - straight) * fresnel_rise(0.3f, 1.5f) == close_to(fresnel_dielectric(0.3f, 1.5f), 1e-6));
    CHECK(fresnel_rise(0.5f, 0.0f) == 0.03125f);
}

TEST_CASE("a program's gloss is what its registers say, and a broken one is named") {
    const auto constant = [](std::uint16_t out, float value) {
        SurfaceOp op;
        op.out = out;
        op.value = Rgb(value);
        return op;
    };
    Material material{.name = "gold"};
    material.program = {constant(0, 0.0f), constant(1, 0.5f), constant(2, 1.0f), constant(3, 0.25f),
                        constant(4, 0.75f)};
    material.gloss = GlossLayers{.facing_register = 1,
                                 .edge_register = 2,
                                 .coat_register = 3,
                                 .coated_register = 4,
                                 .mirror_ior = 0.0f,
                                 .coat_ior = 1.5f};
    validate(material);
    ProgramPoint point;
    point.surface.view_cosine = 0.5f;
    const float by_coat = fresnel_dielectric(0.5f, 1.5f);
    const SurfaceClosures closures = evaluate(material, point, {});
    CHECK(closures.mirrored.x == close_to(0.5 + 0.5 * 0.03125 + 0.25 * by_coat, 1e-5));
    CHECK(closures.diffuse_albedo.x == close_to(0.75 * (1 - by_coat), 1e-5));
    material.gloss->coat_register = 64;
    CHECK_THROWS_WITH_AS(validate(material), doctest::Contains("\"gold\" uses register 64"), InvalidInput);
    material.gloss->coat_register = 3;
    material.gloss->mirror_ior = 0.5f;
    CHECK_THROWS_WITH_AS(validate(material), doctest::Contains("mirror_ior of 0.5"), InvalidInput);
}
} // namespace fresnel_test
