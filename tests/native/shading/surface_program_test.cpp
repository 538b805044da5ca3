// SPDX-License-Identifier: GPL-3.0-or-later
// A surface program is a calculator on colours: each operation is checked against what its name says.
#include "core/errors.hpp"
#include "shading/op_colour.hpp"
#include "shading/op_math.hpp"
#include "shading/surface_program.hpp"
#include <array>
#include <doctest/doctest.h>
#include <limits>

namespace surface_program_test {
using tyndall::Material;
using tyndall::ProgramPoint;
using tyndall::Rgb;
using tyndall::ShadingPoint;
using tyndall::SurfaceOp;
using tyndall::vec2;
using Code = tyndall::SurfaceOp::Code;

namespace {
SurfaceOp constant(std::uint16_t out, const Rgb& value) { return {.code = Code::Constant, .out = out, .value = value}; }

/// What register 3 holds after registers 0, 1 and 2 were set and `code` ran on them.
Rgb result_of(Code code, const Rgb& a, const Rgb& b = Rgb(0.0f), const Rgb& c = Rgb(0.0f), bool is_backface = false) {
    Material material{.name = "calculator"};
    material.program = {
        constant(0, a), constant(1, b), constant(2, c), {.code = code, .out = 3, .a = 0, .b = 1, .c = 2}};
    material.emission_register = 3;
    ProgramPoint point;
    point.surface.is_backface = is_backface;
    return evaluate(material, point, {}).emission;
}

std::shared_ptr<const tyndall::Texture> half_transparent_texel() {
    tyndall::Texture texture;
    texture.name = "leaf";
    texture.width = texture.height = 1;
    texture.floats = {0.25f, 0.5f, 0.75f, 0.5f};
    texture.is_srgb = false;
    texture.has_alpha = true;
    return std::make_shared<const tyndall::Texture>(std::move(texture));
}
} // namespace

TEST_CASE("each arithmetic operation does what its name says, channel by channel") {
    const Rgb a(0.5f, 1.0f, 2.0f), b(0.25f, 0.5f, 4.0f);
    CHECK(result_of(Code::Multiply, a, b) == Rgb(0.125f, 0.5f, 8.0f));
    CHECK(result_of(Code::Add, a, b) == Rgb(0.75f, 1.5f, 6.0f));
    CHECK(result_of(Code::Subtract, a, b) == Rgb(0.25f, 0.5f, -2.0f)); // as Cycles shows it
    CHECK(result_of(Code::Clamp, a) == Rgb(0.5f, 1.0f, 1.0f));
    CHECK(result_of(Code::Average, Rgb(1.0f, 2.0f, 6.0f)) == Rgb(3.0f));
}

TEST_CASE("mix goes from a to b and never beyond") {
    const Rgb a(1.0f, 2.0f, 3.0f), b(3.0f, 2.0f, 1.0f);
    CHECK(result_of(Code::Mix, a, b, Rgb(0.0f)) == a);
    CHECK(result_of(Code::Mix, a, b, Rgb(0.5f)) == Rgb(2.0f));
    CHECK(result_of(Code::Mix, a, b, Rgb(7.0f)) == b);
    CHECK(result_of(Code::Mix, a, b, Rgb(-7.0f)) == a);
}

TEST_CASE("backfacing tells the two sides of a surface apart") {
    CHECK(result_of(Code::Backfacing, Rgb(5.0f), {}, {}, false) == Rgb(0.0f));
    CHECK(result_of(Code::Backfacing, Rgb(5.0f), {}, {}, true) == Rgb(1.0f));
}

TEST_CASE("what passes a surface is a share of the light, even where a program says otherwise") {
    Material material{.name = "odd"};
    material.program = {constant(0, Rgb(-1.0f, 0.5f, 3.0f)),
                        constant(1, Rgb(std::numeric_limits<float>::quiet_NaN(), -1.0f, 3.0f))};
    material.transparent_register = 0;
    material.emission_register = 1;
    CHECK(evaluate(material, {}, {}).transparent == Rgb(0.0f, 0.5f, 1.0f));
    CHECK(evaluate(material, {}, {}).emission == Rgb(0.0f, -1.0f, 3.0f)); // which may be below 0
}

// Seen to fail: without the bound what glows leaves all around it dark, as the film counts light beyond 1e30 as none.
TEST_CASE("nothing glows so much that what it lights is beyond all measure") {
    Material constant_glow{.name = "glow"}, program_glow{.name = "glow"};
    constant_glow.constant.emission = Rgb(3e38f, 2.0f, -3e38f);
    program_glow.program = {constant(0, Rgb(3e38f, 2.0f, -3e38f))};
    CHECK(evaluate(constant_glow, {}, {}).emission == Rgb(1e18f, 2.0f, -1e18f));
    CHECK(constant_emission(constant_glow) == Rgb(1e18f, 2.0f, -1e18f));
    CHECK(evaluate(program_glow, {}, {}).emission == Rgb(1e18f, 2.0f, -1e18f));
}

TEST_CASE("an image's colour and alpha arrive in their registers, and a shadow ray reads the same transparency") {
    Material leaf{.name = "leaf"};
    leaf.textures = {half_transparent_texel()};
    leaf.uv_map_names = {""};
    leaf.program = {constant(0, Rgb(1.0f)),
                    {.code = Code::TextureAlpha, .out = 1},
                    {.code = Code::Subtract, .out = 2, .a = 0, .b = 1},
                    {.code = Code::Texture, .out = 3},
                    {.code = Code::Multiply, .out = 3, .a = 3, .b = 1}};
    leaf.transparent_register = 2;
    leaf.diffuse_register = 3;
    leaf.emission_register = 4; // never written: black
    const std::vector<vec2> uvs{vec2(0.5f)};
    const tyndall::SurfaceClosures closures = evaluate(leaf, {}, uvs);
    CHECK(closures.transparent == Rgb(0.5f));
    CHECK(closures.diffuse_albedo == Rgb(0.125f, 0.25f, 0.375f));
    CHECK(closures.emission == Rgb(0.0f));
    CHECK(evaluate_transparent(leaf, tyndall::TransparentOperations(leaf), {}, uvs) == closures.transparent);
}

TEST_CASE("UV maps are values, too, through their matrix") {
    Material material{.name = "painted"};
    material.program = {
        {.code = Code::Uv, .out = 0, .texture_uv = 1, .uv_matrix = glm::mat3(1, 0, 0, 0, 0, 2, 0, 5, 0)}};
    material.uv_map_names = {"other", "paint"};
    const std::array<vec2, 2> uvs{vec2(9, 9), vec2(0.25f, 0.5f)};
    CHECK(evaluate(material, {}, uvs).diffuse_albedo == Rgb(0.25f, 5.0f, 1.0f)); // u, 5, 2 v
    CHECK(has_coloured_transparency(material));
    material.program[0].texture_uv = 2;
    CHECK_THROWS_WITH_AS(validate(material), "material \"painted\" reads UV map 2 of 2", tyndall::InvalidInput);
}
TEST_CASE("programs of any length give shadow rays the transparency of the full evaluation") {
    for (const int length : {1, 62, 63, 64, 65, 200}) {
        CAPTURE(length);
        Material material{.name = "long"};
        material.program = {constant(0, Rgb(0.0f)), constant(1, Rgb(1.0f / 256.0f))};
        for (int step = 0; step < length; ++step)
            material.program.push_back({.code = Code::Add, .out = 0, .a = 0, .b = 1});
        material.transparent_register = 0;
        CHECK(evaluate_transparent(material, tyndall::TransparentOperations(material), {}, {}) ==
              Rgb(static_cast<float>(length) / 256.0f));
        CHECK(evaluate(material, {}, {}).transparent == Rgb(static_cast<float>(length) / 256.0f));
    }
}

TEST_CASE("shadow rays run what transparency depends on, and know what that reads") {
    Material leaf{.name = "leaf"};
    leaf.program = {constant(0, Rgb(1.0f)),
                    {.code = Code::Texture, .out = 1}, // of the diffuse colour
                    {.code = Code::TextureAlpha, .out = 2},
                    {.code = Code::Multiply, .out = 1, .a = 1, .b = 2},
                    {.code = Code::Subtract, .out = 3, .a = 0, .b = 2},
                    {.code = Code::Backfacing, .out = 0}}; // its register had another value before
    leaf.transparent_register = 3;
    leaf.diffuse_register = 1;
    const tyndall::TransparentOperations operations(leaf);
    CHECK(operations.places == std::vector<std::uint16_t>{0, 2, 4});
    CHECK(operations.reads == (tyndall::OpReads::image | tyndall::OpReads::uv_map));
    leaf.transparent_register = 0;
    CHECK(tyndall::TransparentOperations(leaf).reads == tyndall::OpReads::facing);
}

TEST_CASE("transparency is coloured only where an operation can make colours") {
    Material material{.name = "curtain"};
    const auto is_coloured = [&](SurfaceOp last, const Rgb& from = Rgb(0.5f)) {
        last.out = 1;
        material.program = {constant(0, from), last};
        material.transparent_register = 1;
        return has_coloured_transparency(material);
    };
    const auto option = [](auto kind) { return static_cast<std::uint8_t>(kind); };
    const Rgb colour(0.5f, 0.4f, 0.3f);
    CHECK_FALSE(is_coloured({.code = Code::Math}, colour));
    CHECK_FALSE(is_coloured({.code = Code::VectorMath, .option = option(tyndall::VectorOperation::Length)}, colour));
    CHECK(is_coloured({.code = Code::VectorMath, .option = option(tyndall::VectorOperation::Floor)}));
    CHECK_FALSE(is_coloured({.code = Code::Gamma}));
    CHECK(is_coloured({.code = Code::Gamma}, colour));
    CHECK_FALSE(is_coloured({.code = Code::Separate}, colour));
    CHECK(is_coloured({.code = Code::Combine}));
    CHECK(is_coloured({.code = Code::Curve}));
    CHECK_FALSE(is_coloured({.code = Code::Curve, .selector = option(tyndall::CurveOf::Alpha)}));
    CHECK_FALSE(is_coloured({.code = Code::TextureAlpha}));
}

TEST_CASE("answers stand for what operations read, point by point, and one that is missing is named") {
    Material material{.name = "painted"};
    material.program = {
        {.code = Code::Texture, .out = 0}, constant(1, Rgb(2.0f)), {.code = Code::Multiply, .out = 0, .a = 0, .b = 1}};
    const std::array<Rgb, 2> texels = {Rgb(0.1f, 0.2f, 0.3f), Rgb(-1.0f, 0.0f, 9.0f)};
    const std::array<tyndall::Answer, 1> answers = {tyndall::Answer{0, texels}};
    std::array<Rgb, 2> values;
    run_on_answers(material, 0, answers, values);
    CHECK(values[0] == 2.0f * texels[0]);
    CHECK(values[1] == 2.0f * texels[1]); // neither clamped nor cut off at 0
    CHECK_THROWS_WITH_AS(run_on_answers(material, 0, {}, values),
                         "material \"painted\" reads more than its operands in operation 1", tyndall::InvalidInput);
}

TEST_CASE("operations that this version does not know, and kinds that there are none of, are refused") {
    const auto is_refused = [](const SurfaceOp& op) {
        Material material{.name = "new"};
        material.tables = {{{tyndall::vec4(1.0f)}}};
        material.program = {op};
        try {
            validate(material);
        } catch (const tyndall::InvalidInput&) {
            return true;
        }
        return false;
    };
    CHECK(is_refused({.code = static_cast<Code>(200)}));
    for (const Code code : {Code::Math, Code::VectorMath, Code::MapRange, Code::VectorRotate, Code::Curve, Code::Blend,
                            Code::Combine, Code::Separate}) {
        CAPTURE(static_cast<int>(code));
        CHECK_FALSE(is_refused({.code = code}));
        CHECK(is_refused({.code = code, .option = 100}));
    }
    CHECK(is_refused({.code = Code::Curve, .table = 1}));
}

TEST_CASE("a surface is opaque everywhere only if no point can disagree") {
    Material material;
    CHECK(is_opaque_everywhere(material));
    material.constant.transparent = Rgb(0.0f, 0.1f, 0.0f);
    CHECK_FALSE(is_opaque_everywhere(material));
    material.program = {constant(0, Rgb(0.0f))};
    CHECK(is_opaque_everywhere(material));
    material.program.push_back({.code = Code::TextureAlpha, .out = 0});
    CHECK_FALSE(is_opaque_everywhere(material));
    Material fog_box;
    fog_box.has_surface = false;
    CHECK_FALSE(is_opaque_everywhere(fog_box));
}

TEST_CASE("a surface glows nowhere only if no point can disagree") {
    Material material;
    CHECK(glows_nowhere(material));
    material.constant.emission = Rgb(0.0f, 0.1f, 0.0f);
    CHECK_FALSE(glows_nowhere(material));
    material.program = {constant(0, Rgb(0.0f))}; // the constants no longer count
    CHECK(glows_nowhere(material));
    material.program.push_back({.code = Code::Add, .out = 0});
    CHECK_FALSE(glows_nowhere(material));
}

TEST_CASE("a program that reads beyond its tables is refused by the material's name") {
    Material material{.name = "Bark"};
    material.program = {{.code = Code::Texture, .out = 0, .texture = 2}};
    CHECK_THROWS_WITH_AS(validate(material), "material \"Bark\" reads texture 2 of 0", tyndall::InvalidInput);
    material.program = {{.code = Code::Add, .out = 64}};
    CHECK_THROWS_WITH_AS(validate(material), "material \"Bark\" uses register 64 of 64", tyndall::InvalidInput);
    material.program = {constant(0, Rgb(std::numeric_limits<float>::infinity()))};
    CHECK_THROWS_AS(validate(material), tyndall::InvalidInput);
}
} // namespace surface_program_test
