// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/medium_cuts.hpp"
#include "scene/triangle_bvh.hpp"
#include <algorithm>

namespace tyndall {
namespace {
/// Calls visit(triangle) for each triangle of the boxes that the plane cuts and that reach up to the ray or beyond.
template <typename Visit>
void for_each_near_plane(const TriangleBvh& bvh, const PlaneCoordinates<double>& plane, const Visit& visit) {
    constexpr double eps = 1e-6; // boxes are floats
    thread_local std::vector<std::uint32_t> stack;
    stack.assign(1, 0);
    const dvec3 reach(bvh.reach());
    const auto margin = [&](const Covector<double>& covector) {
        return eps * (glm::dot(glm::abs(covector.direction), reach) + std::abs(covector.offset));
    };
    const double height_margin = margin(plane.height), y_margin = margin(plane.y);
    while (!stack.empty()) {
        const WideBvh::Node& node = bvh.nodes()[stack.back()];
        stack.pop_back();
        for (std::size_t child = 0; child < WideBvh::width; ++child) {
            const dvec3 centre(node.centre[0][child], node.centre[1][child], node.centre[2][child]);
            const dvec3 extent(node.half_extent[0][child], node.half_extent[1][child], node.half_extent[2][child]);
            if (!(std::abs(plane.height(centre)) <=
                      glm::dot(glm::abs(plane.height.direction), extent) + height_margin &&
                  plane.y(centre) + glm::dot(glm::abs(plane.y.direction), extent) + y_margin >= 0.0))
                continue;
            if ((node.child[child] & WideBvh::leaf_bit) == 0) {
                stack.push_back(node.child[child]);
                continue;
            }
            const TriangleBvh::Block& block = bvh.blocks()[node.child[child] & ~WideBvh::leaf_bit];
            for (std::size_t lane = 0; lane < block.count; ++lane)
                visit(block.triangle[lane]);
        }
    }
}
} // namespace

void append_medium_cuts(const SceneDescription& scene, const MediumBoundary& boundary,
                        const PlaneCoordinates<double>& plane, std::vector<MediumCut>& cuts) {
    const Instance& instance = scene.instances[boundary.instance];
    const MeshArrays& arrays = scene.meshes[instance.mesh_index]->arrays();
    const auto cut_one = [&](std::size_t triangle) {
        const std::uint16_t slot = arrays.material_slots.empty() ? std::uint16_t{0} : arrays.material_slots[triangle];
        if (medium_of_slot(scene, instance, slot) != boundary.medium)
            return;
        const uvec3& corners = arrays.triangles[triangle];
        const dvec3 points[3] = {dvec3(arrays.positions[corners.x]), dvec3(arrays.positions[corners.y]),
                                 dvec3(arrays.positions[corners.z])};
        if (MediumCut cut; cut_triangle(plane, points, cut.segment)) {
            cut.point = points[0];
            cut.outward_normal = glm::cross(points[1] - points[0], points[2] - points[0]);
            if (boundary.is_inside_out)
                cut.outward_normal = -cut.outward_normal;
            cuts.push_back(cut);
        }
    };
    if (boundary.cut_bvh != nullptr) {
        for_each_near_plane(*boundary.cut_bvh, plane, cut_one);
        return;
    }
    for (std::size_t triangle = 0; triangle < arrays.triangles.size(); ++triangle)
        cut_one(triangle);
}
} // namespace tyndall
