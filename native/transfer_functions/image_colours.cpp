// SPDX-License-Identifier: GPL-3.0-or-later
// Bound: a larger image is read pixel by pixel, at 10 to 20 ns each; a smaller one at 50 ns per texel.
#include "transfer_functions/image_colours.hpp"
#include <algorithm>

namespace tyndall::transfer_functions {
ImageColours::ImageColours(const Texture& image, std::uint32_t size)
    : image_(image), size_(size), is_reduced_(image.width > size || image.height > size) {
    if (is_reduced_) {
        columns_ = covered(image.width, size);
        rows_ = covered(image.height, size);
    }
}

std::vector<ImageColours::Covered> ImageColours::covered(std::uint32_t pixel_count, std::uint32_t size) {
    std::vector<Covered> result(size);
    const double pixels_per_texel = static_cast<double>(pixel_count) / static_cast<double>(size);
    const double half_width = 0.5 * std::max(pixels_per_texel, 1.0);
    for (std::size_t texel = 0; texel < size; ++texel) {
        const double middle = (static_cast<double>(texel) + 0.5) * pixels_per_texel;
        const double begin = middle - half_width, end = middle + half_width;
        // As wide as a pixel at least: of two pixels, that is their mix as between their middles.
        Covered& pixels = result[texel];
        pixels.first = static_cast<std::int64_t>(std::floor(begin));
        for (double pixel = std::floor(begin); pixel < end; ++pixel)
            pixels.shares.push_back(
                static_cast<float>((std::min(pixel + 1.0, end) - std::max(pixel, begin)) / (end - begin)));
    }
    return result;
}

void ImageColours::row(std::uint32_t row, std::span<vec4> colours) const {
    const float per_side = 1.0f / static_cast<float>(size_);
    if (!is_reduced_) {
        for (std::uint32_t column = 0; column < size_; ++column)
            colours[column] =
                image_.lookup(per_side * (vec2(static_cast<float>(column), static_cast<float>(row)) + 0.5f));
        return;
    }
    for (std::uint32_t column = 0; column < size_; ++column) {
        vec4 sum(0.0f); // of colours multiplied with alpha: what is transparent has no colour to give
        for (std::size_t y = 0; y < rows_[row].shares.size(); ++y)
            for (std::size_t x = 0; x < columns_[column].shares.size(); ++x) {
                const vec4 colour = image_.at(columns_[column].first + static_cast<std::int64_t>(x),
                                              rows_[row].first + static_cast<std::int64_t>(y));
                const float share = columns_[column].shares[x] * rows_[row].shares[y];
                sum += share * vec4(vec3(colour) * colour.w, colour.w);
            }
        colours[column] = sum.w > 0.0f ? vec4(vec3(sum) / sum.w, sum.w) : vec4(0.0f);
    }
}
} // namespace tyndall::transfer_functions
