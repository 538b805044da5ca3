// SPDX-License-Identifier: GPL-3.0-or-later
// An image over a function's picture.
#pragma once
#include "image/texture.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::transfer_functions {
/// Where an image has more pixels than the picture has texels, a texel has their mean; else, what lies between them. The
/// image outlives it.
class ImageColours {
public:
    ImageColours(const Texture& image, std::uint32_t size);
    /// Scene-linear colours with alpha, one per texel of a row.
    void row(std::uint32_t row, std::span<vec4> colours) const;

private:
    /// Pixels along one axis that a texel covers, or lies between, and their shares.
    struct Covered {
        std::int64_t first;
        std::vector<float> shares;
    };
    static std::vector<Covered> covered(std::uint32_t pixel_count, std::uint32_t size);

    const Texture& image_;
    std::uint32_t size_;
    bool is_reduced_;
    std::vector<Covered> columns_, rows_; ///< Per texel, where it is.
};
} // namespace tyndall::transfer_functions
