// SPDX-License-Identifier: GPL-3.0-or-later
// A DAG in bytes, whose references name a table of the most used nodes, and say where each node's attributes are.
// Based on: Kol, dissertation, TU Delft 2018, 2.4.4: a reference of 1 to 4 bytes, of which 2 bits say whether 6, 14 or 22
//           are a rank in its level's table, or 30 the child's place. 2.4.1: nodes of the octree, voxels among them, are
//           numbered depth first; a child's number less its parent's goes with the reference, but for the first child's,
//           which is 1; in as many bytes as the largest one of the level needs.
// Differs:  offsets come before references, which vary in size. A node is in the table where that makes the file shorter.
//           Levels whose references are shorter without have no table: as many bytes each as the last place of the level
//           below needs.
// Bound:    1 byte for a node of 2 x 2 x 2 voxels; 2 bytes and more for others.
#pragma once
#include "baselines/layout_bytes.hpp"
#include "core/errors.hpp"
#include "voxel_dag/dag.hpp"
#include <algorithm>
#include <numeric>

namespace tyndall::baselines {
class EntropyDag {
public:
    struct Config {
        bool has_table = true, has_offsets = true;
    };
    struct Place {
        std::uint32_t at = 0, turn = 0; ///< In bytes of its level. No symmetry: the turn is always 0.
        std::uint64_t entry = 0;        ///< Its number in the octree.
    };
    struct Open {
        std::uint32_t child_mask, level;
        std::uint64_t entry;
        const std::uint8_t* behind_mask;
    };
    struct Leaf {
        const EntropyDag* dag = nullptr;
        Place place;
        std::uint32_t turn = 0;
    };

    [[nodiscard]] static Bytes encode(const voxel_dag::Dag& dag, const Config& config) {
        require(dag.symmetry == voxel_dag::Symmetry::None, "offsets go with references that turn nothing");
        std::vector<Nodes> levels = nodes_of(dag);
        Bytes bytes;
        append(bytes, dag.level);
        std::vector<Bytes> tables(levels.size()), records(levels.size());
        std::vector<std::uint32_t> reference_bytes(levels.size(), 0), offset_bytes(levels.size(), 0);
        std::vector<std::uint32_t> places; // of the level below's nodes
        std::vector<std::uint64_t> sizes;  // of what each stands for, in nodes of the octree
        for (std::size_t i = 0; i < levels.size(); ++i) {
            const Nodes& nodes = levels[i];
            std::vector<std::uint32_t> here;
            std::vector<std::uint64_t> size_here;
            if (i == 0) {
                for (const std::uint8_t mask : nodes.masks) {
                    here.push_back(static_cast<std::uint32_t>(records[0].size()));
                    size_here.push_back(1 + static_cast<std::uint64_t>(std::popcount(mask)));
                    records[0].push_back(mask);
                }
            } else {
                reference_bytes[i] = bytes_for(records[i - 1].size() - 1);
                const std::vector<std::uint32_t> ranks = make_table(nodes.children, places, tables[i]);
                std::uint64_t with_table = tables[i].size();
                for (const std::uint32_t child : nodes.children)
                    with_table += bytes_of_reference(ranks[child]);
                if (config.has_table && with_table < reference_bytes[i] * nodes.children.size())
                    reference_bytes[i] = 0;
                else
                    tables[i].clear();
                std::uint64_t largest = 0;
                each_offset(nodes, sizes, [&](std::uint64_t offset) { largest = std::max(largest, offset); });
                offset_bytes[i] = config.has_offsets ? bytes_for(largest) : 0;
                for (std::size_t node = 0; node < nodes.masks.size(); ++node) {
                    here.push_back(static_cast<std::uint32_t>(records[i].size()));
                    records[i].push_back(nodes.masks[node]);
                    std::uint64_t offset = 1;
                    for (std::size_t at = nodes.first[node]; at < nodes.first[node + 1]; ++at) {
                        if (at > nodes.first[node])
                            append(records[i], offset, offset_bytes[i]);
                        offset += sizes[nodes.children[at]];
                    }
                    size_here.push_back(offset);
                    for (std::size_t at = nodes.first[node]; at < nodes.first[node + 1]; ++at) {
                        const std::uint32_t child = nodes.children[at];
                        if (reference_bytes[i] == 0)
                            append_reference(records[i], ranks[child], places[child]);
                        else
                            append(records[i], places[child], reference_bytes[i]);
                    }
                }
            }
            require(records[i].size() >> 30 == 0, "a level of more than 1 GiB");
            places = std::move(here);
            sizes = std::move(size_here);
        }
        std::size_t begin = bytes.size() + level_bytes * levels.size();
        for (std::size_t i = 0; i < levels.size(); ++i) {
            append(bytes, static_cast<std::uint32_t>(begin));
            append(bytes, static_cast<std::uint32_t>(begin + tables[i].size()));
            append(bytes, reference_bytes[i] | offset_bytes[i] << 8);
            begin += tables[i].size() + records[i].size();
        }
        for (std::size_t i = 0; i < levels.size(); ++i) {
            bytes.insert(bytes.end(), tables[i].begin(), tables[i].end());
            bytes.insert(bytes.end(), records[i].begin(), records[i].end());
        }
        bytes.resize(bytes.size() + slack_bytes);
        return bytes;
    }

