// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/stored_top.hpp"
#include "core/parallel.hpp"

namespace tyndall::voxel_dag {
std::vector<TopLevel> stored_top(const PackedDag& dag, const Progress& progress) {
    return top_levels_of(dag, {}, {.most_bytes = dag.byte_count() / top_share}, progress);
}

std::vector<TopLevel> stored_top(const PackedDag& dag, const AttributeParts& attributes,
                                 std::span<const std::uint8_t> mean_indices, const Progress& progress) {
    if (!attributes.layout.has_colors)
        return stored_top(dag, progress);
    if (mean_indices.empty() || dag.level <= least_mean_level)
        return {};
    const RunArray numbers(mean_indices);
    const MaterialTable materials(attributes.means.materials);
    const auto mean_colors = [&](std::span<const Voxel> lowest, std::uint32_t side_level) {
        std::vector<ByteColor> colors(lowest.size());
        parallel_for(lowest.size(), progress, [&](std::size_t i) {
            const std::uint64_t node = find_stored(dag, attributes.order, lowest[i], side_level).value().number;
            colors[i] = byte_color(materials.at(numbers.at(node), 0));
        });
        return colors;
    };
    return top_levels_of(dag, mean_colors,
                         {.most_level = dag.level - least_mean_level, .most_bytes = dag.byte_count() / top_share},
                         progress);
}
} // namespace tyndall::voxel_dag
