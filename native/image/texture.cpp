// SPDX-License-Identifier: GPL-3.0-or-later
// Texture lookups that agree with Cycles' image nodes to its own rounding.
// Based on: blender/cycles v4.5.0, src/kernel/device/cpu/image.h (interp_linear, interp_cubic) and src/kernel/svm/image.h.
// Differs:  alpha is associated in float; Cycles rounds bytes to 8 bits there. Keeping that order matters: Cycles
//           associates alpha, filters the sRGB-encoded values, divides by alpha and decodes last.
// Bound:    4 texels (cubic: 16) and 3 table look-ups; the table errs by less than 5e-7. Where texels are, in memory or in
//           a file, is asked once per lookup; what is computed of them is the same.
#include "image/texture.hpp"
#include "image/srgb.hpp"
#include "image/tiled_texels.hpp"
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

/// Texels by column and row, which are inside of the image.
struct Bytes {
    const Texture& texture;
    static constexpr bool may_be_encoded = true;
    [[nodiscard]] const std::uint8_t* at(std::size_t x, std::size_t y) const {
        return texture.bytes.data() + 4 * (y * texture.width + x);
    }
    static float value(std::uint8_t stored) { return static_cast<float>(stored) / 255.0f; }
};
struct Floats {
    const Texture& texture;
    static constexpr bool may_be_encoded = false;
    [[nodiscard]] const float* at(std::size_t x, std::size_t y) const {
        return texture.floats.data() + 4 * (y * texture.width + x);
    }
    static float value(float stored) { return stored; }
};
struct TiledBytes : Bytes {
    [[nodiscard]] std::array<std::uint8_t, 4> at(std::size_t x, std::size_t y) const {
        return texture.tiles->bytes_at(x, y);
    }
};
struct TiledFloats : Floats {
    [[nodiscard]] std::array<float, 4> at(std::size_t x, std::size_t y) const { return texture.tiles->floats_at(x, y); }
};

/// What `look` makes of a texture's texels, wherever they are.
template <typename Look>
auto with_texels(const Texture& texture, const Look& look) {
    if (texture.tiles != nullptr) [[unlikely]]
        return texture.tiles->is_float() ? look(TiledFloats{texture}) : look(TiledBytes{texture});
    return texture.floats.empty() ? look(Bytes{texture}) : look(Floats{texture});
}

/// What `look` makes of the texel there, by its column and row inside of the image; 0 of what reads transparent black.
template <typename Look>
auto texel_by(const Texture& texture, std::int64_t column, std::int64_t row, const Look& look) {
    const std::int64_t x = wrap(column, texture.width, texture.extension);
    const std::int64_t y = wrap(row, texture.height, texture.extension);
    if (x < 0 || y < 0)
        return decltype(look(std::size_t{}, std::size_t{}))(0.0f);
    return look(static_cast<std::size_t>(x), static_cast<std::size_t>(y));
}

template <typename Texels>
float alpha_of_texel(const Texels& texels, std::int64_t column, std::int64_t row) {
    return texel_by(texels.texture, column, row, [&](std::size_t x, std::size_t y) {
        return texels.texture.has_alpha ? texels.value(texels.at(x, y)[3]) : 1.0f;
    });
}

/// Encoded, of an image without alpha.
template <typename Texels>
float colour_of_texel(const Texels& texels, int index, std::int64_t column, std::int64_t row) {
    return texel_by(texels.texture, column, row, [&](std::size_t x, std::size_t y) {
        return texels.value(texels.at(x, y)[static_cast<std::size_t>(index)]);
    });
}

/// Encoded colour with associated alpha.
template <typename Texels>
vec4 texel(const Texels& texels, std::int64_t column, std::int64_t row) {
    return texel_by(texels.texture, column, row, [&](std::size_t x, std::size_t y) {
        const auto stored = texels.at(x, y);
        vec4 value;
        for (int channel = 0; channel < 4; ++channel)
            value[channel] = texels.value(stored[static_cast<std::size_t>(channel)]);
        return texels.texture.has_alpha ? vec4(vec3(value) * value.w, value.w) : vec4(vec3(value), 1.0f);
    });
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

template <typename Texels>
vec4 decoded(const Texels& texels, const vec4& value) {
    const Texture& texture = texels.texture;
    vec3 colour(value);
    if (texture.has_alpha && value.w != 0.0f)
        colour /= value.w;
    if (Texels::may_be_encoded && texture.is_srgb)
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
        return texel(floor_to_texel(position.x), floor_to_texel(position.y));
    const vec2 corner = position - 0.5f; // texel centres lie at half texels
    const std::int64_t x = floor_to_texel(corner.x), y = floor_to_texel(corner.y);
    const vec2 share = glm::clamp(corner - vec2(static_cast<float>(x), static_cast<float>(y)), 0.0f, 1.0f);
    if (texture.interpolation == TextureInterpolation::Cubic) {
        const vec4 across = spline_weights(share.x), up = spline_weights(share.y);
        decltype(texel(x, y)) sum(0.0f);
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 4; ++column)
                sum += up[row] * across[column] * texel(x + column - 1, y + row - 1);
        return sum;
    }
    return glm::mix(glm::mix(texel(x, y), texel(x + 1, y), share.x),
                    glm::mix(texel(x, y + 1), texel(x + 1, y + 1), share.x), share.y);
}

vec4 Texture::lookup(vec2 uv) const {
    if (width == 0 || height == 0)
        return missing_image;
    return with_texels(*this, [&](const auto& texels) {
        return decoded(texels, interpolated(*this, uv, [&](std::int64_t column, std::int64_t row) {
                           return texel(texels, column, row);
                       }));
    });
}

float Texture::alpha(vec2 uv) const {
    if (width == 0 || height == 0)
        return missing_image.w;
    return with_texels(*this, [&](const auto& texels) {
        return interpolated(*this, uv,
                            [&](std::int64_t column, std::int64_t row) { return alpha_of_texel(texels, column, row); });
    });
}

float Texture::colour(vec2 uv, int index) const {
    if (width == 0 || height == 0)
        return missing_image[index];
    return with_texels(*this, [&]<typename Texels>(const Texels& texels) {
        const float value = interpolated(*this, uv, [&](std::int64_t column, std::int64_t row) {
            return colour_of_texel(texels, index, column, row);
        });
        return Texels::may_be_encoded && is_srgb ? linear_from_srgb(value) : value;
    });
}

vec4 Texture::at(std::int64_t column, std::int64_t row) const {
    if (width == 0 || height == 0)
        return missing_image;
    return with_texels(*this, [&](const auto& texels) { return decoded(texels, texel(texels, column, row)); });
}
} // namespace tyndall
