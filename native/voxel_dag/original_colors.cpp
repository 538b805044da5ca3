// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/original_colors.hpp"
#include "core/errors.hpp"
#include "voxel_dag/material_indices.hpp"
#include <algorithm>

namespace tyndall::voxel_dag::color_palette {
Originals::Originals(CountedColors counted) : colors(std::move(counted.colors)), counts(std::move(counted.counts)) {
    from.reserve(colors.size());
    for (const PackedColor color : colors)
        from.emplace_back(lab_of(color));
}

CountedEntries counted(std::span<const PackedColor> entries, const Progress& progress) {
    const auto too_large = std::ranges::find_if(entries, [](PackedColor color) { return color > 0xffffff; });
    require(too_large == entries.end(), "entry ", too_large - entries.begin(), " is no colour of 24 bits");
    MaterialIndices found = material_indices_of(entries, progress);
    CountedColors colors{.colors = std::move(found.materials), .counts = {}};
    colors.counts.resize(colors.colors.size());
    for (const std::uint32_t index : found.indices)
        ++colors.counts[index];
    return {.colors = std::move(colors), .indices = std::move(found.indices)};
}
Result of_entries(Result of_colors, std::vector<std::uint32_t> indices) {
    for (std::uint32_t& index : indices)
        index = of_colors.indices[index];
    of_colors.indices = std::move(indices);
    return of_colors;
}

namespace {
/// Of what stands for several originals.
struct Cluster {
    double lightness = 0.0, a = 0.0, b = 0.0, count = 0.0; // sums
    double squared_now = 0.0, squared_then = 0.0;          // of differences, by count: where it is, and at the mean
    bool stays_within = true;
    PackedColor mean = 0;
    Lab mean_lab{};
};
} // namespace

Result palette_of(const Originals& originals, const std::vector<std::uint32_t>& center_of, double most_difference,
                  const Progress& progress) {
    const std::size_t count = originals.colors.size();
    std::vector<Cluster> clusters(count); // of the originals that are centers
    for (std::size_t i = 0; i < count; ++i) {
        Cluster& cluster = clusters[center_of[i]];
        const auto weight = static_cast<double>(originals.counts[i]);
        cluster.lightness += weight * originals.from[i].lab.lightness;
        cluster.a += weight * originals.from[i].lab.a;
        cluster.b += weight * originals.from[i].lab.b;
        cluster.count += weight;
    }
    progress.poll();
    for (Cluster& cluster : clusters)
        if (cluster.count > 0.0) {
            cluster.mean =
                color_of({cluster.lightness / cluster.count, cluster.a / cluster.count, cluster.b / cluster.count});
            cluster.mean_lab = lab_of(cluster.mean);
        }
    progress.poll();
    for (std::size_t i = 0; i < count; ++i) {
        Cluster& cluster = clusters[center_of[i]];
        const auto weight = static_cast<double>(originals.counts[i]);
        const double then = originals.from[i].squared(cluster.mean_lab);
        cluster.squared_now += weight * originals.from[i].squared(originals.from[center_of[i]].lab);
        cluster.squared_then += weight * then;
        cluster.stays_within = cluster.stays_within && std::sqrt(then) <= most_difference;
    }
    progress.poll();
    Result result{.colors = {}, .indices = {}, .statistics = {}};
    std::vector<PackedColor> color_of_original(count);
    double sum = 0.0, entry_count = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        const Cluster& cluster = clusters[center_of[i]];
        const bool moves = cluster.stays_within && cluster.squared_then < cluster.squared_now;
        color_of_original[i] = moves ? cluster.mean : originals.colors[center_of[i]];
        const double difference =
            std::sqrt(originals.from[i].squared(moves ? cluster.mean_lab : originals.from[center_of[i]].lab));
        const auto weight = static_cast<double>(originals.counts[i]);
        sum += weight * difference, entry_count += weight;
        result.statistics.most_difference = std::max(result.statistics.most_difference, difference);
    }
    result.statistics.mean_difference = entry_count > 0.0 ? sum / entry_count : 0.0;
    result.colors = color_of_original;
    std::ranges::sort(result.colors);
    result.colors.erase(std::ranges::unique(result.colors).begin(), result.colors.end());
    for (PackedColor& color : color_of_original) // to its index
        color = static_cast<std::uint32_t>(std::ranges::lower_bound(result.colors, color) - result.colors.begin());
    result.indices = std::move(color_of_original);
    return result;
}
} // namespace tyndall::voxel_dag::color_palette
