// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/parallel.hpp"
#include "voxel_dag/original_colors.hpp"
#include <numeric>
#include <optional>
#include <unordered_map>

namespace tyndall::voxel_dag::color_palette {
namespace {
/// Colours of CIELAB in boxes, those near an original to be found without a look at all others.
class Grid {
public:
    explicit Grid(double most_difference) : reach_(most_difference) {}

    void add(std::uint32_t color, const Lab& lab) {
        boxes_[key(box(lab.lightness, reach_), box(lab.a, side()), box(lab.b, side()))].push_back({color, lab});
    }
    /// The color nearest to the original and within reach, the first of equals.
    std::optional<std::uint32_t> nearest(const Cie94From& original) const {
        // Lightness has weight 1; a and b have at least that of chroma, which is no more than that of hue.
        const double in_plane = reach_ / std::sqrt(original.chroma_weight);
        std::optional<std::uint32_t> best;
        double best_squared = 0.0;
        const auto consider = [&](const Placed& placed) {
            const double squared = original.squared(placed.lab);
            if (std::sqrt(squared) > reach_)
                return;
            if (!best || squared < best_squared || (squared == best_squared && placed.color < *best))
                best = placed.color, best_squared = squared;
        };
        const auto over = [&](double at, double reach, double box_side, const auto& visit) {
            for (std::int64_t i = box(at - reach, box_side); i <= box(at + reach, box_side); ++i)
                visit(i);
        };
        over(original.lab.lightness, reach_, reach_, [&](std::int64_t l) {
            over(original.lab.a, in_plane, side(), [&](std::int64_t a) {
                over(original.lab.b, in_plane, side(), [&](std::int64_t b) {
                    if (const auto found = boxes_.find(key(l, a, b)); found != boxes_.end())
                        std::ranges::for_each(found->second, consider);
                });
            });
        });
        return best;
    }

private:
    struct Placed {
        std::uint32_t color;
        Lab lab;
    };
    double side() const { return 4.0 * reach_; } // of a box in a and b: what reaches that far has a chroma of 67
    static std::int64_t box(double at, double side) { return static_cast<std::int64_t>(std::floor(at / side)); }
    static std::uint64_t key(std::int64_t l, std::int64_t a, std::int64_t b) {
        const auto part = [](std::int64_t at) { return static_cast<std::uint64_t>(at) & 0x1fffff; };
        return part(l) << 42 | part(a) << 21 | part(b);
    }
    double reach_;
    std::unordered_map<std::uint64_t, std::vector<Placed>> boxes_;
};
} // namespace

Result counted_within(CountedColors colors, double most_difference, const Progress& progress) {
    require(0.01 <= most_difference && most_difference <= 100.0, "most_difference is ", most_difference,
            ", outside [0.01, 100]"); // false for a NaN, too
    const Originals originals(std::move(colors));
    std::vector<std::uint32_t> frequent_first(originals.colors.size());
    std::iota(frequent_first.begin(), frequent_first.end(), 0u);
    std::ranges::stable_sort(frequent_first, std::greater(),
                             [&](std::uint32_t color) { return originals.counts[color]; });
    Grid grid(most_difference);
    for (std::size_t i = 0; i < frequent_first.size(); ++i) {
        if (i % 1024 == 0)
            progress.poll();
        const Cie94From& original = originals.from[frequent_first[i]];
        if (!grid.nearest(original))
            grid.add(frequent_first[i], original.lab);
    }
    std::vector<std::uint32_t> center_of(originals.colors.size());
    parallel_for(center_of.size(), progress, [&](std::size_t i) { // the nearest may have been added later
        center_of[i] = *grid.nearest(originals.from[i]);
    });
    return palette_of(originals, center_of, most_difference, progress);
}
Result within(std::span<const PackedColor> entries, double most_difference, const Progress& progress) {
    auto [colors, indices] = counted(entries, progress);
    return of_entries(counted_within(std::move(colors), most_difference, progress), std::move(indices));
}
} // namespace tyndall::voxel_dag::color_palette
