// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/join_attributes.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/material_rows.hpp"
#include "voxel_dag/stored_walk.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
namespace {
/// A node above the parts, or a part's root.
struct UpperNode {
    StoredSubtree subtree;
    std::uint64_t code; ///< Of Morton, among cubes of its size.
};
/// All of them, each before its children and in stored order.
class UpperTree {
public:
    UpperTree(const PackedDag& dag, const StoredOrder& order, std::uint32_t part_level)
        : dag_(dag), order_(order), part_level_(part_level) {
        visit({.subtree = stored_tree(dag, order), .code = 0});
    }
    std::vector<UpperNode> nodes;

private:
    void visit(const UpperNode& at) {
        nodes.push_back(at);
        if (at.subtree.level == part_level_)
            return;
        const StoredChildren children = stored_children(dag_, order_, at.subtree);
        for (std::uint32_t octant = 0; octant < 8; ++octant)
            if ((children.child_mask >> octant & 1) != 0)
                visit({.subtree = {.level = at.subtree.level - 1,
                                   .place = children.places[octant],
                                   .voxel_count = children.voxel_counts[octant],
                                   .node_count = children.node_counts[octant]},
                       .code = at.code << 3 | cube_group.octant[at.subtree.place.node.turn][octant]});
    }
    const PackedDag& dag_;
    const StoredOrder& order_;
    std::uint32_t part_level_;
};

class AttributeJoining {
public:
    AttributeJoining(std::span<const PartFile> parts, const PackedDag& dag, const JoinAttributesConfig& config,
                     const Progress& progress, const std::function<void(double)>& report)
        : config_(config), dag_(dag), progress_(progress), report_(report) {
        for (const PartFile& part : parts)
            if (!part.is_empty())
                parts_.push_back(&part);
    }

    StreamedAttributes run() {
        result_.parts.layout = config_.layout;
        result_.parts.order = stored_order_of(dag_, progress_);
        const std::vector<UpperNode> nodes = UpperTree(dag_, result_.parts.order, config_.part_level).nodes;
        read_tables(nodes);
        require_room(nodes);
        result_.voxels = encoder(kept_.count());
        if (has_means())
            result_.means = encoder(static_cast<std::uint32_t>(means_.counts.size()));
        std::uint64_t done = 0;
        for (const Step step : {&run_array::Encoder::learn, &run_array::Encoder::add})
            for (const UpperNode& node : nodes) {
                progress_.poll();
                if (node.subtree.level != config_.part_level) {
                    if (has_means())
                        ((*result_.means).*step)(std::array{RowFinder(means_).number_of(mean_row(sum_below(node)))},
                                                 progress_);
                    continue;
                }
                give_part(node, step);
                done += node.subtree.voxel_count;
                report_(0.5 * static_cast<double>(done) / static_cast<double>(dag_.voxel_count));
            }
        result_.voxels->finish(progress_);
        if (has_means())
            result_.means->finish(progress_);
        return std::move(result_);
    }

private:
    /// What an encoder does with values.
    using Step = void (run_array::Encoder::*)(std::span<const std::uint32_t>, const Progress&);

    [[nodiscard]] bool has_means() const { return config_.attributes.has_means && result_.parts.order.node_count > 0; }
    [[nodiscard]] std::unique_ptr<run_array::Encoder> encoder(std::uint64_t value_count) const {
        return std::make_unique<run_array::Encoder>(run_array::Config{}, bits_for(value_count),
                                                    SpilledBytes(config_.folder), SpilledBytes(config_.folder));
    }

    /// The tables of all parts as one, and the sums of each.
    void read_tables(const std::vector<UpperNode>& nodes) {
        const std::size_t column_count = config_.layout.column_count();
        const std::uint64_t budget_bytes = config_.attributes.memory_budget_bytes;
        MaterialRows materials(column_count, budget_bytes), means(column_count, budget_bytes);
        NormalErrors normals;
        for (const PartFile* part : parts_) {
            const PartTables tables = part->read_tables(column_count, progress_);
            materials.add(tables.materials, progress_);
            means.add(tables.means, progress_);
            sums_.push_back(tables.sum);
            normals += tables.normals;
        }
        if (has_means()) {
            CountedMaterials above{.columns = std::vector<AttributeColumn>(column_count), .counts = {}};
            for (const UpperNode& node : nodes) {
                const auto row = mean_row(sum_below(node));
                for (std::size_t column = 0; column < column_count; ++column)
                    above.columns[column].push_back(row[column]);
                above.counts.push_back(1);
            }
            means.add(above, progress_);
            means_ = means.take(progress_);
            result_.parts.means.materials = encode_columns(means_.columns);
        }
        materials_ = materials.take(progress_);
        kept_ = kept_materials(materials_, config_.layout, config_.attributes, progress_);
        result_.parts.voxels.materials = encode_columns(kept_.columns);
        result_.parts.errors = {.mean_cie94 = kept_.mean_cie94,
                                .most_cie94 = kept_.most_cie94,
                                .mean_degrees = normals.mean_degrees(dag_.voxel_count),
                                .most_degrees = normals.most_degrees};
    }

