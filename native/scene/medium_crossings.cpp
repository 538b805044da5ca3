// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/medium_crossings.hpp"
#include "scene/embree.hpp"
#include "scene/instance_places.hpp"
#include <algorithm>
#include <embree3/rtcore_ray.h>
#include <map>
#include <tuple>

namespace tyndall {
/// Six times the enclosed volume; the centre of the bounds as origin keeps a box far from its object's origin exact.
static double signed_volume6(const SharedMeshArrays& arrays, const vec3& centre) {
    double sum = 0.0;
    for (const uvec3& triangle : arrays.triangles) {
        const dvec3 a(arrays.positions[triangle.x] - centre);
        const dvec3 b(arrays.positions[triangle.y] - centre);
        const dvec3 c(arrays.positions[triangle.z] - centre);
        sum += glm::dot(a, glm::cross(b, c));
    }
    return sum;
}

/// Twelve triangles, two per face of the bounds, each with its corners on corners of the bounds.
static bool is_axis_aligned_box(const TriangleMesh& mesh) {
    if (mesh.triangle_count() != 12)
        return false;
    const auto& [min, max] = mesh.bounds();
    int triangles_on_face[6] = {};
    for (const uvec3& triangle : mesh.arrays().triangles) {
        int on_min[3] = {}, on_max[3] = {};
        for (int corner = 0; corner < 3; ++corner)
            for (int axis = 0; axis < 3; ++axis) {
                const float at = mesh.arrays().positions[triangle[corner]][axis];
                if (at != min[axis] && at != max[axis])
                    return false;
                on_min[axis] += at == min[axis];
                on_max[axis] += at == max[axis];
            }
        for (int axis = 0; axis < 3; ++axis) {
            triangles_on_face[2 * axis] += on_min[axis] == 3;
            triangles_on_face[2 * axis + 1] += on_max[axis] == 3;
        }
    }
    return std::ranges::all_of(triangles_on_face, [](int count) { return count == 2; });
}

std::int32_t medium_of_slot(const SceneDescription& description, const Instance& instance, std::uint16_t slot) {
    const std::uint32_t last = instance.slot_count > 0 ? instance.slot_count - 1u : 0u;
    const std::uint32_t entry = instance.first_slot_material + std::min<std::uint32_t>(slot, last);
    return description.materials[description.slot_materials[entry]].medium_index;
}

std::vector<MediumBoundary> find_medium_boundaries(const SceneDescription& description,
                                                   const std::function<bool(std::uint16_t)>& acts,
                                                   const Progress& progress) {
    struct MeshFacts {
        std::vector<std::uint16_t> slots; ///< Those that triangles use, ascending.
        bool is_box, is_closed, is_inside_out;
    };
    std::map<std::uint32_t, MeshFacts> facts_of_mesh; // shared meshes are examined once
    std::vector<MediumBoundary> boundaries;
    for (std::uint32_t index = 0; index < description.instances.size(); ++index) {
        const Instance& instance = description.instances[index];
        bool may_bound = false;
        for (std::uint16_t slot = 0; slot < std::max<std::uint16_t>(instance.slot_count, 1); ++slot)
            may_bound |= medium_of_slot(description, instance, slot) >= 0;
        if (!may_bound)
            continue;
        progress.poll();
        const TriangleMesh& mesh = *description.meshes[instance.mesh_index];
        const auto [entry, is_new] = facts_of_mesh.try_emplace(instance.mesh_index);
        MeshFacts& facts = entry->second;
        if (is_new) {
            facts.slots.assign(mesh.arrays().material_slots.begin(), mesh.arrays().material_slots.end());
            if (facts.slots.empty())
                facts.slots.push_back(0);
            std::ranges::sort(facts.slots);
            facts.slots.erase(std::unique(facts.slots.begin(), facts.slots.end()), facts.slots.end());
            facts.is_box = is_axis_aligned_box(mesh);
            facts.is_closed = facts.is_box || mesh.is_closed();
            const double diagonal_m = mesh.bounds().diagonal_m();
            facts.is_inside_out = signed_volume6(mesh.arrays(), mesh.bounds().centre()) <
                                  -1e-6 * diagonal_m * diagonal_m * diagonal_m; // an open sheet has about none
        }
        constexpr std::size_t handful = 64; // all of them cost less than a walk through a hierarchy
        const TriangleBvh* cut_bvh = mesh.triangle_count() > handful ? &mesh.cut_bvh(progress) : nullptr;
        std::vector<std::int32_t> media;
        for (const std::uint16_t slot : facts.slots)
            media.push_back(medium_of_slot(description, instance, slot));
        const bool has_one_medium = std::ranges::all_of(media, [&](std::int32_t medium) { return medium == media[0]; });
        std::ranges::sort(media);
        media.erase(std::unique(media.begin(), media.end()), media.end());
        for (const std::int32_t medium : media)
            if (medium >= 0 && acts(static_cast<std::uint16_t>(medium)))
                boundaries.push_back({.instance = index,
                                      .medium = static_cast<std::uint16_t>(medium),
                                      .is_box = facts.is_box && has_one_medium,
                                      .is_closed = facts.is_closed && has_one_medium,
                                      .is_inside_out = facts.is_inside_out,
                                      .object_from_world = glm::inverse(instance.world_from_object),
                                      .object_bounds = mesh.bounds(),
                                      .cut_bvh = cut_bvh});
    }
    return boundaries;
}

/// Extends Embree's context: the filter finds the query through the pointer that it gets.
struct MediumCrossings::Query {
    RTCIntersectContext context;
    const MediumCrossings* self;
    std::vector<Hit> hits;

