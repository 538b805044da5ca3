// SPDX-License-Identifier: GPL-3.0-or-later
// How rays are put to Embree, and what its filters know: of ray_queries.cpp and shadow_queries.cpp alone.
#pragma once
#include "scene/embree.hpp"
#include "scene/instance_places.hpp"
#include "scene/scene.hpp"
#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace tyndall {
inline constexpr std::size_t packet_size = 16;
/// Fewer rays than this are traced one by one.
inline constexpr std::size_t smallest_packet = 4;

/// Fills the lanes of a packet; returns which hold a ray that starts within reach: those are -1, as Embree wants it. A CPU
/// without AVX-512 goes by their ranges instead: those of rays from beyond are empty.
[[nodiscard]] inline std::array<int, packet_size> fill_packet(RTCRay16& packet, std::span<const Ray> rays,
                                                              unsigned int mask, float reach_m) {
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

[[nodiscard]] inline const QueryContext& context_of(const RTCFilterFunctionNArguments* arguments) {
    return static_cast<const QueryContext&>(*reinterpret_cast<const CellQuery*>(arguments->context));
}

[[nodiscard]] inline Hit hit_of(const RTCRay& ray, const RTCHit& hit) {
    return {.distance_m = ray.tfar,
            .instance = hit.instID[0],
            .triangle = hit.primID,
            .cell = cell_of(hit.primID, hit.geomID),
            .barycentrics = vec2(hit.u, hit.v),
            .geometric_normal = vec3(hit.Ng_x, hit.Ng_y, hit.Ng_z)};
}

/// Distances stay what they are: directions are as long there as the space is stretched.
[[nodiscard]] inline Ray in_object(const mat4& object_from_scene, const Ray& ray) {
    return {.origin = vec3(object_from_scene * vec4(ray.origin, 1.0f)),
            .direction = mat3(object_from_scene) * ray.direction,
            .near_m = ray.near_m,
            .far_m = ray.far_m};
}
} // namespace tyndall
