// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh's triangles in a wide hierarchy, for cuts with planes: 16 boxes and 16 triangles per step.
// It lies in object space and holds no light, view or instance: none of them, when moved, makes it stale.
#pragma once
#include "scene/triangle_mesh.hpp"
#include "scene/wide_bvh.hpp"

namespace tyndall {
class TriangleBvh {
public:
    /// 16 triangles side by side. Unused lanes are points, which no plane cuts.
    struct alignas(64) Block {
        float corner[3][3][WideBvh::width]; ///< [corner][axis][lane]
        std::uint32_t triangle[WideBvh::width];
        std::uint32_t count; ///< Used lanes, the first.
    };
    /// Throws Cancelled.
    TriangleBvh(RTCDevice device, const SharedMeshArrays& arrays, const Progress& progress);

    [[nodiscard]] std::span<const WideBvh::Node> nodes() const { return tree_.nodes(); }
    [[nodiscard]] std::span<const Block> blocks() const { return blocks_; } ///< One per leaf.
    [[nodiscard]] std::uint32_t depth() const { return tree_.depth(); }
    /// Largest absolute coordinate per axis: what rounding errors are measured by.
    [[nodiscard]] const vec3& reach() const { return reach_; }

private:
    WideBvh tree_;
    std::vector<Block> blocks_;
    vec3 reach_{0.0f};
};
} // namespace tyndall
