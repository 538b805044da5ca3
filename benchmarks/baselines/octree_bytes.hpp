// SPDX-License-Identifier: GPL-3.0-or-later
// An octree without pointers: a byte per node, level by level, from the root to nodes of 2 x 2 x 2 voxels.
// Based on: Schnabel, Klein, Octree-based Point-Cloud Compression, 2006, as Jaspe, dissertation 2018, 5.6.3, counts it.
// Differs:  to trace it, 4 bytes per node of 4 x 4 x 4 and more are made when it is opened: where its children begin.
// Bound:    one byte per node; decoded from front to back of each level.
#pragma once
#include "baselines/layout_bytes.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include <bit>

namespace tyndall::baselines {
class OctreeBytes {
public:
    /// A header of 4 bytes, the level; then the nodes.
    [[nodiscard]] static Bytes encode(const voxel_dag::LeafMasks& voxels) {
        std::vector<Bytes> levels(voxels.level); // [i]: nodes of 2^(1 + i) voxels a side
        for (const std::uint64_t mask : voxels.masks) {
            levels[1].push_back(static_cast<std::uint8_t>(voxel_dag::occupied_bytes(mask)));
            for (std::uint32_t octant = 0; octant < 8; ++octant)
                if (const auto group = static_cast<std::uint8_t>(mask >> 8 * octant); group != 0)
                    levels[0].push_back(group);
        }
        std::vector<std::uint64_t> codes = voxels.codes;
        for (std::uint32_t i = 2; i < voxels.level; ++i) {
            std::vector<std::uint64_t> above;
            for (const std::uint64_t code : codes) {
                if (above.empty() || above.back() != code >> 3) {
                    above.push_back(code >> 3);
                    levels[i].push_back(0);
                }
                levels[i].back() = static_cast<std::uint8_t>(levels[i].back() | 1u << (code & 7));
            }
            codes = std::move(above);
        }
        Bytes bytes;
        append(bytes, voxels.level);
        for (std::uint32_t i = voxels.level; i-- > 0;)
            bytes.insert(bytes.end(), levels[i].begin(), levels[i].end());
        return bytes;
    }

    explicit OctreeBytes(Bytes bytes) : level(number_at<std::uint32_t>(bytes, 0)), bytes_(std::move(bytes)) {
        std::size_t end = header_bytes + 1; // of the level at work
        for (std::uint32_t at = header_bytes, left = level; left > 1 && end <= bytes_.size() && at < end; --left) {
            std::size_t past = end;
            for (; at < end; ++at) {
                first_children_.push_back(static_cast<std::uint32_t>(past));
                past += static_cast<std::size_t>(std::popcount(bytes_[at]));
            }
            end = past;
        }
    }
    [[nodiscard]] bool is_empty() const { return bytes_.size() <= header_bytes; }
    [[nodiscard]] std::uint64_t byte_count() const { return bytes_.size(); }
    [[nodiscard]] std::uint64_t pointer_bytes() const { return 4 * first_children_.size(); }

    struct Place {
        std::uint32_t at = header_bytes;
        std::uint32_t turn = 0; ///< Always; what follows any tree asks for it.
    };
    struct Open {
        std::uint32_t child_mask, first_child;
    };
    /// A node of 4 x 4 x 4: its children are the groups of 8 voxels.
    struct Leaf {
        const OctreeBytes* tree = nullptr;
        Open open{};
        std::uint32_t turn = 0;
    };
    [[nodiscard]] Open open_at(std::uint32_t at) const { return {bytes_[at], first_children_[at - header_bytes]}; }
    [[nodiscard]] std::uint8_t byte_at(std::uint32_t at) const { return bytes_[at]; }

    std::uint32_t level;

private:
    static constexpr std::uint32_t header_bytes = 4;
    Bytes bytes_;
    std::vector<std::uint32_t> first_children_;
};

inline std::uint32_t child_at(const OctreeBytes::Open& open, std::uint32_t octant) {
    return open.first_child + rank_of(open.child_mask, octant);
}
inline OctreeBytes::Place root_of(const OctreeBytes&) { return {}; }
inline OctreeBytes::Open opened(const OctreeBytes& tree, std::uint32_t, const OctreeBytes::Place& place) {
    return tree.open_at(place.at);
}
inline OctreeBytes::Place child_of(const OctreeBytes&, std::uint32_t, const OctreeBytes::Place&,
                                   const OctreeBytes::Open& open, std::uint32_t octant) {
    return {.at = child_at(open, octant)};
}
inline OctreeBytes::Leaf leaf_of(const OctreeBytes& tree, const OctreeBytes::Place& place) {
    return {&tree, tree.open_at(place.at), 0};
}
inline std::uint32_t groups_of(const OctreeBytes::Leaf& leaf) { return leaf.open.child_mask; }
inline std::uint32_t group_of(const OctreeBytes::Leaf& leaf, std::uint32_t octant) {
    return leaf.tree->byte_at(child_at(leaf.open, octant));
}
} // namespace tyndall::baselines
