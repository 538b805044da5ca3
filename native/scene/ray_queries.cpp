// SPDX-License-Identifier: GPL-3.0-or-later
// What rays meet: one ray at a time, or 16 that start and go alike.
// Based on: Embree 3's packets with its coherent flag (culling by a frustum).
// Differs:  what has moved is asked for in a tree of its own, and passed where it stood (instance_trees.hpp).
// Bound:    16 rays cost what 4 to 6 single ones cost; a CPU without AVX-512 takes them as narrower packets.
#include "scene/instance_masks.hpp"
#include "scene/query_context.hpp"
#include "scene/strands.hpp"

namespace tyndall {
/// Lets view rays through what has moved, and through triangles whose slot has no surface, on an instance that has
/// surfaces elsewhere.
static void skip_absent(const RTCFilterFunctionNArguments* arguments) {
    const QueryContext& context = context_of(arguments);
    for (unsigned int lane = 0; lane < arguments->N; ++lane) {
        if (arguments->valid[lane] != -1)
            continue;
        const RTCHit hit = rtcGetHitFromHitN(arguments->hit, arguments->N, lane);
        if (context.passes(hit.instID[0]) ||
            (context.asks_materials && !context.scene.material(hit.instID[0], hit.primID).has_surface))
            arguments->valid[lane] = 0;
    }
}

/// Embree's normals are in the mesh's space and not of unit length. Of a ribbon they say only how it faces the ray.
Hit Scene::in_scene(const Ray& ray, Hit hit) const {
    if (const PlacedShape* placed = placed_shape(hit.instance))
        if (const Strands* strands = shape_of(*placed).strands())
            hit.geometric_normal =
                strands
                    ->point(static_cast<std::uint32_t>(hit.cell), hit.barycentrics,
                            mat3(geometry_->objects_from_scene[hit.instance]) * ray.direction, hit.geometric_normal)
                    .normal;
    hit.geometric_normal = glm::normalize(normal_in_scene(hit.instance, hit.geometric_normal));
    return hit;
}

Hit Scene::closest_hit(const Ray& ray, unsigned int mask, const RayDetail& detail) const {
    if (!is_within(ray.origin, reach_m()))
        return {};
    QueryContext context(*this, &ray, nullptr);
    if (!detail.is_every_cell()) {
        context.details = std::span(&detail, 1);
        context.shape_lengths = geometry_->shape_lengths;
        context.first_shape = static_cast<unsigned int>(description().instances.size());
    }
    context.asks_materials = geometry_->has_holes;
    RTCRayHit query;
    query.ray = embree_ray(ray, mask);
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    context.trace_all(skip_absent, [&](RTCScene tree) { rtcIntersect1(tree, &context.embree, &query); });
    return query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? Hit{} : in_scene(ray, hit_of(query.ray, query.hit));
}

void Scene::closest_hits(std::span<const Ray> rays, std::span<Hit> hits, unsigned int mask,
                         std::span<const RayDetail> details) const {
    for (std::size_t first = 0; first < rays.size(); first += packet_size) {
        const std::span<const Ray> these = rays.subspan(first, std::min(packet_size, rays.size() - first));
        if (these.size() < smallest_packet) {
            for (std::size_t lane = 0; lane < these.size(); ++lane)
                hits[first + lane] =
                    closest_hit(these[lane], mask, details.empty() ? RayDetail{} : details[first + lane]);
            continue;
        }
        QueryContext context(*this, these.data(), nullptr);
        if (!details.empty()) {
            context.details = details.subspan(first, these.size());
            context.shape_lengths = geometry_->shape_lengths;
            context.first_shape = static_cast<unsigned int>(description().instances.size());
        }
        context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        context.asks_materials = geometry_->has_holes;
        RTCRayHit16 query;
        alignas(64) const std::array<int, packet_size> valid = fill_packet(query.ray, these, mask, reach_m());
        std::fill_n(query.hit.geomID, packet_size, RTC_INVALID_GEOMETRY_ID);
        std::fill_n(query.hit.instID[0], packet_size, RTC_INVALID_GEOMETRY_ID);
        context.trace_all(skip_absent,
                          [&](RTCScene tree) { rtcIntersect16(valid.data(), tree, &context.embree, &query); });
        for (std::size_t lane = 0; lane < these.size(); ++lane)
            hits[first + lane] =
                query.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID
                    ? Hit{}
                    : in_scene(these[lane], {.distance_m = query.ray.tfar[lane],
                                             .instance = query.hit.instID[0][lane],
                                             .triangle = query.hit.primID[lane],
                                             .cell = cell_of(query.hit.primID[lane], query.hit.geomID[lane]),
                                             .barycentrics = vec2(query.hit.u[lane], query.hit.v[lane]),
                                             .geometric_normal = vec3(query.hit.Ng_x[lane], query.hit.Ng_y[lane],
                                                                      query.hit.Ng_z[lane])});
    }
}

namespace {
/// Embree's context, and behind it where hits go.
struct CollectingContext {
    RTCIntersectContext embree;
    std::vector<Hit>* hits;
    std::uint32_t instance;
};
} // namespace

/// Lets a ray through everything, and takes down what that is.
static void collect(const RTCFilterFunctionNArguments* arguments) {
    const auto& context = *reinterpret_cast<const CollectingContext*>(arguments->context);
    for (unsigned int lane = 0; lane < arguments->N; ++lane) {
        if (arguments->valid[lane] != -1)
            continue;
        Hit hit = hit_of(rtcGetRayFromRayN(arguments->ray, arguments->N, lane),
                         rtcGetHitFromHitN(arguments->hit, arguments->N, lane));
        hit.instance = context.instance;
        context.hits->push_back(hit);
        arguments->valid[lane] = 0;
    }
}

Hit Scene::closest_hit_of(std::uint32_t instance, const Ray& ray) const {
    if (placed_shape(instance) != nullptr || !is_within(ray.origin, reach_m()))
        return {};
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query;
    query.ray = embree_ray(in_object(geometry_->objects_from_scene[instance], ray), ~0u);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(description().meshes[description().instances[instance].mesh_index]->embree_scene(), &context, &query);
    query.hit.instID[0] = instance;
    return query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? Hit{} : in_scene(ray, hit_of(query.ray, query.hit));
}

void Scene::append_hits(const Ray& ray, std::uint32_t instance, std::vector<Hit>& hits) const {
    if (placed_shape(instance) != nullptr || !is_within(ray.origin, reach_m()))
        return;
    const std::size_t first = hits.size();
    CollectingContext context{.embree = {}, .hits = &hits, .instance = instance};
    rtcInitIntersectContext(&context.embree);
    context.embree.filter = collect;
    RTCRay query = embree_ray(in_object(geometry_->objects_from_scene[instance], ray), ~0u);
    rtcOccluded1(description().meshes[description().instances[instance].mesh_index]->embree_scene(), &context.embree,
                 &query);
    for (Hit& hit : std::span(hits).subspan(first))
        hit = in_scene(ray, hit);
}
} // namespace tyndall
