// SPDX-License-Identifier: GPL-3.0-or-later
// What rays ask a scene: one ray at a time, or 16 that start and go alike.
// Based on: Embree 3's packets: camera rays with its coherent flag (culling by a frustum), shadow rays without.
// Differs:  its coherent flag never goes with rtcOccluded16: in Embree 3.13.5 that does not return for some packets that
//           meet instances.
//           What has moved is asked for in a tree of its own, and passed where it stood (instance_trees.hpp).
// Bound:    16 rays cost what 4 to 6 single ones cost; a CPU without AVX-512 takes them as narrower packets.
#include "scene/embree.hpp"
#include "scene/instance_masks.hpp"
#include "scene/instance_places.hpp"
#include "scene/scene.hpp"
#include "scene/strands.hpp"
#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

namespace tyndall {
static constexpr std::size_t packet_size = 16;
/// Fewer rays than this are traced one by one.
static constexpr std::size_t smallest_packet = 4;

/// Fills the lanes of a packet; returns which hold a ray that starts within reach: those are -1, as Embree wants it. A CPU
/// without AVX-512 goes by their ranges instead: those of rays from beyond are empty.
static std::array<int, packet_size> fill(RTCRay16& packet, std::span<const Ray> rays, unsigned int mask,
                                         float reach_m) {
    std::array<int, packet_size> valid{};
    for (std::size_t lane = 0; lane < packet_size; ++lane) {
        const Ray& ray = rays[std::min(lane, rays.size() - 1)];
        const bool starts_within = is_within(ray.origin, reach_m);
        valid[lane] = lane < rays.size() && starts_within ? -1 : 0;
        packet.org_x[lane] = ray.origin.x;
        packet.org_y[lane] = ray.origin.y;
        packet.org_z[lane] = ray.origin.z;
        packet.tnear[lane] = starts_within ? ray.near_m : 1.0f;
        packet.dir_x[lane] = ray.direction.x;
        packet.dir_y[lane] = ray.direction.y;
        packet.dir_z[lane] = ray.direction.z;
        packet.tfar[lane] = starts_within ? ray.far_m : 0.0f;
        packet.time[lane] = 0.0f;
        packet.mask[lane] = mask;
        packet.id[lane] = static_cast<unsigned int>(lane);
        packet.flags[lane] = 0;
    }
    return valid;
}

/// What may let light pass, on a shadow ray's way.
struct PassedHit {
    unsigned int ray; ///< RTCRay::id
    Hit hit;
};

/// Embree's context, and behind it what cells and filters need.
struct QueryContext : CellQuery {
    QueryContext(const Scene& asked, const Ray* first_ray, dvec3* first_passing)
        : scene(asked), rays(first_ray), passing(first_passing) {}
    const Scene& scene;
    const Ray* rays; ///< By RTCRay::id.
    /// By RTCRay::id: light that passes, of shadow rays. In double, so that as a float it does not tell in which order
    /// Embree's tree had the surfaces: another tree over the same ones gives the same bits.
    dvec3* passing;
    const std::uint64_t* bits_of_instance = nullptr;
    std::uint64_t ignored = 0;
    RayKind kind = RayKind::Shadow; ///< Of those that gather light.
    bool asks_materials = false;    ///< Of what is met: it may have holes, or let light pass.
    /// Where what lets light pass counts what did so before: what rays meet, in no order, until let_pass_in_order().
    std::vector<PassedHit>* waiting = nullptr;
    const InstanceTrees* passed = nullptr; ///< What has moved of these is passed.

    [[nodiscard]] bool passes(unsigned int instance) const { return passed != nullptr && passed->has_moved(instance); }