    explicit EntropyDag(Bytes bytes) : level(number_at<std::uint32_t>(bytes, 0)), bytes_(std::move(bytes)) {
        for (std::uint32_t i = 1; i <= level && !is_empty(); ++i) {
            const std::size_t at = header_bytes + level_bytes * (i - 1);
            const auto widths = number_at<std::uint32_t>(bytes_, at + 8);
            levels_[i] = {bytes_.data() + number_at<std::uint32_t>(bytes_, at),
                          bytes_.data() + number_at<std::uint32_t>(bytes_, at + 4), widths & 0xff, widths >> 8};
        }
    }
    EntropyDag(const EntropyDag&) = delete;
    EntropyDag& operator=(const EntropyDag&) = delete;
    [[nodiscard]] bool is_empty() const { return bytes_.size() <= header_bytes + slack_bytes; }
    [[nodiscard]] std::uint64_t byte_count() const { return bytes_.size(); }

    /// Of a node of 2^at_level voxels a side, its mask and what follows it.
    [[nodiscard]] Open open_at(std::uint32_t at_level, const Place& place) const {
        const std::uint8_t* const record = levels_[at_level].records + place.at;
        return {*record, at_level, place.entry, record + 1};
    }
    /// The number of the child `octant`, from its parent's on: of a voxel, which has no record, too.
    [[nodiscard]] std::uint64_t entry_of(const Open& open, std::uint32_t octant) const {
        const std::uint32_t before = rank_of(open.child_mask, octant), width = levels_[open.level].offset_bytes;
        if (open.level == 1)
            return open.entry + 1 + before;
        return open.entry + (before == 0 ? 1 : number_of(open.behind_mask + std::size_t{before - 1} * width, width));
    }
    [[nodiscard]] Place child(const Open& open, std::uint32_t octant) const {
        const Level& at_level = levels_[open.level];
        const std::uint32_t before = rank_of(open.child_mask, octant);
        const auto child_count = static_cast<std::uint32_t>(std::popcount(open.child_mask));
        const std::uint8_t* reference = open.behind_mask + std::size_t{child_count - 1} * at_level.offset_bytes;
        Place place{.entry = at_level.offset_bytes == 0 ? 0 : entry_of(open, octant)};
        if (at_level.reference_bytes != 0) {
            reference += std::size_t{before} * at_level.reference_bytes;
            place.at = static_cast<std::uint32_t>(number_of(reference, at_level.reference_bytes));
            return place;
        }
        for (std::uint32_t skipped = 0; skipped < before; ++skipped)
            reference += 1 + (*reference & 3);
        const std::uint32_t kind = *reference & 3u;
        const auto value = static_cast<std::uint32_t>(number_of(reference, 1 + kind) >> 2);
        if (kind == 3)
            place.at = value;
        else
            std::memcpy(&place.at, at_level.table + std::size_t{4} * value, 4);
        return place;
    }

    std::uint32_t level;

private:
    static constexpr std::size_t header_bytes = 4, level_bytes = 12;
    static constexpr std::size_t slack_bytes = 8; ///< Behind the last number, which is loaded as 8 bytes.
    static constexpr std::uint32_t no_rank = ~0u;

    /// All nodes of a level as lists; of 2 x 2 x 2 voxels, masks alone.
    struct Nodes {
        std::vector<std::uint8_t> masks;
        std::vector<std::size_t> first;
        std::vector<std::uint32_t> children;
    };
    struct Level {
        const std::uint8_t* table = nullptr;
        const std::uint8_t* records = nullptr;
        std::uint32_t reference_bytes = 0, offset_bytes = 0; ///< reference_bytes: 0 where there is a table.
    };

