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

TEST_CASE("what nothing of a point decides is known without a program: of all such materials, and of no other") {
    Material mixed = disc_alpha();
    mixed.program = {{.code = SurfaceOp::Code::Constant, .out = 0, .value = Rgb(0.5f, 0.75f, 1.0f)},
                     {.code = SurfaceOp::Code::Multiply, .out = 1, .a = 0, .b = 0},
                     {.code = SurfaceOp::Code::Texture, .out = 2}}; // of what scatters the rest
    mixed.diffuse_register = 2;
    mixed.transparent_register = 1;
    const TransparencyLookup lookup(mixed);
    REQUIRE(lookup.constant());
    CHECK(*lookup.constant() == at(lookup, {}, false));
    CHECK(*lookup.constant() == Rgb(0.25f, 0.5625f, 1.0f));
    const Material even{.name = "even", .constant = {.transparent = Rgb(0.3f)}};
    CHECK(TransparencyLookup(even).constant() == Rgb(0.3f));
    for (const Material& other : {disc_alpha(), gradient_alpha(), one_way()})
        CHECK_FALSE(TransparencyLookup(other).constant());
}

/// What passes is the image's colour: a stained pane.
static Material pane() {
    Texture texture{.name = "pane", .width = 5, .height = 3};
    std::vector<std::uint8_t> texels;
    for (int index = 0; index < 60; ++index)
        texels.push_back(static_cast<std::uint8_t>(41 * index % 256));
    texture.bytes = std::move(texels);
    Material material{.name = "pane"};
    material.program = {{.code = SurfaceOp::Code::Texture, .out = 0},
                        {.code = SurfaceOp::Code::Constant, .out = 1, .value = Rgb(0.9f, 0.5f, 0.7f)},
                        {.code = SurfaceOp::Code::Multiply, .out = 2, .a = 0, .b = 1}};
    material.transparent_register = 2, material.diffuse_register = material.emission_register = 3;
    material.textures = {std::make_shared<const Texture>(std::move(texture))};
    material.uv_map_names = {""};
    return material;
}

TEST_CASE("a pane in an image's colours needs no program, channel by channel; one that mixes or bends them does") {
    const Material material = pane();
    const TransparencyLookup lookup(material);
    REQUIRE(lookup.is_straight_by_channel());
    CHECK(!lookup.is_straight());
    for (float u = -1.5f; u < 2.0f; u += 0.017f) {
        const vec2 uv(u, 1.3f * u);
        const Rgb by_program = at(lookup, {&uv, 1}, false);
        for (int channel = 0; channel < 3; ++channel)
            CHECK(std::abs(lookup.at(uv, channel) - by_program[channel]) < 1e-6f);
    }
    const auto needs_program = [](const SurfaceOp& last, bool has_alpha = false, bool is_float = false) {
        Material other = pane();
        other.program.push_back(last);
        other.transparent_register = last.out;
        Texture texture = *other.textures[0];
        texture.has_alpha = has_alpha;
        if (is_float)
            texture.floats = std::vector<float>(60, 2.0f), texture.bytes = {};
        other.textures = {std::make_shared<const Texture>(std::move(texture))};
        return !TransparencyLookup(other).is_straight_by_channel();
    };
    const SurfaceOp same{.code = SurfaceOp::Code::Clamp, .out = 4, .a = 2};
    CHECK(!needs_program(same));
    CHECK(needs_program({.code = SurfaceOp::Code::Multiply, .out = 4, .a = 2, .b = 2}));
    CHECK(needs_program({.code = SurfaceOp::Code::Average, .out = 4, .a = 2}));
    CHECK(needs_program({.code = SurfaceOp::Code::TextureAlpha, .out = 4}));
    CHECK(needs_program(same, true));
    CHECK(needs_program(same, false, true));
}
} // namespace transparency_lookup_test
