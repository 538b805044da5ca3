// SPDX-License-Identifier: GPL-3.0-or-later
// A texture with its means over ever larger squares, for look-ups that stand for more than a texel.
// Based on: Williams, Pyramidal Parametrics, SIGGRAPH 1983.
// Differs:  a level has half of the texels, rounded down, each the exact mean of the area that it covers: no size needs to
//           be a power of two, and every level has the mean of the whole image. Means are of linear colours.
// Bound:    21 bytes per texel; built by two passes over the texels.
#pragma once
#include "image/texture.hpp"
#include <memory>

namespace tyndall {
class FilteredTexture {
public:
    explicit FilteredTexture(std::shared_ptr<const Texture> texture);

    [[nodiscard]] const Texture& texture() const { return *texture_; }
    [[nodiscard]] vec2 size() const {
        return {static_cast<float>(texture_->width), static_cast<float>(texture_->height)};
    }
    /// The mean colour of a square around uv, `texels` wide; up to one texel: Texture::lookup. Scene-linear.
    [[nodiscard]] vec3 lookup(vec2 uv, float texels) const;

private:
    [[nodiscard]] vec3 at_level(vec2 uv, std::size_t level) const;

    std::shared_ptr<const Texture> texture_;
    Texture unpacked_;            ///< The same, still encoded, in floats: a look-up takes half of the time.
    bool is_encoded_;             ///< What it gives is sRGB.
    std::vector<Texture> levels_; ///< From half the size down to a texel.
};
} // namespace tyndall