    /// Calls trace with one tree after the other.
    template <typename Trace>
    void trace_all(RTCFilterFunctionN filter, const Trace& trace) {
        const InstanceTrees& trees = scene.trees();
        passed = trees.of_moved() != nullptr ? &trees : nullptr;
        if (asks_materials || ignored != 0 || passed != nullptr)
            embree.filter = filter;
        trace(trees.all());
        if (passed == nullptr)
            return;
        passed = nullptr;
        if (!asks_materials && ignored == 0)
            embree.filter = nullptr;
        trace(trees.of_moved());
    }
};

static const QueryContext& context_of(const RTCFilterFunctionNArguments* arguments) {
    return static_cast<const QueryContext&>(*reinterpret_cast<const CellQuery*>(arguments->context));
}

static Hit hit_of(const RTCRay& ray, const RTCHit& hit) {
    return {.distance_m = ray.tfar,
            .instance = hit.instID[0],
            .triangle = hit.primID,
            .cell = cell_of(hit.primID, hit.geomID),
            .barycentrics = vec2(hit.u, hit.v),
            .geometric_normal = vec3(hit.Ng_x, hit.Ng_y, hit.Ng_z)};
}

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

/// Multiplies the transmittance of a transparent hit into what passes and goes on; an opaque one ends the ray.
static void attenuate(const RTCFilterFunctionNArguments* arguments) {
    const QueryContext& context = context_of(arguments);
    for (unsigned int lane = 0; lane < arguments->N; ++lane) {
        if (arguments->valid[lane] != -1)
            continue;
        const RTCRay ray = rtcGetRayFromRayN(arguments->ray, arguments->N, lane);
        const RTCHit hit = rtcGetHitFromHitN(arguments->hit, arguments->N, lane);
        const bool is_ignored =
            context.ignored != 0 && (context.bits_of_instance[hit.instID[0]] & context.ignored) != 0;
        if (is_ignored || context.passes(hit.instID[0])) {
            arguments->valid[lane] = 0;
            continue;
        }
        if (!context.asks_materials)
            continue;
        if (context.waiting != nullptr) {
            const Hit met = hit_of(ray, hit);
            if (context.scene.is_opaque(met))
                continue;
            context.waiting->push_back({ray.id, met});
            arguments->valid[lane] = 0;
            continue;
        }
        dvec3& passing = context.passing[ray.id];
        passing *= dvec3(context.scene.transparency(context.rays[ray.id], hit_of(ray, hit), context.kind));
        if (Rgb(passing) != Rgb(0.0f))
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
        alignas(64) const std::array<int, packet_size> valid = fill(query.ray, these, mask, reach_m());
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

/// Shadow rays of a scene whose surfaces count what was passed keep what they meet.
static std::vector<PassedHit>* waiting_for(bool counts_passed) {
    thread_local std::vector<PassedHit> waiting;
    waiting.clear();
    return counts_passed ? &waiting : nullptr;
}

/// Multiplies the transmittances of what waits, each ray's nearest first.
static void let_pass_in_order(const QueryContext& context) {
    if (context.waiting == nullptr)
        return;
    std::ranges::sort(*context.waiting, {}, [](const PassedHit& met) {
        return std::tuple(met.ray, met.hit.distance_m, met.hit.instance, met.hit.triangle);
    });
    std::uint32_t before = 0;
    for (std::size_t index = 0; index < context.waiting->size(); ++index) {
        const auto& [id, hit] = (*context.waiting)[index];
        before = index > 0 && (*context.waiting)[index - 1].ray == id ? before + 1 : 0;
        Ray asking = context.rays[id];
        asking.passed_count += before;
        context.passing[id] *= dvec3(context.scene.transparency(asking, hit, context.kind));
    }
}

/// Of one ray.
static Rgb passing_along(QueryContext& context, const Ray& ray, Among among, const dvec3& passing) {
    if (!is_within(ray.origin, context.scene.reach_m()))
        return Rgb(1.0f);
    RTCRay query = embree_ray(ray, mask_among(among, blocking_mask(context.kind)));
    context.trace_all(attenuate, [&](RTCScene tree) {
        if (query.tfar >= 0.0f) // less: something stops it
            rtcOccluded1(tree, &context.embree, &query);
    });
    let_pass_in_order(context);
    const bool is_occluded = query.tfar < 0.0f;
    return is_occluded ? Rgb(0.0f) : Rgb(passing);
}

Rgb Scene::shadow_transmittance(const Ray& ray, Among among, RayKind kind) const {
    dvec3 passing(1.0);
    QueryContext context(*this, &ray, &passing);
    context.kind = kind;
    context.asks_materials = geometry_->lets_light_pass;
    context.waiting = waiting_for(geometry_->counts_passed);
    return passing_along(context, ray, among, passing);
}

Rgb Scene::shadow_transmittance(const Ray& ray, std::span<const std::uint64_t> bits_of_instance, std::uint64_t ignored,
                                Among among) const {
    dvec3 passing(1.0);
    QueryContext context(*this, &ray, &passing);
    context.bits_of_instance = bits_of_instance.data();
    context.ignored = ignored;
    context.asks_materials = geometry_->lets_light_pass;
    context.waiting = waiting_for(geometry_->counts_passed);
    return passing_along(context, ray, among, passing);
}

void Scene::shadow_transmittances(std::span<const Ray> rays, std::span<Rgb> passing,
                                  std::span<const std::uint64_t> bits_of_instance, std::uint64_t ignored,
                                  Among among) const {
    for (std::size_t first = 0; first < rays.size(); first += packet_size) {
        const std::span<const Ray> these = rays.subspan(first, std::min(packet_size, rays.size() - first));
        if (these.size() < smallest_packet) {
            for (std::size_t lane = 0; lane < these.size(); ++lane)
                passing[first + lane] = shadow_transmittance(these[lane], bits_of_instance, ignored, among);
            continue;
        }
        std::array<dvec3, packet_size> passing_of;
        passing_of.fill(dvec3(1.0));
        QueryContext context(*this, these.data(), passing_of.data());
        context.bits_of_instance = bits_of_instance.data();
        context.ignored = ignored;
        context.asks_materials = geometry_->lets_light_pass;
        context.waiting = waiting_for(geometry_->counts_passed);
        RTCRay16 query;
        alignas(64) std::array<int, packet_size> valid = fill(query, these, mask_among(among, shadow_mask), reach_m());
        context.trace_all(attenuate, [&](RTCScene tree) {
            for (std::size_t lane = 0; lane < packet_size; ++lane)
                if (query.tfar[lane] < 0.0f) // something stops it
                    valid[lane] = 0;
            rtcOccluded16(valid.data(), tree, &context.embree, &query);
        });
        let_pass_in_order(context);
        for (std::size_t lane = 0; lane < these.size(); ++lane)
            passing[first + lane] = query.tfar[lane] < 0.0f ? Rgb(0.0f) : Rgb(passing_of[lane]);
    }
}

/// Asks for up to a packet of rays that start within reach; `trace` gets lanes and packet, or one ray.
template <typename TracePacket, typename TraceOne>
static std::size_t open_among(std::span<const Ray> rays, unsigned int mask, float reach_m,
                              const TracePacket& trace_packet, const TraceOne& trace_one) {
    std::size_t open = 0;
    for (std::size_t first = 0; first < rays.size(); first += packet_size) {
        const std::span<const Ray> these = rays.subspan(first, std::min(packet_size, rays.size() - first));
        if (these.size() < smallest_packet) {
            for (const Ray& ray : these) {
                RTCRay query = embree_ray(ray, mask);
                if (is_within(ray.origin, reach_m))
                    trace_one(query);
                open += query.tfar < 0.0f ? 0 : 1;
            }
            continue;
        }
        RTCRay16 query;
        alignas(64) std::array<int, packet_size> valid = fill(query, these, mask, reach_m);
        trace_packet(valid, query);
        for (std::size_t lane = 0; lane < these.size(); ++lane)
            open += query.tfar[lane] < 0.0f ? 0 : 1;
    }
    return open;
}

std::size_t Scene::open_count(std::span<const Ray> rays) const {
    QueryContext context(*this, rays.data(), nullptr);
    return open_among(
        rays, shadow_mask, reach_m(),
        [&](std::array<int, packet_size>& valid, RTCRay16& query) {
            context.trace_all(attenuate, [&](RTCScene tree) {
                for (std::size_t lane = 0; lane < packet_size; ++lane)
                    if (query.tfar[lane] < 0.0f) // something stops it
                        valid[lane] = 0;
                rtcOccluded16(valid.data(), tree, &context.embree, &query);
            });
        },
        [&](RTCRay& query) {
            context.trace_all(attenuate, [&](RTCScene tree) {
                if (query.tfar >= 0.0f)
                    rtcOccluded1(tree, &context.embree, &query);
            });
        });
}

/// Distances stay what they are: directions are as long there as the space is stretched.
static Ray in_object(const mat4& object_from_scene, const Ray& ray) {
    return {.origin = vec3(object_from_scene * vec4(ray.origin, 1.0f)),
            .direction = mat3(object_from_scene) * ray.direction,
            .near_m = ray.near_m,
            .far_m = ray.far_m};
}

std::size_t Scene::open_count(std::span<const Ray> rays, std::uint32_t instance) const {
    const PlacedShape* const placed = placed_shape(instance);
    const RTCScene tree = placed != nullptr
                              ? shape_of(*placed).embree_scene()
                              : description().meshes[description().instances[instance].mesh_index]->embree_scene();
    thread_local std::vector<Ray> inside;
    inside.clear();
    for (const Ray& ray : rays)
        inside.push_back(in_object(geometry_->objects_from_scene[instance], ray));
    CellQuery context;
    return open_among(
        inside, ~0u, largest_coordinate_m,
        [&](std::array<int, packet_size>& valid, RTCRay16& query) {
            rtcOccluded16(valid.data(), tree, &context.embree, &query);
        },
        [&](RTCRay& query) { rtcOccluded1(tree, &context.embree, &query); });
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

void Scene::shadow_transmittances(std::span<const Ray> rays, std::span<Rgb> passing, const LightLinks& links,
                                  Among among) const {
    if (!blocker_bits().empty())
        return shadow_transmittances(rays, passing, blocker_bits(), ~links.blocker_sets, among);
    if (links.is_blocked_by(0)) // all are in that set
        return shadow_transmittances(rays, passing, {}, 0, among);
    std::fill_n(passing.begin(), rays.size(), Rgb(1.0f));
}
} // namespace tyndall
