// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/encode_attributes.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/stored_walk.hpp"

namespace tyndall::voxel_dag {
namespace {
/// Of nodes of 16^3, from the voxels; above, from those below.
struct Averaging {
    using Sum = SampleSum;
    static constexpr std::uint32_t least_level = least_mean_level;

    Sum at_end(const StoredPlace& place, const MortonPlace& morton, std::uint64_t voxel_count) const {
        const SampleSum sum = given_sum(given, morton.first_voxel, voxel_count);
        keep(place.number, sum);
        return sum;
    }
    Sum joined(const StoredPlace& place, const MortonPlace&, const std::array<Sum, 8>& children) const {
        SampleSum sum;
        for (const Sum& child : children)
            sum += child;
        keep(place.number, sum);
        return sum;
    }
    void keep(std::uint64_t number, const SampleSum& sum) const {
        std::array<std::uint32_t, 2 + VoxelAttributes::most_channels> row;
        put_mean(sum.mean(), layout, row);
        for (std::size_t column = 0; column < columns.size(); ++column)
            columns[column][number] = row[column];
    }

    const VoxelAttributes& given;
    const AttributeLayout& layout;
    std::span<AttributeColumn> columns; ///< By number.
};

MaterialBytes mean_bytes(const PackedDag& dag, const AttributeParts& parts, const VoxelAttributes& attributes,
                         const Progress& progress) {
    std::vector<AttributeColumn> columns(parts.layout.column_count(), AttributeColumn(parts.order.node_count));
    const Averaging averaging{attributes, parts.layout, columns};
    StoredWalk(dag, parts.order, averaging, progress).run(stored_tree(dag, parts.order));
    const JointMaterials joint =
        join(std::vector<std::span<const std::uint32_t>>(columns.begin(), columns.end()), progress);
    return {.materials = encode_columns(joint.columns), .indices = run_array::encode(joint.indices, {}, progress)};
}
} // namespace

std::shared_ptr<const DagAttributes> encode_attributes(const PackedDag& dag, const VoxelAttributes& attributes,
                                                       const AttributeConfig& config, const Progress& progress) {
    require_usable(attributes, dag.voxel_count);
    require_usable(config);
    AttributeParts parts;
    parts.order = stored_order_of(dag, progress);
    {
        GivenMaterials given = given_materials(attributes, config, progress);
        const KeptMaterials kept = kept_materials(given.table, given.layout, config, progress);
        parts.layout = std::move(given.layout);
        parts.errors = {.mean_cie94 = kept.mean_cie94,
                        .most_cie94 = kept.most_cie94,
                        .mean_degrees = given.normals.mean_degrees(dag.voxel_count),
                        .most_degrees = given.normals.most_degrees};
        for (std::uint32_t& index : given.indices)
            index = kept.number_of[index];
        AttributeColumn stored(given.indices.size());
        to_stored_order(dag, parts.order, given.indices, stored, progress);
        given.indices = {};
        parts.voxels = {.materials = encode_columns(kept.columns), .indices = run_array::encode(stored, {}, progress)};
    }
    if (config.has_means && parts.order.node_count > 0)
        parts.means = mean_bytes(dag, parts, attributes, progress);
    return std::make_shared<const DagAttributes>(std::move(parts), dag);
}
} // namespace tyndall::voxel_dag
