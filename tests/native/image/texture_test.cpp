// SPDX-License-Identifier: GPL-3.0-or-later
// What a texture shows at a place: the rules by which Blender's image nodes extend, filter, encode and mask. The same
// lookups were compared with Cycles of 3.4.1 and 4.5.15 on 48 x 48 points of every mode: equal to 1e-6, but for 8-bit
// rounding of alpha in Cycles.
#include "image/srgb.hpp"
#include "image/texture.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

namespace texture_test {
using namespace tyndall;

/// One row of grey texels, linear.
static Texture row(std::vector<float> values, TextureExtension extension, TextureInterpolation interpolation) {
    Texture texture{.name = "row", .width = static_cast<std::uint32_t>(values.size()), .height = 1};
    std::vector<float> texels;
    for (const float value : values)
        texels.insert(texels.end(), {value, value, value, 1.0f});
    texture.floats = std::move(texels);
    texture.extension = extension;
    texture.interpolation = interpolation;
    return texture;
}

TEST_CASE("a texel's value stands at its centre, and half-way between two centres is their mean") {
    const Texture texture = row({1, 3, 5, 7}, TextureExtension::Repeat, TextureInterpolation::Linear);
    CHECK(texture.lookup({0.125f, 0.5f}).x == 1.0f);
    CHECK(texture.lookup({0.375f, 0.5f}).x == 3.0f);
    CHECK(texture.lookup({0.25f, 0.5f}).x == 2.0f);
    CHECK(texture.lookup({0.0f, 0.5f}).x == 4.0f); // across the seam: of 7 and 1
}
TEST_CASE("beyond its edges a texture repeats, extends, is transparent or mirrors") {
    using enum TextureExtension;
    const std::vector<float> values{1, 3, 5, 7};
    const float beyond_left = -0.2f, beyond_right = 1.3f; // texels -1 and 5
    const auto closest = [&](TextureExtension extension, float u) {
        return row(values, extension, TextureInterpolation::Closest).lookup({u, 0.5f});
    };
    CHECK(closest(Repeat, beyond_left).x == 7.0f);
    CHECK(closest(Repeat, beyond_right).x == 3.0f);
    CHECK(closest(Extend, beyond_left).x == 1.0f);
    CHECK(closest(Extend, beyond_right).x == 7.0f);
    CHECK(closest(Mirror, beyond_left).x == 1.0f);
    CHECK(closest(Mirror, beyond_right).x == 5.0f);
    CHECK(closest(Mirror, 2.1f).x == 1.0f); // two periods on
    CHECK(closest(Clip, beyond_left) == vec4(0.0f));
    CHECK(closest(Clip, 0.1f) == vec4(1.0f));
}
TEST_CASE("a clipped texture fades out over half a texel, alpha included") {
    const Texture texture = row({4, 4}, TextureExtension::Clip, TextureInterpolation::Linear);
    CHECK(texture.lookup({0.0f, 0.5f}) == vec4(2.0f, 2.0f, 2.0f, 0.5f));
}
TEST_CASE("v rises upwards: the first row of pixels is the lowest") {
    Texture texture{.name = "rows", .width = 1, .height = 2};
    texture.floats = {1, 1, 1, 1, 2, 2, 2, 1};
    texture.interpolation = TextureInterpolation::Closest;
    CHECK(texture.lookup({0.5f, 0.25f}).x == 1.0f);
    CHECK(texture.lookup({0.5f, 0.75f}).x == 2.0f);
}
// Seen to fail with texels decoded before they are filtered.
TEST_CASE("bytes are filtered as they are encoded and decoded last, as Cycles does") {
    Texture texture{.name = "bytes", .width = 2, .height = 1};
    texture.bytes = {0, 0, 0, 255, 255, 255, 255, 255};
    CHECK(std::abs(texture.lookup({0.5f, 0.5f}).x - 0.21404114f) < 1e-6f); // of an encoded 0.5
    texture.is_srgb = false;
    CHECK(texture.lookup({0.5f, 0.5f}).x == 0.5f);
}
// Seen to fail with colours filtered apart from alpha: the leaf's edge takes the colour of what lies outside it.
TEST_CASE("a masked texel's colour does not bleed into its neighbour") {
    Texture leaf{.name = "leaf", .width = 2, .height = 1};
    leaf.floats = {0.2f, 0.6f, 0.1f, 1, 9, 0, 9, 0}; // a green texel beside a violet one of alpha 0
    leaf.has_alpha = true;
    const vec4 edge = leaf.lookup({0.5f, 0.5f});
    CHECK(glm::distance(edge, vec4(0.2f, 0.6f, 0.1f, 0.5f)) < 1e-6f);
    leaf.has_alpha = false;
    CHECK(leaf.lookup({0.75f, 0.5f}) == vec4(9, 0, 9, 1));
}
TEST_CASE("alpha or a colour alone is that of a whole lookup, and a texel alone what a closest lookup shows") {
    Texture leaf{.name = "leaf", .width = 3, .height = 2};
    std::vector<std::uint8_t> texels;
    for (int index = 0; index < 24; ++index)
        texels.push_back(static_cast<std::uint8_t>(37 * index % 256));
    leaf.bytes = std::move(texels);
    using enum TextureExtension;
    for (const bool has_alpha : {false, true})
        for (const auto extension : {Repeat, Extend, Clip, Mirror})
            for (const auto interpolation : {TextureInterpolation::Closest, TextureInterpolation::Linear}) {
                leaf.has_alpha = has_alpha, leaf.extension = extension, leaf.interpolation = interpolation;
                for (float u = -2.7f; u < 3.0f; u += 0.13f)
                    CHECK(leaf.alpha({u, 0.8f - u}) == leaf.lookup({u, 0.8f - u}).w);
                for (float u = -2.7f; u < 3.0f && !has_alpha; u += 0.13f)
                    for (int index = 0; index < 3; ++index)
                        CHECK(leaf.colour({u, 0.8f - u}, index) == leaf.lookup({u, 0.8f - u})[index]);
                leaf.interpolation = TextureInterpolation::Closest;
                CHECK(leaf.at(4, -1) == leaf.lookup({4.5f / 3.0f, -0.5f / 2.0f}));
            }
}
TEST_CASE("the table of the sRGB curve errs by less than 5e-7, and the two curves are each other's inverse") {
    double worst = 0.0;
    for (int step = 0; step <= 100000; ++step) {
        const double encoded = step / 1e5;
        const double exact = encoded < 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
        worst = std::max(worst, std::abs(linear_from_srgb(static_cast<float>(encoded)) - exact));
    }
    CHECK(worst < 5e-7);
    for (const float linear : {0.0f, 0.001f, 0.0031308f, 0.18f, 1.0f, 7.0f})
        CHECK(std::abs(linear_from_srgb(srgb_from_linear(linear)) - linear) <= 2e-6f * std::max(linear, 0.2f));
}
TEST_CASE("no coordinate is too far, and none but a place in the image is needed") {
    const float infinity = std::numeric_limits<float>::infinity();
    for (const auto extension :
         {TextureExtension::Repeat, TextureExtension::Extend, TextureExtension::Clip, TextureExtension::Mirror})
        for (const auto interpolation : {TextureInterpolation::Closest, TextureInterpolation::Linear}) {
            const Texture texture = row({1, 2, 3}, extension, interpolation);
            for (const float u : {1e9f, -1e9f, 3e38f, infinity, -infinity, std::nanf("")})
                for (int channel = 0; channel < 4; ++channel)
                    CHECK(std::isfinite(texture.lookup({u, -u})[channel]));
        }
    CHECK(Texture{.name = "missing"}.lookup({0.5f, 0.5f}) == vec4(1, 0, 1, 1));
}
} // namespace texture_test