    static std::uint32_t bytes_for(std::uint64_t largest) {
        return std::max(1u, (static_cast<std::uint32_t>(std::bit_width(largest)) + 7) / 8);
    }
    static std::uint64_t number_of(const std::uint8_t* bytes, std::uint32_t width) {
        std::uint64_t number;
        std::memcpy(&number, bytes, 8);
        return number & ((std::uint64_t{1} << 8 * width) - 1);
    }
    /// [i]: of nodes of 2^(1 + i) voxels a side.
    static std::vector<Nodes> nodes_of(const voxel_dag::Dag& dag) {
        std::vector<Nodes> levels;
        if (dag.is_empty())
            return levels;
        levels.resize(dag.level);
        std::vector<std::uint32_t> number(256, no_rank);
        for (const std::uint64_t leaf : dag.leaves) {
            levels[1].masks.push_back(static_cast<std::uint8_t>(voxel_dag::occupied_bytes(leaf)));
            levels[1].first.push_back(levels[1].children.size());
            for (std::uint32_t octant = 0; octant < 8; ++octant) {
                const auto group = static_cast<std::uint8_t>(leaf >> 8 * octant);
                if (group == 0)
                    continue;
                if (number[group] == no_rank) {
                    number[group] = static_cast<std::uint32_t>(levels[0].masks.size());
                    levels[0].masks.push_back(group);
                }
                levels[1].children.push_back(number[group]);
            }
        }
        levels[1].first.push_back(levels[1].children.size());
        for (std::size_t i = 0; i < dag.levels.size(); ++i)
            levels[i + 2] = {dag.levels[i].child_masks,
                             {dag.levels[i].first_children.begin(), dag.levels[i].first_children.end()},
                             dag.levels[i].children};
        return levels;
    }
    template <class Visit>
    static void each_offset(const Nodes& nodes, const std::vector<std::uint64_t>& sizes, const Visit& visit) {
        for (std::size_t node = 0; node < nodes.masks.size(); ++node) {
            std::uint64_t offset = 1;
            for (std::size_t at = nodes.first[node]; at + 1 < nodes.first[node + 1]; ++at)
                visit(offset += sizes[nodes.children[at]]);
        }
    }
    static std::uint32_t bytes_of_rank(std::uint32_t rank) { return rank >> 6 == 0 ? 1 : rank >> 14 == 0 ? 2 : 3; }
    static std::uint32_t bytes_of_reference(std::uint32_t rank) { return rank == no_rank ? 4 : bytes_of_rank(rank); }
    /// The ranks of the children that the table has; the others have none.
    static std::vector<std::uint32_t> make_table(const std::vector<std::uint32_t>& children,
                                                 const std::vector<std::uint32_t>& places, Bytes& table) {
        std::vector<std::uint32_t> uses(places.size(), 0), order(places.size()), ranks(places.size(), no_rank);
        for (const std::uint32_t child : children)
            ++uses[child];
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::stable_sort(order, std::greater(), [&](std::uint32_t node) { return uses[node]; });
        for (std::uint32_t rank = 0; rank < order.size() && rank >> 22 == 0; ++rank) {
            if (uses[order[rank]] * (4 - bytes_of_rank(rank)) <= 4)
                break;
            ranks[order[rank]] = rank;
            append(table, places[order[rank]]);
        }
        return ranks;
    }
    static void append_reference(Bytes& bytes, std::uint32_t rank, std::uint32_t place) {
        const std::uint32_t width = bytes_of_reference(rank);
        const std::uint32_t value = rank == no_rank ? place : rank;
        append(bytes, std::uint64_t{value} << 2 | (width - 1), width);
    }

    Bytes bytes_;
    std::array<Level, voxel_dag::most_level + 1> levels_{}; ///< By level.
};

inline EntropyDag::Place root_of(const EntropyDag&) { return {}; }
inline EntropyDag::Open opened(const EntropyDag& dag, std::uint32_t level, const EntropyDag::Place& place) {
    return dag.open_at(level, place);
}
inline EntropyDag::Place child_of(const EntropyDag& dag, std::uint32_t, const EntropyDag::Place&,
                                  const EntropyDag::Open& open, std::uint32_t octant) {
    return dag.child(open, octant);
}
inline EntropyDag::Leaf leaf_of(const EntropyDag& dag, const EntropyDag::Place& place) { return {&dag, place, 0}; }
inline std::uint32_t groups_of(const EntropyDag::Leaf& leaf) {
    return leaf.dag->open_at(voxel_dag::leaf_level, leaf.place).child_mask;
}
inline std::uint32_t group_of(const EntropyDag::Leaf& leaf, std::uint32_t octant) {
    const EntropyDag::Open open = leaf.dag->open_at(voxel_dag::leaf_level, leaf.place);
    return leaf.dag->open_at(1, leaf.dag->child(open, octant)).child_mask;
}
/// The number of a voxel that is set, among all nodes of the octree, depth first: its attributes' place.
[[nodiscard]] inline std::uint64_t entry_of(const EntropyDag& dag, const voxel_dag::Voxel& voxel) {
    const std::uint64_t code = voxel_dag::morton_code(voxel);
    EntropyDag::Place place;
    for (std::uint32_t level = dag.level; level > 1; --level)
        place = dag.child(dag.open_at(level, place), static_cast<std::uint32_t>(code >> 3 * (level - 1) & 7));
    return dag.entry_of(dag.open_at(1, place), static_cast<std::uint32_t>(code & 7));
}
} // namespace tyndall::baselines
