// SPDX-License-Identifier: GPL-3.0-or-later
#include "transfer_functions/compose.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <random>

namespace layer_colours_test {
using namespace tyndall;
using namespace tyndall::transfer_functions;

namespace {
Layer gradient(std::vector<vec4> ramp, vec2 from = {0.0f, 0.5f}, vec2 to = {1.0f, 0.5f},
               GradientShape shape = GradientShape::Linear) {
    return {.name = "gradient",
            .kind = LayerKind::Gradient,
            .ramp = std::move(ramp),
            .shape = shape,
            .from = from,
            .to = to};
}
/// A layer alone, without what its alpha is multiplied with.
ComposedFunction composed(Layer layer, std::uint32_t size) {
    return compose({.name = "test", .layers = {std::move(layer)}}, size, Progress());
}
std::shared_ptr<Texture> random_image(std::uint32_t width, std::uint32_t height, bool is_bytes) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform;
    Texture image{.name = "image", .width = width, .height = height};
    image.extension = TextureExtension::Extend;
    image.has_alpha = true;
    std::vector<std::uint8_t> bytes;
    std::vector<float> floats;
    for (std::size_t i = 0; i < std::size_t{4} * width * height; ++i)
        if (is_bytes)
            bytes.push_back(static_cast<std::uint8_t>(random() % 256));
        else
            floats.push_back(uniform(random));
    image.bytes = std::move(bytes), image.floats = std::move(floats);
    return std::make_shared<Texture>(std::move(image));
}
Layer picture(std::shared_ptr<const Texture> image) {
    return {.name = "picture", .kind = LayerKind::Image, .image = std::move(image)};
}
} // namespace

TEST_CASE("a linear gradient rises evenly between its ends, and stays beyond them") {
    const std::uint32_t size = 64;
    const ComposedFunction function =
        composed(gradient({{0, 0, 1, 1}, {1, 0, 0, 1}}, {0.25f, 0.5f}, {0.75f, 0.5f}), size);
    for (std::size_t y = 0; y < size; ++y)
        for (std::size_t x = 0; x < size; ++x) {
            const float share = glm::clamp((static_cast<float>(x) + 0.5f) / 32.0f - 0.5f, 0.0f, 1.0f);
            const vec4 texel = function.texels[y * size + x];
            CHECK(std::abs(texel.x - share) < 1e-6f);
            CHECK(std::abs(texel.z - (1.0f - share)) < 1e-6f);
        }
    CHECK(function.texels[0] == vec4(0, 0, 1, 1));
    CHECK(function.texels[size - 1] == vec4(1, 0, 0, 1));
}

TEST_CASE("a gradient's colours lie evenly along it, also aslant") {
    const std::vector<vec4> ramp{{0, 0, 0, 1}, {4, 0, 0, 1}, {0, 0, 0, 0}};
    const vec4 diagonal = composed(gradient(ramp, {0.0f, 0.0f}, {1.0f, 1.0f}), 3).texels[4];
    CHECK(diagonal == vec4(4, 0, 0, 1)); // the middle texel is the middle of the ramp
    const ComposedFunction aslant = composed(gradient(ramp, {0.0f, 0.0f}, {1.0f, 1.0f}), 64);
    for (std::size_t y = 0; y < 64; ++y)
        for (std::size_t x = 0; x + 1 < 64 && y >= 1; ++x) // what lies across the gradient is equal
            CHECK(std::abs(aslant.texels[y * 64 + x].x - aslant.texels[(y - 1) * 64 + x + 1].x) < 2e-6f);
}

TEST_CASE("a radial gradient is round: its middle is the ramp's beginning, its rim the end") {
    const std::uint32_t size = 65;
    const ComposedFunction function =
        composed(gradient({{1, 1, 1, 1}, {0, 0, 0, 1}}, {0.5f, 0.5f}, {0.5f, 0.9f}, GradientShape::Radial), size);
    CHECK(function.texels[32 * size + 32] == vec4(1, 1, 1, 1));
    for (std::int32_t y = 0; y < 65; ++y)
        for (std::int32_t x = 0; x < 65; ++x) {
            const double away = std::hypot(x - 32, y - 32) / 65.0;
            const vec4 texel = function.texels[static_cast<std::size_t>(y * 65 + x)];
            CHECK(std::abs(double{texel.x} - std::clamp(1 - away / 0.4, 0.0, 1.0)) < 2e-6);
        }
}

