// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes of every node of an octree, as published structures have them: in depth-first order, a node before its
// children, larger nodes with the mean of their voxels; and how many nodes are left where colours must be equal, too.
#pragma once
#include "voxel_dag/attribute_means.hpp"
#include "voxel_dag/fingerprint.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include "voxel_dag/voxel_attributes.hpp"
#include <algorithm>
#include <bit>
#include <span>

namespace tyndall::bench {
/// visitor.enter(octant), for a node of 2 x 2 x 2 voxels or more, before its children; visitor.voxel(octant);
/// visitor.leave() after a node's children.
template <class Visitor>
class DepthFirst {
public:
    DepthFirst(const voxel_dag::LeafMasks& leaves, Visitor& visitor) : leaves_(leaves), visitor_(visitor) {}
    void run() { visit(leaves_.level, 0, 0, leaves_.codes.size(), 0); }

private:
    void visit(std::uint32_t level, std::uint64_t prefix, std::size_t begin, std::size_t end, std::uint32_t octant) {
        visitor_.enter(octant);
        if (level == voxel_dag::leaf_level)
            visit_brick(leaves_.masks[begin]);
        else
            for (std::uint32_t child = 0; child < 8 && begin < end; ++child) {
                const std::uint64_t after = (prefix * 8 + child + 1) << 3 * (level - 1 - voxel_dag::leaf_level);
                const auto first = leaves_.codes.begin() + static_cast<std::ptrdiff_t>(begin);
                const auto last = leaves_.codes.begin() + static_cast<std::ptrdiff_t>(end);
                const auto middle =
                    static_cast<std::size_t>(std::lower_bound(first, last, after) - leaves_.codes.begin());
                if (begin < middle)
                    visit(level - 1, prefix * 8 + child, begin, middle, child);
                begin = middle;
            }
        visitor_.leave();
    }
    void visit_brick(std::uint64_t mask) {
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            const std::uint64_t eighth = mask >> 8 * octant & 0xff;
            if (eighth == 0)
                continue;
            visitor_.enter(octant);
            for (std::uint64_t left = eighth; left != 0; left &= left - 1)
                visitor_.voxel(static_cast<std::uint32_t>(std::countr_zero(left)));
            visitor_.leave();
        }
    }
    const voxel_dag::LeafMasks& leaves_;
    Visitor& visitor_;
};

/// Depth first; normals of 32 bits. What voxels have none of is empty.
struct TreeEntries {
    std::vector<std::uint32_t> colors, normals;
    std::uint64_t inner_count = 0, child_count = 0; ///< Nodes with children, and their children.
};
class EntriesVisitor {
public:
    explicit EntriesVisitor(const voxel_dag::VoxelAttributes& given) : given_(given) {}
    void enter(std::uint32_t) {
        count_child();
        ++entries.inner_count;
        slots_.push_back(entry_count_++);
        sums_.emplace_back();
        append({});
    }
    void voxel(std::uint32_t) {
        count_child();
        ++entry_count_;
        voxel_dag::VoxelSample sample;
        if (!given_.colors.empty())
            entries.colors.push_back(sample.color = given_.colors[next_]);
        if (!given_.normals.empty()) {
            entries.normals.push_back(given_.normals[next_]);
            sample.normal =
                vec3(voxel_dag::octahedral::decode(given_.normals[next_], voxel_dag::octahedral::most_bits));
        }
        sums_.back().add(sample);
        ++next_;
    }
    void leave() {
        const voxel_dag::VoxelSample mean = sums_.back().mean();
        if (!given_.colors.empty())
            entries.colors[slots_.back()] = mean.color;
        if (!given_.normals.empty())
            entries.normals[slots_.back()] = voxel_dag::octahedral::encode_rounded(dvec3(mean.normal));
        if (sums_.size() > 1)
            sums_[sums_.size() - 2] += sums_.back();
        sums_.pop_back(), slots_.pop_back();
    }
    TreeEntries entries;

private:
    void count_child() { entries.child_count += !slots_.empty(); }
    void append(const voxel_dag::VoxelSample& sample) {
        if (!given_.colors.empty())
            entries.colors.push_back(sample.color);
        if (!given_.normals.empty())
            entries.normals.push_back(0);
    }
    const voxel_dag::VoxelAttributes& given_;
    std::vector<std::size_t> slots_; // of the nodes on the way down
    std::vector<voxel_dag::SampleSum> sums_;
    std::size_t next_ = 0, entry_count_ = 0;
};
inline TreeEntries tree_entries(const voxel_dag::LeafMasks& leaves, const voxel_dag::VoxelAttributes& given) {
    EntriesVisitor visitor(given);
    DepthFirst(leaves, visitor).run();
    return std::move(visitor.entries);
}

/// Nodes of a DAG that shares only what also has equal values.
struct ValuedDag {
    std::uint64_t inner_count = 0, reference_count = 0, leaf_count = 0;
};
class ValuedDagVisitor {
public:
    /// One value per node, depth first.
    explicit ValuedDagVisitor(std::span<const std::uint32_t> values) : values_(values) {}
    void enter(std::uint32_t octant) {
        open_.push_back({.octant = octant});
        open_.back().print.add_word(values_[next_++]);
    }
    void voxel(std::uint32_t octant) {
        ++open_.back().child_count;
        leaves_.push_back(values_[next_]);
        open_.back().print.add_word(std::uint64_t{octant} << 32 | values_[next_++]);
    }
    void leave() {
        const Open closed = open_.back();
        open_.pop_back();
        const auto& print = closed.print.value();
        inner_.push_back({print[0], print[1], closed.child_count});
        if (open_.empty())
            return;
        ++open_.back().child_count;
        for (const std::uint64_t word : {std::uint64_t{closed.octant} << 40, print[0], print[1]})
            open_.back().print.add_word(word);
    }
    ValuedDag count() {
        std::ranges::sort(inner_);
        inner_.erase(std::ranges::unique(inner_).begin(), inner_.end());
        std::ranges::sort(leaves_);
        leaves_.erase(std::ranges::unique(leaves_).begin(), leaves_.end());
        ValuedDag dag{.inner_count = inner_.size(), .leaf_count = leaves_.size()};
        for (const auto& node : inner_)
            dag.reference_count += node[2];
        return dag;
    }

private:
    struct Open {
        voxel_dag::Fingerprint print = {};
        std::uint32_t octant = 0;
        std::uint64_t child_count = 0;
    };
    std::span<const std::uint32_t> values_;
    std::size_t next_ = 0;
    std::vector<Open> open_;
    std::vector<std::array<std::uint64_t, 3>> inner_; // fingerprint, children
    std::vector<std::uint32_t> leaves_;
};
inline ValuedDag valued_dag(const voxel_dag::LeafMasks& leaves, std::span<const std::uint32_t> values) {
    ValuedDagVisitor visitor(values);
    DepthFirst(leaves, visitor).run();
    return visitor.count();
}
} // namespace tyndall::bench
