// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/parallel.hpp"
#include "voxel_dag/original_colors.hpp"

namespace tyndall::voxel_dag::color_palette {
namespace {
constexpr std::size_t block_colors = 8192;

/// Arrays of float, so that the compiler takes several colours at a time.
class FarthestFirst {
public:
    explicit FarthestFirst(const Originals& originals)
        : count_(originals.colors.size()), squared_(count_, std::numeric_limits<float>::infinity()), center_of_(count_),
          farthest_of_block_((count_ + block_colors - 1) / block_colors) {
        for (const Cie94From& from : originals.from) {
            lightness_.push_back(static_cast<float>(from.lab.lightness));
            a_.push_back(static_cast<float>(from.lab.a));
            b_.push_back(static_cast<float>(from.lab.b));
            chroma_.push_back(static_cast<float>(from.chroma));
            chroma_weight_.push_back(static_cast<float>(from.chroma_weight));
            hue_weight_.push_back(static_cast<float>(from.hue_weight));
        }
    }
    /// Whoever is nearer to the new center than to its own joins it. The farthest from its own then, the first of equals.
    std::size_t add(std::size_t center, const Progress& progress) {
        parallel_blocks(count_, block_colors, progress, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const float lightness = lightness_[i] - lightness_[center], a = a_[i] - a_[center];
                const float b = b_[i] - b_[center], in_chroma = chroma_[i] - chroma_[center];
                const float hue = std::max(0.0f, a * a + b * b - in_chroma * in_chroma);
                const float squared =
                    lightness * lightness + chroma_weight_[i] * in_chroma * in_chroma + hue_weight_[i] * hue;
                const bool is_nearer = squared < squared_[i];
                squared_[i] = is_nearer ? squared : squared_[i];
                center_of_[i] = is_nearer ? static_cast<std::uint32_t>(center) : center_of_[i];
            }
            const auto first = squared_.begin() + static_cast<std::ptrdiff_t>(begin);
            const auto last = squared_.begin() + static_cast<std::ptrdiff_t>(end);
            farthest_of_block_[begin / block_colors] =
                begin + static_cast<std::size_t>(std::max_element(first, last) - first);
        });
        std::size_t farthest = farthest_of_block_[0];
        for (const std::size_t candidate : farthest_of_block_)
            if (squared_[candidate] > squared_[farthest])
                farthest = candidate;
        return farthest;
    }
    bool is_center(std::size_t color) const { return squared_[color] == 0.0f; }
    const std::vector<std::uint32_t>& center_of() const { return center_of_; }

private:
    std::size_t count_;
    std::vector<float> lightness_, a_, b_, chroma_, chroma_weight_, hue_weight_;
    std::vector<float> squared_; // to its center
    std::vector<std::uint32_t> center_of_;
    std::vector<std::size_t> farthest_of_block_;
};
} // namespace

Result counted_of_size(CountedColors colors, std::uint32_t color_count, const Progress& progress) {
    require(1 <= color_count && color_count <= 65536, "color_count is ", color_count, ", outside [1, 65536]");
    if (colors.colors.empty())
        return {};
    const Originals originals(std::move(colors));
    FarthestFirst search(originals);
    auto next = static_cast<std::size_t>(std::ranges::max_element(originals.counts) - originals.counts.begin());
    for (std::uint32_t number = 0; number < color_count; ++number) {
        next = search.add(next, progress);
        if (search.is_center(next))
            break; // all are
    }
    double worst = 0.0;
    for (std::size_t i = 0; i < originals.colors.size(); ++i)
        worst = std::max(worst, originals.from[i].squared(originals.from[search.center_of()[i]].lab));
    return palette_of(originals, search.center_of(), std::sqrt(worst), progress);
}
Result of_size(std::span<const PackedColor> entries, std::uint32_t color_count, const Progress& progress) {
    auto [colors, indices] = counted(entries, progress);
    return of_entries(counted_of_size(std::move(colors), color_count, progress), std::move(indices));
}
} // namespace tyndall::voxel_dag::color_palette
