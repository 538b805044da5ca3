// SPDX-License-Identifier: GPL-3.0-or-later
#include "image/filtered_texture.hpp"
#include "core/errors.hpp"
#include "image/srgb.hpp"
#include <algorithm>
#include <array>
#include <cmath>

namespace tyndall {
namespace {
/// Of one axis: the texels that a texel of the next level covers, and the share of it that each fills.
struct Cover {
    std::size_t first = 0, count = 0;
    std::array<float, 4> share{}; ///< Up to 3 whole ones and the ends of two, of which never more than 4 meet.
};

Cover cover_of(std::size_t texel, std::uint32_t coarse_count, std::uint32_t fine_count) {
    const double width = static_cast<double>(fine_count) / coarse_count, begin = width * static_cast<double>(texel);
    Cover cover{.first = static_cast<std::size_t>(begin)};
    for (std::size_t fine = cover.first; fine < fine_count && cover.count < cover.share.size(); ++fine) {
        const double from = std::max(begin, static_cast<double>(fine));
        const double to = std::min(begin + width, static_cast<double>(fine + 1));
        if (to <= from)
            break;
        cover.share[cover.count++] = static_cast<float>((to - from) / width);
    }
    return cover;
}

/// Of half the size, with linear colours.
Texture halved(const Texture& fine) {
    Texture coarse{.name = fine.name,
                   .width = std::max(1u, fine.width / 2),
                   .height = std::max(1u, fine.height / 2),
                   .is_srgb = false,
                   .extension = fine.extension,
                   .interpolation = fine.interpolation};
    std::vector<float> means;
    means.reserve(std::size_t{4} * coarse.width * coarse.height);
    for (std::size_t y = 0; y < coarse.height; ++y) {
        const Cover rows = cover_of(y, coarse.height, fine.height);
        for (std::size_t x = 0; x < coarse.width; ++x) {
            const Cover columns = cover_of(x, coarse.width, fine.width);
            vec3 mean(0.0f);
            for (std::size_t v = 0; v < rows.count; ++v)
                for (std::size_t u = 0; u < columns.count; ++u)
                    mean += rows.share[v] * columns.share[u] *
                            vec3(fine.at(static_cast<std::int64_t>(columns.first + u),
                                         static_cast<std::int64_t>(rows.first + v)));
            means.insert(means.end(), {mean.x, mean.y, mean.z, 1.0f});
        }
    }
    coarse.floats = std::move(means);
    return coarse;
}
} // namespace

FilteredTexture::FilteredTexture(std::shared_ptr<const Texture> texture)
    : texture_(std::move(texture)), unpacked_(*texture_), is_encoded_(texture_->is_srgb && texture_->floats.empty()) {
    require(texture_->tiles == nullptr, "image \"", texture_->name, "\" lies in a file, where it has no means");
    if (unpacked_.floats.empty()) {
        std::vector<float> values;
        values.reserve(unpacked_.bytes.size());
        for (const std::uint8_t byte : unpacked_.bytes)
            values.push_back(static_cast<float>(byte) / 255.0f);
        unpacked_.floats = std::move(values);
        unpacked_.bytes = {};
    }
    const Texture* fine = texture_.get();
    while (fine->width > 1 || fine->height > 1) {
        Texture coarse = halved(*fine);
        fine = &levels_.emplace_back(std::move(coarse));
    }
}

vec3 FilteredTexture::at_level(vec2 uv, std::size_t level) const {
    if (level > 0)
        return vec3(levels_[level - 1].lookup(uv));
    const vec3 colour(unpacked_.lookup(uv));
    return is_encoded_ ? vec3(linear_from_srgb(colour.x), linear_from_srgb(colour.y), linear_from_srgb(colour.z))
                       : colour;
}

vec3 FilteredTexture::lookup(vec2 uv, float texels) const {
    if (!(texels > 1.0f) || levels_.empty())
        return at_level(uv, 0);
    const float level = std::min(std::log2(texels), static_cast<float>(levels_.size()));
    const auto fine = std::min(static_cast<std::size_t>(level), levels_.size() - 1);
    return glm::mix(at_level(uv, fine), at_level(uv, fine + 1), level - static_cast<float>(fine));
}
} // namespace tyndall
