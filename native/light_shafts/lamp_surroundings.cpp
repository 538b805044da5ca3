// SPDX-License-Identifier: GPL-3.0-or-later
// Does anything reach into a lamp? Asked of Embree's hierarchy, once per lamp.
#include "core/errors.hpp"
#include "light_shafts/turning_disc.hpp"
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
};
} // namespace

static bool look_at_triangle(RTCPointQueryFunctionArguments* found) {
    Search& search = *static_cast<Search*>(found->userPtr);
    const SceneDescription& description = search.scene.description();
    const std::uint32_t instance_index = found->context->instID[found->context->instStackSize - 1];
    const Instance& instance = description.instances[instance_index];
    if (search.is_found || !instance.casts_shadow)
        return false;
    if (is_transparent_everywhere(search.scene.material(instance_index, found->primID)))
        return false;
    const MeshArrays& mesh = description.meshes[instance.mesh_index]->arrays();
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
    RTCPointQuery query{.x = centre.x, .y = centre.y, .z = centre.z, .time = 0.0f, .radius = radius_m};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene.embree_scene(), &query, &context, look_at_triangle, &search);
    return search.is_found;
}
} // namespace tyndall::light_shafts
