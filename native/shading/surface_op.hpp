// SPDX-License-Identifier: GPL-3.0-or-later
// The operations of surface programs. A register holds an Rgb; numbers have three equal channels.
#pragma once
#include "core/math.hpp"
#include <cstdint>
#include <vector>

namespace tyndall {
/// Colours with alpha at even steps over [0, 1], straight between them.
struct ColorTable {
    std::vector<vec4> values;
    bool operator==(const ColorTable&) const = default;
};

/// One operation of a surface program: register[out] of the registers a to f.
struct SurfaceOp {
    enum class Code : std::uint8_t {
        Constant = 0,     ///< register[out] = value
        Texture = 1,      ///< register[out] = image colour at uv map `texture_uv` through `uv_matrix`
        TextureAlpha = 2, ///< the same image's alpha
        Multiply = 3,     ///< a * b
        Add = 4,          ///< a + b
        Subtract = 5,     ///< a - b
        Mix = 6,          ///< a + (b - a) * clamp(c)
        Clamp = 7,        ///< clamp a to [0, 1]
        Average = 8,      ///< (r + g + b) / 3 of a, Blender's colour to value
        Backfacing = 9,   ///< 1 on back faces, else 0
        Uv = 10,          ///< register[out] = uv_matrix * (u, v, 1) of `texture_uv`: see scene/attribute_pairs.hpp
        // Of numbers and vectors: op_math.hpp.
        Math = 11,
        VectorMath = 12,
        MapRange = 13,
        VectorRotate = 14,
        Affine = 15, ///< uv_matrix * a + value
        // Of colours: op_colour.hpp.
        Curve = 20,
        HueSaturation = 21,
        Gamma = 22,
        Blend = 23,
        Combine = 24,
        Separate = 25,
        // Of the point and its object: op_inputs.hpp.
        Input = 30,
        Fresnel = 31,
        LayerWeight = 32,
        NormalMap = 33,
        Bump = 34,
        // Patterns: op_patterns.hpp.
        Noise = 40,
        Voronoi = 41,
        Wave = 42,
        Magic = 43,
        Gradient = 44,
        Checker = 45,
        Brick = 46,
        Musgrave = 47,
        WhiteNoise = 48,
        Gabor = 49,
        // Images at a vector: op_images.hpp.
        ImageAt = 60,
        ImageAlphaAt = 61,
        EnvironmentAt = 62,
        Photometry = 63, ///< A luminaire's intensities in a table, at a vector: op_photometry.hpp.
        // By rays from the point: op_surroundings.hpp.
        AmbientOcclusion = 70,
        Bevel = 71,
    };
    Code code = Code::Constant;
    std::uint8_t option = 0, selector = 0; ///< Which of the operation's kinds, and which of its results.
    std::uint16_t out = 0, a = 0, b = 0, c = 0, d = 0, e = 0, f = 0;
    std::uint16_t texture = 0;    ///< Into Material::textures.
    std::uint16_t texture_uv = 0; ///< Into Material::uv_map_names.
    std::uint16_t table = 0;      ///< Into Material::tables.
    /// Where positions and UV maps are read: at the point, or half a pixel beside it, to the one or the other side.
    std::uint8_t shift = 0;
    Rgb value{0.0f};
    glm::mat3 uv_matrix{1.0f}; ///< Mapping node, applied to (u, v, 1).
    bool operator==(const SurfaceOp&) const = default;
};
} // namespace tyndall
