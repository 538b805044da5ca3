// SPDX-License-Identifier: GPL-3.0-or-later
// Means of textures over squares: exact for any size, and sharp where no mean is asked for.
#include "core/random.hpp"
#include "image/filtered_texture.hpp"
#include <doctest/doctest.h>

namespace filtered_texture_test {
using namespace tyndall;

static std::shared_ptr<const Texture> noise(std::uint32_t width, std::uint32_t height) {
    auto texture = std::make_shared<Texture>();
    texture->width = width, texture->height = height;
    std::vector<std::uint8_t> texels;
    for (std::uint32_t value = 0; value < 4 * width * height; ++value)
        texels.push_back(static_cast<std::uint8_t>(pcg4d({value, width, height, 7})[0] >> 24));
    texture->bytes = std::move(texels);
    return texture;
}
static vec3 mean_of(const Texture& texture) {
    glm::dvec3 sum(0.0);
    for (std::int64_t row = 0; row < texture.height; ++row)
        for (std::int64_t column = 0; column < texture.width; ++column)
            sum += vec3(texture.at(column, row));
    return vec3(sum / (double{1.0} * texture.width * texture.height));
}

TEST_CASE("the widest mean is that of the whole image, whatever its size") {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {8u, 8u}, {7u, 5u}, {1u, 13u}, {31u, 6u}}) {
        CAPTURE(width);
        const auto texture = noise(width, height);
        const vec3 mean = FilteredTexture(texture).lookup({0.3f, 0.8f}, 1e6f), expected = mean_of(*texture);
        CHECK(glm::length(mean - expected) < 1e-5f * glm::length(expected));
    }
}
TEST_CASE("up to a texel nothing is filtered: bit for bit the texture's own look-up") {
    const auto texture = noise(7, 5);
    const FilteredTexture filtered(texture);
    for (const vec2 uv : {vec2(0.1f, 0.2f), vec2(0.77f, 1.3f), vec2(-0.4f, 0.5f)})
        for (const float texels : {0.0f, 0.5f, 1.0f})
            CHECK(filtered.lookup(uv, texels) == vec3(texture->lookup(uv)));
}
TEST_CASE("a mean of two texels is that of the square of four around its centre") {
    const auto texture = noise(8, 8);
    vec3 expected(0.0f);
    for (std::int64_t row = 4; row < 6; ++row)
        for (std::int64_t column = 2; column < 4; ++column)
            expected += 0.25f * vec3(texture->at(column, row));
    const vec3 mean = FilteredTexture(texture).lookup(vec2(3.0f, 5.0f) / 8.0f, 2.0f);
    CHECK(glm::length(mean - expected) < 1e-5f);
}
} // namespace filtered_texture_test
