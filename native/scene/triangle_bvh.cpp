// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/triangle_bvh.hpp"
#include "core/parallel.hpp"

namespace tyndall {
TriangleBvh::TriangleBvh(RTCDevice device, const SharedMeshArrays& arrays, const Progress& progress) {
    std::vector<Bounds3> boxes(arrays.triangles.size());
    parallel_for(boxes.size(), progress, [&](std::size_t triangle) {
        for (int corner = 0; corner < 3; ++corner)
            boxes[triangle].grow(arrays.positions[arrays.triangles[triangle][corner]]);
    });
    tree_ = WideBvh(device, boxes, WideBvh::width, progress);
    for (const Bounds3& box : boxes)
        reach_ = glm::max(reach_, glm::max(glm::abs(box.min), glm::abs(box.max)));
    blocks_.resize(tree_.leaves().size());
    parallel_for(blocks_.size(), progress, [&](std::size_t index) {
        const WideBvh::Leaf& leaf = tree_.leaves()[index];
        Block& block = blocks_[index];
        block.count = leaf.count;
        for (std::size_t lane = 0; lane < WideBvh::width; ++lane) {
            const bool is_used = lane < leaf.count;
            const std::uint32_t triangle = leaf.primitives[is_used ? lane : 0];
            block.triangle[lane] = triangle;
            for (int corner = 0; corner < 3; ++corner)
                for (int axis = 0; axis < 3; ++axis)
                    block.corner[corner][axis][lane] =
                        arrays.positions[arrays.triangles[triangle][is_used ? corner : 0]][axis];
        }
    });
    tree_.forget_leaves();
}
} // namespace tyndall
