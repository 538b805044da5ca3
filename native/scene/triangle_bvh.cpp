// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/triangle_bvh.hpp"
#include "core/parallel.hpp"

namespace tyndall {
static void set_lane(TriangleBvh::Block& block, std::size_t lane, std::uint32_t number,
                     const TriangleBvh::Triangle& corners) {
    block.triangle[lane] = number;
    for (int corner = 0; corner < 3; ++corner)
        for (int axis = 0; axis < 3; ++axis)
            block.corner[corner][axis][lane] = corners[corner][axis];
}
static TriangleBvh::Triangle point_of(const TriangleBvh::Triangle& triangle) {
    return {triangle[0], triangle[0], triangle[0]};
}

TriangleBvh::TriangleBvh(RTCDevice device, const SharedMeshArrays& arrays, const Progress& progress) {
    const auto corners_of = [&](std::size_t triangle) -> Triangle {
        const uvec3& corners = arrays.triangles[triangle];
        return {arrays.positions[corners.x], arrays.positions[corners.y], arrays.positions[corners.z]};
    };
    std::vector<Bounds3> boxes(arrays.triangles.size());
    parallel_for(boxes.size(), progress, [&](std::size_t triangle) {
        for (const vec3& corner : corners_of(triangle))
            boxes[triangle].grow(corner);
    });
    tree_ = WideBvh(device, boxes, WideBvh::width, progress);
    for (const Bounds3& box : boxes)
        bounds_.grow(box);
    blocks_.resize(tree_.leaves().size());
    parallel_for(blocks_.size(), progress, [&](std::size_t index) {
        const WideBvh::Leaf& leaf = tree_.leaves()[index];
        Block& block = blocks_[index];
        block.count = leaf.count;
        for (std::size_t lane = 0; lane < WideBvh::width; ++lane) {
            const bool is_used = lane < leaf.count;
            const std::uint32_t triangle = leaf.primitives[is_used ? lane : 0];
            set_lane(block, lane, triangle, is_used ? corners_of(triangle) : point_of(corners_of(triangle)));
        }
    });
    tree_.forget_leaves();
}

TriangleBvh::TriangleBvh(RTCDevice device, std::size_t group_count, std::size_t group_size, const WriteGroup& write,
                         const Progress& progress)
    : blocks_per_leaf_((group_size + WideBvh::width - 1) / WideBvh::width) {
    const auto written = [&](std::size_t group) -> std::span<const Triangle> {
        thread_local std::vector<Triangle> triangles;
        triangles.resize(group_size);
        write(group, triangles);
        return triangles;
    };
    std::vector<Bounds3> boxes(group_count);
    parallel_for(group_count, progress, [&](std::size_t group) {
        for (const Triangle& triangle : written(group))
            for (const vec3& corner : triangle)
                boxes[group].grow(corner);
    });
    tree_ = WideBvh(device, boxes, 1, progress);
    for (const Bounds3& box : boxes)
        bounds_.grow(box);
    blocks_.resize(tree_.leaves().size() * blocks_per_leaf_);
    parallel_for(tree_.leaves().size(), progress, [&](std::size_t leaf) {
        const std::size_t group = tree_.leaves()[leaf].primitives[0];
        const std::span<const Triangle> triangles = written(group);
        for (std::size_t place = 0; place < blocks_per_leaf_ * WideBvh::width; ++place) {
            Block& block = blocks_[leaf * blocks_per_leaf_ + place / WideBvh::width];
            const bool is_used = place < group_size;
            const std::size_t triangle = is_used ? place : 0;
            set_lane(block, place % WideBvh::width, static_cast<std::uint32_t>(group * group_size + triangle),
                     is_used ? triangles[triangle] : point_of(triangles[triangle]));
            block.count += is_used ? 1 : 0; // blocks begin as zeros
        }
    });
    tree_.forget_leaves();
}
} // namespace tyndall
