// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh's triangles in a wide hierarchy, for cuts with planes: 16 boxes and 16 triangles per step.
// It lies in object space and holds no light, view or instance: none of them, when moved, makes it stale.
#pragma once
#include "scene/triangle_mesh.hpp"
#include "scene/wide_bvh.hpp"
#include <array>
#include <functional>
#include <span>

namespace tyndall {
class TriangleBvh {
public:
    /// 16 triangles side by side. Unused lanes are points, which no plane cuts.
    struct alignas(64) Block {
        float corner[3][3][WideBvh::width]; ///< [corner][axis][lane]
        std::uint32_t triangle[WideBvh::width];
        std::uint32_t count; ///< Used lanes, the first.
    };
    using Triangle = std::array<vec3, 3>;
    /// Writes the triangles of a group, as many for each. Called from many threads, and again with the same result.
    using WriteGroup = std::function<void(std::size_t group, std::span<Triangle>)>;

    /// Throws Cancelled.
    TriangleBvh(RTCDevice device, const SharedMeshArrays& arrays, const Progress& progress);
    /// Of small groups that lie close together, which are cut as one: a tree over as many boxes as there are groups.
    /// Throws Cancelled.
    TriangleBvh(RTCDevice device, std::size_t group_count, std::size_t group_size, const WriteGroup& write,
                const Progress& progress);

    [[nodiscard]] std::span<const WideBvh::Node> nodes() const { return tree_.nodes(); }
    [[nodiscard]] std::span<const Block> blocks_of(std::uint32_t leaf) const {
        return std::span(blocks_).subspan(leaf * blocks_per_leaf_, blocks_per_leaf_);
    }
    [[nodiscard]] std::uint32_t depth() const { return tree_.depth(); }
    [[nodiscard]] const Bounds3& bounds() const { return bounds_; }
    /// Largest absolute coordinate per axis: what rounding errors are measured by.
    [[nodiscard]] vec3 reach() const { return glm::max(glm::abs(bounds_.min), glm::abs(bounds_.max)); }

private:
    WideBvh tree_;
    std::vector<Block> blocks_;
    std::size_t blocks_per_leaf_ = 1;
    Bounds3 bounds_;
};
} // namespace tyndall
