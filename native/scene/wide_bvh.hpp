// SPDX-License-Identifier: GPL-3.0-or-later
// A bounding volume hierarchy with 16 children per node, laid out for tests of a plane against 16 boxes at once.
// Based on: Wald, Benthin and Boulos, Getting Rid of Packets, IEEE Interactive Ray Tracing 2008; built by Embree's
//           rtcBuildBVH (surface area heuristic, parallel).
// Differs:  boxes are stored as centre and half extent: a linear function's range over a box is its value at the centre
//           plus or minus the absolute function of the half extent.
// Bound:    448 bytes per node; a leaf holds up to leaf_size primitives.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <array>
#include <cstdint>
#include <embree3/rtcore.h>
#include <span>
#include <vector>

namespace tyndall {
class WideBvh {
public:
    static constexpr std::size_t width = 16;
    static constexpr std::uint32_t leaf_bit = 0x80000000u;
    struct alignas(64) Node {
        float centre[3][width], half_extent[3][width]; ///< Half extents of absent children are -infinity.
        /// A node's index, or leaf_bit and a leaf's index.
        std::uint32_t child[width];
    };
    struct Leaf {
        std::array<std::uint32_t, width> primitives;
        std::uint32_t count;
    };

    WideBvh() = default;
    /// Boxes must be finite. Throws Cancelled.
    WideBvh(RTCDevice device, std::span<const Bounds3> boxes, std::size_t leaf_size, const Progress& progress);

    [[nodiscard]] bool is_empty() const { return nodes_.empty(); }
    /// The root comes first; children follow their parents.
    [[nodiscard]] std::span<const Node> nodes() const { return nodes_; }
    [[nodiscard]] std::span<const Leaf> leaves() const { return leaves_; }
    void forget_leaves() { leaves_ = {}; }
    [[nodiscard]] std::uint32_t depth() const { return depth_; }

private:
    std::vector<Node> nodes_;
    std::vector<Leaf> leaves_;
    std::uint32_t depth_ = 0;
};
} // namespace tyndall
