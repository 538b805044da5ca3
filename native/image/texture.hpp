// SPDX-License-Identifier: GPL-3.0-or-later
// A scene-linear image that shading looks up, with Blender's extension and interpolation rules.
#pragma once
#include "core/math.hpp"
#include "core/shared_array.hpp"
#include <cstdint>
#include <string>

namespace tyndall {
class TiledTexels; // image/tiled_texels.hpp
enum class TextureExtension : std::uint8_t { Repeat = 0, Extend = 1, Clip = 2, Mirror = 3 };
enum class TextureInterpolation : std::uint8_t {
    Closest = 0,
    Linear = 1,
    Cubic = 2 ///< B-spline: smooth, and blurred a little. Blender's Smart, too.
};

struct Texture {
    std::string name;
    std::uint32_t width = 0, height = 0;
    /// width * height * 4 bytes or floats (exactly one is filled), rows bottom to top; stored with alpha unassociated.
    SharedArray<std::uint8_t> bytes = {}; ///< sRGB-encoded when is_srgb.
    SharedArray<float> floats = {};
    std::shared_ptr<const TiledTexels> tiles = {}; ///< In place of both: texels in a file, of either kind.
    bool is_srgb = true;
    /// Colours are masked by alpha: multiplied while they are filtered, and divided again. False: alpha is 1 in the image
    /// and colours stay as they are, also where a clipped texture fades out.
    bool has_alpha = false;
    TextureExtension extension = TextureExtension::Repeat;
    TextureInterpolation interpolation = TextureInterpolation::Linear;

    /// Colour (scene-linear, as Cycles reads the node's Color output) and alpha at uv; magenta without pixels.
    [[nodiscard]] vec4 lookup(vec2 uv) const;
    /// lookup(uv).w alone, at less cost.
    [[nodiscard]] float alpha(vec2 uv) const;
    /// lookup(uv)[index] alone, of red, green and blue, at less cost. For images without alpha.
    [[nodiscard]] float colour(vec2 uv, int index) const;
    /// As lookup, of one texel, without interpolation; `column` and `row` may lie outside.
    [[nodiscard]] vec4 at(std::int64_t column, std::int64_t row) const;
};
} // namespace tyndall