TEST_CASE("a gradient whose ends meet is its end everywhere") {
    for (const GradientShape shape : {GradientShape::Linear, GradientShape::Radial})
        for (const vec4& texel :
             composed(gradient({{1, 0, 0, 1}, {0, 1, 0, 1}}, {0.5f, 0.5f}, {0.5f, 0.5f}, shape), 4).texels)
            CHECK(texel == vec4(0, 1, 0, 1));
}

TEST_CASE("an image as large as the function is the image, texel by texel") {
    for (const bool is_bytes : {false, true}) {
        const auto image = random_image(32, 32, is_bytes);
        const ComposedFunction function = composed(picture(image), 32);
        for (std::int64_t y = 0; y < 32; ++y)
            for (std::int64_t x = 0; x < 32; ++x) {
                const vec4 texel = image->at(x, y), found = function.texels[static_cast<std::size_t>(32 * y + x)];
                for (int c = 0; c < 4; ++c) // filtered between texels, at a place that is rounded
                    CHECK(std::abs(found[c] - texel[c] * (c < 3 ? texel.w : 1.0f)) < 2e-5f);
            }
    }
}

// Seen to fail with one look-up in the middle of each texel.
TEST_CASE("a larger image gives each texel the mean of its pixels, weighted by their alpha") {
    const auto image = random_image(48, 32, false);
    const ComposedFunction function = composed(picture(image), 16);
    for (std::int64_t y = 0; y < 16; ++y)
        for (std::int64_t x = 0; x < 16; ++x) {
            vec4 mean(0.0f);
            for (std::int64_t j = 0; j < 2; ++j)
                for (std::int64_t i = 0; i < 3; ++i) {
                    const vec4 pixel = image->at(3 * x + i, 2 * y + j);
                    mean += vec4(vec3(pixel) * pixel.w, pixel.w) / 6.0f;
                }
            const vec4 found = function.texels[static_cast<std::size_t>(16 * y + x)];
            for (int c = 0; c < 4; ++c)
                CHECK(std::abs(found[c] - mean[c]) < 2e-5f);
        }
}

TEST_CASE("an image of any size keeps its mean, and one that is large along one axis is smooth along the other") {
    Texture strip{.name = "strip", .width = 333, .height = 2};
    strip.extension = TextureExtension::Extend;
    std::vector<float> texels;
    for (int row = 0; row < 2; ++row)
        for (int column = 0; column < 333; ++column)
            texels.insert(texels.end(), {static_cast<float>(column % 7), static_cast<float>(row), 0, 1});
    strip.floats = std::move(texels);
    const ComposedFunction function = composed(picture(std::make_shared<Texture>(strip)), 64);
    double mean = 0, truth = 0;
    for (std::size_t y = 0; y < 64; ++y)
        for (std::size_t x = 0; x < 64; ++x) {
            mean += double{function.texels[64 * y + x].x} / (64 * 64);
            const float share = std::clamp((static_cast<float>(y) + 0.5f) / 32.0f - 0.5f, 0.0f, 1.0f);
            CHECK(std::abs(function.texels[64 * y + x].y - share) < 1e-6f);
        }
    for (int column = 0; column < 333; ++column)
        truth += static_cast<double>(column % 7) / 333;
    CHECK(std::abs(mean - truth) < 1e-5);
}

TEST_CASE("a smaller image is smooth between its pixels, and keeps its rim to the border") {
    Texture two{.name = "two", .width = 2, .height = 1, .floats = {0, 0, 0, 1, 1, 1, 1, 1}};
    two.extension = TextureExtension::Extend;
    const ComposedFunction function = composed(picture(std::make_shared<Texture>(two)), 8);
    for (std::size_t x = 0; x < 8; ++x) {
        const float share = std::clamp((static_cast<float>(x) + 0.5f) / 4.0f - 0.5f, 0.0f, 1.0f);
        CHECK(std::abs(function.texels[x].x - share) < 1e-6f);
    }
}
} // namespace layer_colours_test