    static void record(const RTCFilterFunctionNArguments* arguments) {
        auto& query = *reinterpret_cast<Query*>(arguments->context);
        RTCHit hit = rtcGetHitFromHitN(arguments->hit, arguments->N, 0);
        const RTCRay ray = rtcGetRayFromRayN(arguments->ray, arguments->N, 0);
        arguments->valid[0] = 0; // go on to the next crossing
        query.add(hit, ray);
    }

    void add(const RTCHit& hit, const RTCRay& ray) {
        const MediumCrossings::Instance& instance = self->instances_[hit.instID[0]];
        const SceneDescription& description = self->scene_.description();
        const tyndall::Instance& of_scene = description.instances[instance.scene_instance];
        const SharedMeshArrays& arrays = description.meshes[of_scene.mesh_index]->arrays();
        const std::uint16_t slot = arrays.slot_of(hit.primID);
        const std::int32_t boundary =
            instance.boundary_of_slot[std::min<std::size_t>(slot, instance.boundary_of_slot.size() - 1)];
        if (boundary < 0)
            return;
        // Here the ray is in object space, where the winding means the same for a mirrored instance.
        const float along_normal = hit.Ng_x * ray.dir_x + hit.Ng_y * ray.dir_y + hit.Ng_z * ray.dir_z;
        if (along_normal == 0.0f)
            return;
        const bool enters = (along_normal < 0.0f) != instance.is_inside_out;
        const float least = std::min({hit.u, hit.v, 1.0f - hit.u - hit.v});
        hits.push_back({{ray.tfar, static_cast<std::uint32_t>(boundary), enters ? 1 : -1}, hit.primID, least < 1e-5f});
    }
};

MediumCrossings::MediumCrossings(const Scene& scene, std::span<const MediumBoundary> boundaries,
                                 const Progress& progress)
    : scene_(scene), boundaries_(boundaries), top_(rtcNewScene(embree_device())) {
    rtcSetSceneFlags(top_, RTC_SCENE_FLAG_ROBUST);
    const SceneDescription& description = scene.description();
    std::map<std::uint32_t, RTCScene> scene_of_mesh;
    for (std::size_t index = 0; index < boundaries.size(); ++index) {
        const MediumBoundary& boundary = boundaries[index];
        if (boundary.is_box)
            continue;
        const tyndall::Instance& of_scene = description.instances[boundary.instance];
        if (instances_.empty() || instances_.back().scene_instance != boundary.instance) {
            progress.poll();
            const TriangleMesh& mesh = *description.meshes[of_scene.mesh_index];
            RTCScene& mesh_scene = scene_of_mesh[of_scene.mesh_index];
            if (mesh_scene == nullptr) {
                mesh_scene = rtcNewScene(embree_device());
                meshes_.push_back(mesh_scene);
                rtcSetSceneFlags(mesh_scene, RTC_SCENE_FLAG_ROBUST);
                RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
                void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                         sizeof(vec3), mesh.arrays().positions.size());
                std::ranges::copy(mesh.arrays().positions, static_cast<vec3*>(vertices));
                void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                          sizeof(uvec3), mesh.arrays().triangles.size());
                std::ranges::copy(mesh.arrays().triangles, static_cast<uvec3*>(triangles));
                rtcSetGeometryIntersectFilterFunction(geometry, Query::record);
                rtcCommitGeometry(geometry);
                rtcAttachGeometryByID(mesh_scene, geometry, 0);
                rtcReleaseGeometry(geometry);
                rtcCommitScene(mesh_scene);
            }
            RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_INSTANCE);
            rtcSetGeometryInstancedScene(geometry, mesh_scene);
            rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &of_scene.world_from_object);
            rtcCommitGeometry(geometry);
            rtcAttachGeometryByID(top_, geometry, static_cast<unsigned>(instances_.size()));
            rtcReleaseGeometry(geometry);
            instances_.push_back(
                {boundary.instance, boundary.is_inside_out,
                 std::vector<std::int32_t>(std::max<std::size_t>(of_scene.slot_count, 1), std::int32_t{-1})});
        }
        std::vector<std::int32_t>& slots = instances_.back().boundary_of_slot;
        for (std::uint16_t slot = 0; slot < slots.size(); ++slot)
            if (medium_of_slot(description, of_scene, slot) == boundary.medium)
                slots[slot] = static_cast<std::int32_t>(index);
    }
    rtcCommitScene(top_);
}

