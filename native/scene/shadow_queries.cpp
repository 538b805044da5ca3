// SPDX-License-Identifier: GPL-3.0-or-later
// What light passes on its way: rays that ask one at a time, or 16 that start and go alike.
// Based on: Embree 3's packets, without its coherent flag.
// Differs:  that flag never goes with rtcOccluded16: in Embree 3.13.5 that does not return for some packets that meet
//           instances.
// Bound:    as in ray_queries.cpp; surfaces that count what was passed before cost what all surfaces on the way do.
#include "scene/instance_masks.hpp"
#include "scene/query_context.hpp"
#include <tuple>

namespace tyndall {
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
        passing *= dvec3(context.scene.passing_share(context.rays[ray.id], hit_of(ray, hit), context.kind));
        if (Rgb(passing) != Rgb(0.0f))
            arguments->valid[lane] = 0;
    }
}

/// Materials are asked where some let light pass; where some count what was passed, hits wait to be asked in order.
static void ask_materials(QueryContext& context, bool lets_light_pass, bool counts_passed) {
    thread_local std::vector<PassedHit> waiting;
    waiting.clear();
    context.asks_materials = lets_light_pass;
    context.waiting = counts_passed ? &waiting : nullptr;
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
        context.passing[id] *= dvec3(context.scene.passing_share(asking, hit, context.kind));
    }
}

/// What stops a ray leaves its far end below 0; such a one is not asked for in the next tree.
static void occlude(QueryContext& context, RTCRay& query) {
    context.trace_all(attenuate, [&](RTCScene tree) {
        if (query.tfar >= 0.0f)
            rtcOccluded1(tree, &context.embree, &query);
    });
}

/// The same of a packet. Embree wants `valid` aligned to 64 bytes.
static void occlude(QueryContext& context, std::array<int, packet_size>& valid, RTCRay16& query) {
    context.trace_all(attenuate, [&](RTCScene tree) {
        for (std::size_t lane = 0; lane < packet_size; ++lane)
            if (query.tfar[lane] < 0.0f)
                valid[lane] = 0;
        rtcOccluded16(valid.data(), tree, &context.embree, &query);
    });
}

/// Of one ray.
static Rgb passing_along(QueryContext& context, const Ray& ray, Among among, const dvec3& passing) {
    if (!is_within(ray.origin, context.scene.reach_m()))
        return Rgb(1.0f);
    RTCRay query = embree_ray(ray, mask_among(among, blocking_mask(context.kind)));
    occlude(context, query);
    let_pass_in_order(context);
    const bool is_occluded = query.tfar < 0.0f;
    return is_occluded ? Rgb(0.0f) : Rgb(passing);
}

Rgb Scene::shadow_transmittance(const Ray& ray, Among among, RayKind kind) const {
    dvec3 passing(1.0);
    QueryContext context(*this, &ray, &passing);
    context.kind = kind;
    ask_materials(context, geometry_->lets_light_pass, geometry_->counts_passed);
    return passing_along(context, ray, among, passing);
}

Rgb Scene::shadow_transmittance(const Ray& ray, std::span<const std::uint64_t> bits_of_instance, std::uint64_t ignored,
                                Among among) const {
    dvec3 passing(1.0);
    QueryContext context(*this, &ray, &passing);
    context.bits_of_instance = bits_of_instance.data();
    context.ignored = ignored;
    ask_materials(context, geometry_->lets_light_pass, geometry_->counts_passed);
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
        ask_materials(context, geometry_->lets_light_pass, geometry_->counts_passed);
        RTCRay16 query;
        alignas(64) std::array<int, packet_size> valid =
            fill_packet(query, these, mask_among(among, shadow_mask), reach_m());
        occlude(context, valid, query);
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
        alignas(64) std::array<int, packet_size> valid = fill_packet(query, these, mask, reach_m);
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
        [&](std::array<int, packet_size>& valid, RTCRay16& query) { occlude(context, valid, query); },
        [&](RTCRay& query) { occlude(context, query); });
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

void Scene::shadow_transmittances(std::span<const Ray> rays, std::span<Rgb> passing, const LightLinks& links,
                                  Among among) const {
    if (!blocker_bits().empty())
        return shadow_transmittances(rays, passing, blocker_bits(), ~links.blocker_sets, among);
    if (links.is_blocked_by(0)) // all are in that set
        return shadow_transmittances(rays, passing, {}, 0, among);
    std::fill_n(passing.begin(), rays.size(), Rgb(1.0f));
}
} // namespace tyndall
