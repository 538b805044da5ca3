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
            for (const TriangleBvh::Block& block : bvh.blocks_of(node.child[child] & ~WideBvh::leaf_bit))
                for (std::size_t lane = 0; lane < block.count; ++lane)
                    visit(block.triangle[lane]);
        }
    }
}
} // namespace

void append_medium_cuts(const SceneDescription& scene, const MediumBoundary& boundary,
                        const PlaneCoordinates<double>& plane, std::vector<MediumCut>& cuts) {
    const Instance& instance = scene.instances[boundary.instance];
    const SharedMeshArrays& arrays = scene.meshes[instance.mesh_index]->arrays();
    const auto cut_one = [&](std::size_t triangle) {
        const std::uint16_t slot = arrays.slot_of(triangle);
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

void append_box_cuts(const Bounds3& box, const PlaneCoordinates<double>& plane, std::vector<MediumCut>& cuts) {
    double height[8], x[8], y[8];
    int above = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const dvec3 point(box.corner(static_cast<std::size_t>(corner)));
        height[corner] = plane.height(point), x[corner] = plane.x(point), y[corner] = plane.y(point);
        above |= (height[corner] >= 0.0) << corner;
    }
    if (above == 0 || above == 0xff)
        return;
    for (int axis = 0; axis < 3; ++axis)
        for (const int high : {0, 1}) {
            const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = high << axis;
            const int corners[4] = {base, base + u, base + u + v, base + v};
            double at[2][2];
            int count = 0;
            for (int edge = 0; edge < 4; ++edge) {
                // In one order of its ends for both faces: they meet there without a gap.
                const int from = std::min(corners[edge], corners[(edge + 1) % 4]),
                          to = std::max(corners[edge], corners[(edge + 1) % 4]);
                if ((above >> from & 1) == (above >> to & 1))
                    continue;
                const double share = height[from] / (height[from] - height[to]);
                if (count < 2) {
                    at[count][0] = x[from] + share * (x[to] - x[from]);
                    at[count][1] = y[from] + share * (y[to] - y[from]);
                }
                ++count;
            }
            if (count != 2)
                continue;
            MediumCut& cut = cuts.emplace_back();
            cut.segment = {at[0][0], at[0][1], at[1][0], at[1][1]};
            cut.point = dvec3(high != 0 ? box.max : box.min);
            cut.outward_normal = dvec3(0.0);
            cut.outward_normal[axis] = high != 0 ? 1.0 : -1.0;
        }
}
} // namespace tyndall