    void require_room(const std::vector<UpperNode>& nodes) const {
        std::uint64_t most_voxels = 0;
        for (const UpperNode& node : nodes)
            if (node.subtree.level == config_.part_level)
                most_voxels = std::max(most_voxels, node.subtree.voxel_count);
        constexpr std::uint64_t known_blocks_bytes = 64 << 20;
        const std::uint64_t row_bytes = 4 * config_.layout.column_count() + 8;
        const std::uint64_t bytes = dag_.byte_count() + result_.parts.order.byte_count() + 10 * most_voxels +
                                    row_bytes * (2 * materials_.counts.size() + means_.counts.size()) +
                                    std::min(known_blocks_bytes, dag_.voxel_count / 16);
        require(bytes <= config_.attributes.memory_budget_bytes, "attributes: joining those of ", parts_.size(),
                " parts takes about ", bytes >> 20, " MiB, and the budget is ",
                config_.attributes.memory_budget_bytes >> 20, " MiB: allow more");
    }

    [[nodiscard]] std::size_t part_of(std::uint64_t code) const {
        return static_cast<std::size_t>(
            std::ranges::lower_bound(parts_, code, {}, [](const PartFile* part) { return part->code(); }) -
            parts_.begin());
    }
    [[nodiscard]] SampleSum sum_below(const UpperNode& node) const {
        const std::uint32_t shift = 3 * (node.subtree.level - config_.part_level);
        SampleSum sum;
        for (std::size_t part = part_of(node.code << shift); part < part_of((node.code + 1) << shift); ++part)
            sum += sums_[part];
        return sum;
    }
    [[nodiscard]] std::vector<std::uint32_t> mean_row(const SampleSum& sum) const {
        std::vector<std::uint32_t> row(config_.layout.column_count());
        put_mean(sum.mean(), config_.layout, row);
        return row;
    }

    void give_part(const UpperNode& node, Step step) {
        const PartFile& part = *parts_[part_of(node.code)];
        const std::size_t column_count = config_.layout.column_count();
        const PartTables tables = part.read_tables(column_count, progress_);
        std::vector<std::uint32_t> numbers = RowFinder(materials_).numbers_of(tables.materials.columns);
        for (std::uint32_t& number : numbers)
            number = kept_.number_of[number];
        const auto stored = [&](const std::vector<std::uint8_t>& indices, std::uint64_t count, const auto& put) {
            AttributeColumn values = decoded(indices, numbers, count, part);
            AttributeColumn in_order(values.size());
            put(dag_, result_.parts.order, node.subtree, values, in_order, progress_);
            return in_order;
        };
        const auto put_voxels = [](auto&&... arguments) { to_stored_order(arguments...); };
        ((*result_.voxels).*step)(stored(part.read_indices(progress_), node.subtree.voxel_count, put_voxels),
                                  progress_);
        if (!has_means())
            return;
        numbers = RowFinder(means_).numbers_of(tables.means.columns);
        const auto put_nodes = [](auto&&... arguments) { nodes_to_stored_order(arguments...); };
        ((*result_.means).*step)(stored(part.read_mean_indices(progress_), node.subtree.node_count, put_nodes),
                                 progress_);
    }
    /// What the numbers of a part's table stand for in the whole's.
    [[nodiscard]] AttributeColumn decoded(const std::vector<std::uint8_t>& bytes,
                                          std::span<const std::uint32_t> numbers, std::uint64_t count,
                                          const PartFile& part) const {
        constexpr std::size_t block = 1 << 16;
        const RunArray array(bytes);
        require(array.size() == count, "voxel DAG: part ", part.code(), " has attributes of ", array.size(),
                " voxels or nodes instead of ", count, ": remove its folder, and begin anew");
        AttributeColumn values(static_cast<std::size_t>(count));
        parallel_blocks(values.size(), block, progress_, [&](std::size_t begin, std::size_t end) {
            const auto some = std::span(values).subspan(begin, end - begin);
            array.decode(begin, some);
            for (std::uint32_t& value : some)
                value = numbers[value];
        });
        return values;
    }

    const JoinAttributesConfig& config_;
    const PackedDag& dag_;
    const Progress& progress_;
    const std::function<void(double)>& report_;
    std::vector<const PartFile*> parts_; ///< Those that have voxels.
    std::vector<SampleSum> sums_;        ///< Of each.
    CountedMaterials materials_, means_; ///< Of all; colours as they were given.
    KeptMaterials kept_;
    StreamedAttributes result_;
};
} // namespace

StreamedAttributes join_attributes(std::span<const PartFile> parts, const PackedDag& dag,
                                   const JoinAttributesConfig& config, const Progress& progress,
                                   const std::function<void(double)>& report) {
    return AttributeJoining(parts, dag, config, progress, report).run();
}
} // namespace tyndall::voxel_dag
