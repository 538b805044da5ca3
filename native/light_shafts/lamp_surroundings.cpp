// SPDX-License-Identifier: GPL-3.0-or-later
// Does anything reach into a lamp? Asked of Embree's hierarchy, once per lamp.
#include "core/errors.hpp"
#include "light_shafts/turning_disc.hpp"
#include "scene/strands.hpp"
#include "shading/surface_program.hpp"
#include <embree3/rtcore.h>

namespace tyndall::light_shafts {
/// Based on: Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
static vec3 nearest_of_triangle(const vec3& p, const vec3& a, const vec3& b, const vec3& c) {
    const vec3 ab = b - a, ac = c - a, ap = p - a;
    const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0.0f && d2 <= 0.0f)
        return a;
    const vec3 bp = p - b;
    const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0.0f && d4 <= d3)
        return b;
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f)
        return a + d1 / (d1 - d3) * ab;
    const vec3 cp = p - c;
    const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0.0f && d5 <= d6)
        return c;
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f)
        return a + d2 / (d2 - d6) * ac;
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0.0f && d4 - d3 >= 0.0f && d5 - d6 >= 0.0f)
        return b + (d4 - d3) / (d4 - d3 + (d5 - d6)) * (c - b);
    return a + (vb * ab + vc * ac) / (va + vb + vc);
}

namespace {
struct Search {
    const Scene& scene;
    vec3 centre;
    float radius_m;
    bool is_found = false;
    bool is_of_moved = false; ///< Of the tree over those alone.
};
} // namespace

namespace {
/// Looks for a cell that reaches into the sphere.
class CellSearch final : public CellVisitor {
public:
    CellSearch(Search& search, const mat4& scene_from_object)
        : search_(search), scene_from_object_(scene_from_object) {}
    bool enters(const Bounds3& box) override {
        const Bounds3 around = transformed(box, scene_from_object_);
        const vec3 way = glm::clamp(search_.centre, around.min, around.max) - search_.centre;
        return !search_.is_found && glm::dot(way, way) < search_.radius_m * search_.radius_m;
    }
    void meet(const Bounds3& cell) override {
        if (!enters(cell))
            return;
        // Its faces' triangles: both halves of each, by the corners that share a bit, counted around.
        static constexpr std::size_t faces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                                    {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
        for (const auto& face : faces)
            for (const std::size_t second : {std::size_t{1}, std::size_t{2}}) {
                const auto corner = [&](std::size_t i) {
                    return vec3(scene_from_object_ * vec4(cell.corner(face[i]), 1.0f)) - search_.centre;
                };
                const vec3 nearest = nearest_of_triangle(vec3(0.0f), corner(0), corner(second), corner(second + 1));
                search_.is_found |= glm::dot(nearest, nearest) < search_.radius_m * search_.radius_m;
            }
    }

private:
    Search& search_;
    const mat4& scene_from_object_;
};
} // namespace

static bool look_at_primitive(RTCPointQueryFunctionArguments* found) {
    Search& search = *static_cast<Search*>(found->userPtr);
    const SceneDescription& description = search.scene.description();
    const std::uint32_t instance_index = found->context->instID[found->context->instStackSize - 1];
    if (!search.is_of_moved && search.scene.trees().has_moved(instance_index))
        return false;
    if (const PlacedShape* placed = search.scene.placed_shape(instance_index)) {
        const ShapeGeometry& shape = *description.shapes[placed->shape_index];
        CellSearch cells(search, placed->world_from_object);
        if (search.is_found || !placed->casts_shadow)
            return false;
        if (shape.strands() != nullptr) // by their boxes: more may seem to be there than is
            search.is_found = cells.enters(shape.strands()->segment_bounds(found->primID));
        else
            shape.cells()->visit(cells);
        return false;
    }
    const Instance& instance = description.instances[instance_index];
    if (search.is_found || !instance.casts_shadow)
        return false;
    if (is_transparent_everywhere(search.scene.material(instance_index, found->primID)))
        return false;
    const SharedMeshArrays& mesh = description.meshes[instance.mesh_index]->arrays();
    vec3 corners[3];
    for (int corner = 0; corner < 3; ++corner)
        corners[corner] =
            vec3(instance.world_from_object * vec4(mesh.positions[mesh.triangles[found->primID][corner]], 1.0f)) -
            search.centre;
    const vec3 nearest = nearest_of_triangle(vec3(0.0f), corners[0], corners[1], corners[2]);
    search.is_found = glm::dot(nearest, nearest) < search.radius_m * search.radius_m;
    if (search.is_found)
        found->query->radius = 0.0f; // nothing else matters
    return search.is_found;
}

bool has_occluder_within(const Scene& scene, const vec3& centre, float radius_m) {
    Search search{scene, centre, radius_m};
    const auto look_at = [&](RTCScene tree) {
        RTCPointQuery query{.x = centre.x, .y = centre.y, .z = centre.z, .time = 0.0f, .radius = radius_m};
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(tree, &query, &context, look_at_primitive, &search);
    };
    look_at(scene.trees().all());
    search.is_of_moved = true;
    if (!search.is_found && scene.trees().of_moved() != nullptr)
        look_at(scene.trees().of_moved());
    return search.is_found;
}
} // namespace tyndall::light_shafts
