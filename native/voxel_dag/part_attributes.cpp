// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/part_attributes.hpp"
#include "core/parallel.hpp"
#include <bit>

namespace tyndall::voxel_dag {
namespace {
/// Of each node of 16^3.
struct SmallestNodes {
    std::vector<std::uint64_t> codes;
    std::vector<SampleSum> sums;
};
SmallestNodes smallest_nodes(const LeafMasks& leaves, const VoxelAttributes& attributes, const Progress& progress) {
    constexpr std::uint32_t bricks_bits = 3 * (least_mean_level - leaf_level);
    SmallestNodes nodes;
    std::vector<std::uint64_t> first_voxel;
    std::uint64_t voxel_count = 0;
    for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick) {
        const std::uint64_t code = leaves.codes[brick] >> bricks_bits;
        if (nodes.codes.empty() || nodes.codes.back() != code) {
            nodes.codes.push_back(code);
            first_voxel.push_back(voxel_count);
        }
        voxel_count += static_cast<std::uint64_t>(std::popcount(leaves.masks[brick]));
    }
    first_voxel.push_back(voxel_count);
    nodes.sums.resize(nodes.codes.size());
    parallel_for(nodes.codes.size(), progress, [&](std::size_t node) {
        nodes.sums[node] = given_sum(attributes, first_voxel[node], first_voxel[node + 1] - first_voxel[node]);
    });
    return nodes;
}

/// The sums of all nodes of 16^3 and more, each before its children.
std::vector<SampleSum> sums_of_nodes(const SmallestNodes& smallest, std::uint32_t level) {
    std::vector<SampleSum> sums;
    std::array<std::size_t, most_level + 1> open{}; // by level, the node that the next smallest one may lie in
    for (std::size_t i = 0; i < smallest.codes.size(); ++i) {
        std::uint32_t highest = level; // of the nodes that begin here
        if (i > 0)
            highest = least_mean_level +
                      (static_cast<std::uint32_t>(std::bit_width(smallest.codes[i - 1] ^ smallest.codes[i])) - 1) / 3;
        for (std::uint32_t at = highest; at >= least_mean_level; --at) {
            open[at] = sums.size();
            sums.emplace_back();
        }
        for (std::uint32_t at = least_mean_level; at <= level; ++at)
            sums[open[at]] += smallest.sums[i];
    }
    return sums;
}

CountedMaterials counted(JointMaterials& joint) {
    CountedMaterials table{.columns = std::move(joint.columns), .counts = {}};
    table.counts.resize(table.columns.front().size());
    for (const std::uint32_t index : joint.indices)
        ++table.counts[index];
    return table;
}

JointMaterials means_of(const std::vector<SampleSum>& sums, const AttributeLayout& layout, const Progress& progress) {
    std::vector<AttributeColumn> columns(layout.column_count(), AttributeColumn(sums.size()));
    parallel_for(sums.size(), progress, [&](std::size_t node) {
        std::array<std::uint32_t, 2 + VoxelAttributes::most_channels> row;
        put_mean(sums[node].mean(), layout, row);
        for (std::size_t column = 0; column < columns.size(); ++column)
            columns[column][node] = row[column];
    });
    return join(std::vector<std::span<const std::uint32_t>>(columns.begin(), columns.end()), progress);
}
} // namespace

PartAttributes part_attributes(const LeafMasks& leaves, const VoxelAttributes& attributes,
                               const AttributeConfig& config, const Progress& progress) {
    PartAttributes part;
    {
        GivenMaterials given = given_materials(attributes, config, progress);
        part.materials = std::move(given.table);
        part.indices = run_array::encode(given.indices, {}, progress);
        part.normals = given.normals;
    }
    if (leaves.level < least_mean_level)
        return part;
    const std::vector<SampleSum> sums = sums_of_nodes(smallest_nodes(leaves, attributes, progress), leaves.level);
    part.sum = sums.front();
    JointMaterials means = means_of(sums, layout_of(attributes, config), progress);
    part.mean_indices = run_array::encode(means.indices, {}, progress);
    part.means = counted(means);
    return part;
}
} // namespace tyndall::voxel_dag
