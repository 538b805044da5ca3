// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/medium_cuts.hpp"
#include <algorithm>

namespace tyndall {
void append_medium_cuts(const SceneDescription& scene, const MediumBoundary& boundary,
                        const PlaneCoordinates<double>& plane, std::vector<MediumCut>& cuts) {
    const Instance& instance = scene.instances[boundary.instance];
    const MeshArrays& arrays = scene.meshes[instance.mesh_index]->arrays();
    for (std::size_t triangle = 0; triangle < arrays.triangles.size(); ++triangle) {
        const std::uint16_t slot = arrays.material_slots.empty() ? std::uint16_t{0} : arrays.material_slots[triangle];
        if (medium_of_slot(scene, instance, slot) != boundary.medium)
            continue;
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
    }
}
} // namespace tyndall