MediumCrossings::~MediumCrossings() {
    rtcReleaseScene(top_);
    for (RTCScene mesh : meshes_)
        rtcReleaseScene(mesh);
}

void MediumCrossings::collect(const vec3& origin, const vec3& direction, std::vector<Hit>& hits) const {
    hits.clear();
    if (!is_within(origin, scene_.reach_m()))
        return;
    thread_local Query query;
    rtcInitIntersectContext(&query.context);
    query.self = this;
    query.hits.clear();
    RTCRayHit ray{};
    ray.ray.org_x = origin.x, ray.ray.org_y = origin.y, ray.ray.org_z = origin.z;
    ray.ray.dir_x = direction.x, ray.ray.dir_y = direction.y, ray.ray.dir_z = direction.z;
    ray.ray.tfar = std::numeric_limits<float>::infinity();
    ray.ray.mask = ~0u;
    ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(top_, &query.context, &ray);

    // By distance, then by what was hit: Embree's order of visits may differ between instruction sets.
    std::ranges::sort(query.hits, [](const Hit& a, const Hit& b) {
        return std::tie(a.crossing.distance_m, a.crossing.boundary, a.triangle) <
               std::tie(b.crossing.distance_m, b.crossing.boundary, b.triangle);
    });
    for (const Hit& hit : query.hits) {
        bool is_repeated = false; // by a neighbour across a shared edge, or by the same triangle
        for (auto before = hits.rbegin(); before != hits.rend() && !is_repeated; ++before) {
            if (hit.crossing.distance_m - before->crossing.distance_m > 1e-5f * (1.0f + hit.crossing.distance_m))
                break;
            is_repeated = before->crossing.boundary == hit.crossing.boundary &&
                          before->crossing.winding_step == hit.crossing.winding_step &&
                          (before->triangle == hit.triangle || (before->is_on_edge && hit.is_on_edge));
        }
        if (!is_repeated)
            hits.push_back(hit);
    }
}

static std::int32_t winding_from(std::span<const MediumCrossings::Hit> hits, std::uint32_t boundary) {
    std::int32_t sum = 0;
    for (const MediumCrossings::Hit& hit : hits)
        if (hit.crossing.boundary == boundary)
            sum -= hit.crossing.winding_step;
    return sum;
}

void MediumCrossings::repair(const vec3& origin, std::vector<Hit>& hits) const {
    thread_local std::vector<Hit> elsewhere;
    bool has_looked_elsewhere = false;
    for (std::size_t index = hits.size(); index-- > 0;) {
        const Hit hit = hits[index];
        if (!hit.is_on_edge || !boundaries_[hit.crossing.boundary].is_closed)
            continue;
        const std::int32_t found = winding_from(hits, hit.crossing.boundary);
        std::int32_t truth = 0; // all that a ray from outside may find; below 0, something was entered and never left
        if (found > 0) {
            if (!has_looked_elsewhere) // in a direction that lies in no plane that modellers favour
                collect(origin, glm::normalize(vec3(0.36f, -0.48f, 0.8013f)), elsewhere);
            has_looked_elsewhere = true;
            truth = std::max(0, winding_from(elsewhere, hit.crossing.boundary));
        }
        if ((found < truth && hit.crossing.winding_step > 0) || (found > truth && hit.crossing.winding_step < 0))
            hits.erase(hits.begin() + static_cast<std::ptrdiff_t>(index));
    }
}

void MediumCrossings::append(const vec3& origin, const vec3& direction, std::vector<MediumCrossing>& crossings) const {
    thread_local std::vector<Hit> hits;
    collect(origin, direction, hits);
    repair(origin, hits);
    for (const Hit& hit : hits)
        crossings.push_back(hit.crossing);
}
} // namespace tyndall
