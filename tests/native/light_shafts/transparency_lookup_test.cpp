// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/transparency_lookup.hpp"
#include "support/partial_materials.hpp"
#include <doctest/doctest.h>

namespace transparency_lookup_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

static Rgb at(const TransparencyLookup& lookup, std::span<const vec2> uvs, bool is_backface) {
    return lookup.at({.surface = {.is_backface = is_backface}}, uvs);
}

TEST_CASE("a texel's class is what the program says of every point around it") {
    const Material material = disc_alpha(TextureExtension::Clip);
    const TransparencyLookup lookup(material);
    REQUIRE(lookup.image() != nullptr);
    const auto size = static_cast<std::int32_t>(lookup.texture().width);
    int stopping = 0, passing = 0, mixed = 0;
    for (std::int32_t row = -TransparencyLookup::margin; row <= size; row += 7)
        for (std::int32_t column = -TransparencyLookup::margin; column <= size; column += 3) {
            const TexelClass found = lookup.classify(false, column, row);
            const std::ptrdiff_t place = std::ptrdiff_t{row + TransparencyLookup::margin} * lookup.class_columns() +
                                         column + TransparencyLookup::margin;
            CHECK(lookup.classes(true)[place] == static_cast<std::uint8_t>(found)); // no side is told from the other
            stopping += found == TexelClass::Stops;
            passing += found == TexelClass::Passes;
            mixed += found == TexelClass::Mixed;
            for (const vec2 inside : {vec2(0.51f), vec2(0.6f, 1.4f), vec2(1.49f, 1.0f)}) {
                const vec2 uv = (vec2(column, row) + inside) / static_cast<float>(size);
                const float transmittance = at(lookup, {&uv, 1}, false).x;
                if (found != TexelClass::Mixed)
                    CHECK(transmittance == (found == TexelClass::Stops ? 0.0f : 1.0f));
            }
        }
    CHECK(stopping > 500);
    CHECK(passing > 1500);
    CHECK(mixed > 20);
}

TEST_CASE("opacity that is an image's alpha needs no program; a bent one does, and so does one that looks at sides") {
    const auto agrees = [](const Material& material) {
        const TransparencyLookup lookup(material);
        REQUIRE(lookup.is_straight());
        for (float u = 0.0f; u < 1.0f; u += 0.017f) {
            const vec2 uv(u, 1.3f * u);
            CHECK(glm::distance(lookup.at(uv), at(lookup, {&uv, 1}, true)) < 1e-6f);
        }
    };
    agrees(disc_alpha());
    agrees(gradient_alpha());
    Material tinted = gradient_alpha(); // what is left is a colour times 1 - alpha
    tinted.program.push_back({.code = SurfaceOp::Code::Constant, .out = 4, .value = Rgb(0.9f, 0.5f, 0.1f)});
    tinted.program.push_back({.code = SurfaceOp::Code::Multiply, .out = 5, .a = 2, .b = 4});
    tinted.transparent_register = 5;
    agrees(tinted);
    CHECK(TransparencyLookup(tinted).is_coloured());
    CHECK(!TransparencyLookup(disc_alpha()).is_coloured());

    Material bent = gradient_alpha();
    bent.program.push_back({.code = SurfaceOp::Code::Multiply, .out = 5, .a = 2, .b = 2});
    bent.transparent_register = 5;
    CHECK(!TransparencyLookup(bent).is_straight());
    const Material sides = one_way();
    const TransparencyLookup lookup(sides);
    CHECK(lookup.reads_facing());
    CHECK(lookup.image() == nullptr);
    CHECK(at(lookup, {}, false) == Rgb(0.0f));
    CHECK(at(lookup, {}, true) == Rgb(1.0f));
}
} // namespace transparency_lookup_test
