// SPDX-License-Identifier: GPL-3.0-or-later
// Texture lookups that agree with Cycles' image nodes to its own rounding.
// Based on: blender/cycles v4.5.0, src/kernel/device/cpu/image.h (interp_linear, interp_cubic) and src/kernel/svm/image.h.
// Differs:  alpha is associated in float; Cycles rounds bytes to 8 bits there. Keeping that order matters: Cycles
//           associates alpha, filters the sRGB-encoded values, divides by alpha and decodes last.
// Bound:    4 texels (cubic: 16) and 3 table look-ups; the table errs by less than 5e-7.
#include "image/texture.hpp"
#include "image/srgb.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
namespace {
/// Texel coordinates of an axis; -1 where the extension reads transparent black.
std::int64_t wrap(std::int64_t texel, std::int64_t count, TextureExtension extension) {
    if (texel >= 0 && texel < count)
        return texel;
    switch (extension) {
    case TextureExtension::Repeat: {
        const std::int64_t rest = texel % count;
        return rest < 0 ? rest + count : rest;
    }
    case TextureExtension::Extend:
        return std::clamp<std::int64_t>(texel, 0, count - 1);
    case TextureExtension::Mirror: {
        const std::int64_t rest = (texel < 0 ? -texel - 1 : texel) % (2 * count);
        return rest < count ? rest : 2 * count - rest - 1;
    }
    case TextureExtension::Clip:
        break;
    }
    return texel < 0 || texel >= count ? -1 : texel;
}

float value_of(const Texture& texture, std::size_t index) {
    return texture.floats.empty() ? static_cast<float>(texture.bytes[index]) / 255.0f : texture.floats[index];
}

float alpha_of_texel(const Texture& texture, std::int64_t column, std::int64_t row) {
    const std::int64_t x = wrap(column, texture.width, texture.extension);
    const std::int64_t y = wrap(row, texture.height, texture.extension);
    if (x < 0 || y < 0)
        return 0.0f;
    return texture.has_alpha
               ? value_of(texture, 4 * (static_cast<std::size_t>(y) * texture.width + static_cast<std::size_t>(x)) + 3)
               : 1.0f;
}

/// Encoded colour with associated alpha.
vec4 texel(const Texture& texture, std::int64_t column, std::int64_t row) {
    const std::int64_t x = wrap(column, texture.width, texture.extension);
    const std::int64_t y = wrap(row, texture.height, texture.extension);
    if (x < 0 || y < 0)
        return vec4(0.0f);
    const std::size_t first = 4 * (static_cast<std::size_t>(y) * texture.width + static_cast<std::size_t>(x));
    vec4 value;
    for (int channel = 0; channel < 4; ++channel)
        value[channel] = value_of(texture, first + static_cast<std::size_t>(channel));
    if (!texture.has_alpha)
        return {vec3(value), 1.0f};
    return {vec3(value) * value.w, value.w};
}

/// Of a coordinate that is not finite, or farther than 64 bits count texels: the first texel.
float bounded(float position) { return std::abs(position) < 1e15f ? position : 0.0f; }
std::int64_t floor_to_texel(float position) { return static_cast<std::int64_t>(std::floor(position)); }

constexpr vec4 missing_image(1, 0, 1, 1); // what Blender shows

/// Of the four texels around a place that lies `share` of the way from the second to the third.
vec4 spline_weights(float share) {
    const float rest = 1.0f - share;
    return vec4(rest * rest * rest, (3.0f * share - 6.0f) * share * share + 4.0f,
                (3.0f * rest - 6.0f) * rest * rest + 4.0f, share * share * share) /
           6.0f;
}

vec4 decoded(const Texture& texture, const vec4& value) {
    vec3 colour(value);
    if (texture.has_alpha && value.w != 0.0f)
        colour /= value.w;
    if (texture.is_srgb && texture.floats.empty())
        colour = vec3(linear_from_srgb(colour.x), linear_from_srgb(colour.y), linear_from_srgb(colour.z));
    return {colour, value.w};
}
} // namespace

/// What `texel` says at uv: of the texel there, or of the four around, mixed.
template <typename Texel>
static auto interpolated(const Texture& texture, vec2 uv, const Texel& texel) {
    const vec2 position(bounded(uv.x * static_cast<float>(texture.width)),
                        bounded(uv.y * static_cast<float>(texture.height)));
    if (texture.interpolation == TextureInterpolation::Closest)
        return texel(texture, floor_to_texel(position.x), floor_to_texel(position.y));
    const vec2 corner = position - 0.5f; // texel centres lie at half texels
    const std::int64_t x = floor_to_texel(corner.x), y = floor_to_texel(corner.y);
    const vec2 share = glm::clamp(corner - vec2(static_cast<float>(x), static_cast<float>(y)), 0.0f, 1.0f);
    if (texture.interpolation == TextureInterpolation::Cubic) {
        const vec4 across = spline_weights(share.x), up = spline_weights(share.y);
        decltype(texel(texture, x, y)) sum(0.0f);
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 4; ++column)
                sum += up[row] * across[column] * texel(texture, x + column - 1, y + row - 1);
        return sum;
    }
    return glm::mix(glm::mix(texel(texture, x, y), texel(texture, x + 1, y), share.x),
                    glm::mix(texel(texture, x, y + 1), texel(texture, x + 1, y + 1), share.x), share.y);
}

vec4 Texture::lookup(vec2 uv) const {
    return width == 0 || height == 0 ? missing_image : decoded(*this, interpolated(*this, uv, texel));
}

float Texture::alpha(vec2 uv) const {
    return width == 0 || height == 0 ? missing_image.w : interpolated(*this, uv, alpha_of_texel);
}

vec4 Texture::at(std::int64_t column, std::int64_t row) const {
    return width == 0 || height == 0 ? missing_image : decoded(*this, texel(*this, column, row));
}
} // namespace tyndall
