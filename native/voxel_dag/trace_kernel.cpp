// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/trace_kernel.hpp"
#include <algorithm>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "voxel_dag/trace_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "voxel_dag/trace_packet-inl.hpp"
#include "voxel_dag/trace_walk-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::voxel_dag::HWY_NAMESPACE {
static constexpr std::size_t rays_at_once = 16; ///< Rays that take turns: one's loads wait while the others go on.

/// At the root; false: the ray misses the whole.
HWY_INLINE bool start_at_root(Walk& walk, const TraceTables& tables, const VoxelRay& ray) {
    const double side = static_cast<double>(1u << tables.dag->level);
    if (!walk.ray.set(ray, side))
        return false;
    Cursor cursor;
    cursor.start(tables, walk.ray.against);
    const double centre[3] = {0.5 * side, 0.5 * side, 0.5 * side};
    walk.start(cursor, centre, walk.ray.from, walk.ray.until);
    return true;
}
HWY_INLINE Walk::State walk_one(Walk& walk, const TraceTables& tables, const VoxelRay& ray) {
    if (!start_at_root(walk, tables, ray))
        return Walk::State::Misses;
    Walk::State state;
    do
        state = walk.advance();
    while (state == Walk::State::Goes);
    return state;
}

/// Rays that take turns, by their numbers; receive(number, walk) for those that hit.
template <class Receive>
HWY_INLINE void walk_all(const TraceTables& tables, std::span<const VoxelRay> rays,
                         std::span<const std::uint32_t> numbers, const Receive& receive) {
    Walk walks[rays_at_once];
    std::uint32_t number_of[rays_at_once];
    std::size_t next = 0, busy = 0;
    const auto start_next = [&](std::size_t slot) HWY_ATTR {
        while (next < numbers.size())
            if (number_of[slot] = numbers[next++]; start_at_root(walks[slot], tables, rays[number_of[slot]]))
                return true;
        return false;
    };
    while (busy < rays_at_once && start_next(busy))
        ++busy;
    while (busy > 0)
        for (std::size_t slot = 0; slot < busy; ++slot) {
            const Walk::State state = walks[slot].advance();
            if (state == Walk::State::Goes)
                continue;
            if (state == Walk::State::Hits)
                receive(number_of[slot], walks[slot]);
            if (!start_next(slot) && --busy != slot) { // the last one takes the free slot
                walks[slot] = walks[busy];
                number_of[slot] = number_of[busy];
            }
        }
}

/// Whether rays begin and go so nearly alike that they share most of what they meet.
HWY_INLINE bool are_alike(std::span<const VoxelRay, packet_size> rays, double side) {
    constexpr double share = 1.0 / 32.0;
    double farthest = 0.0, widest = 0.0, longest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        longest = std::max(longest, std::abs(rays[0].direction[axis]));
        for (std::size_t i = 1; i < packet_size; ++i) {
            farthest = std::max(farthest, std::abs(rays[i].origin[axis] - rays[0].origin[axis]));
            widest = std::max(widest, std::abs(rays[i].direction[axis] - rays[0].direction[axis]));
        }
    }
    return farthest <= share * side && widest <= share * longest;
}

/// Eight after eight that are alike together, and then the others.
template <class Receive>
HWY_INLINE void find_all(const TraceTables& tables, std::span<const VoxelRay> rays, const Receive& receive) {
    std::vector<std::uint32_t> alone;
    const double side = static_cast<double>(1u << tables.dag->level);
    Packet packet;
    for (std::size_t first = 0; first < rays.size(); first += packet_size) {
        if (const std::size_t count = std::min(packet_size, rays.size() - first);
            count < packet_size || tables.dag->level <= packet_level ||
            !are_alike(rays.subspan(first).template first<packet_size>(), side) ||
            !packet.trace(tables, rays.subspan(first).template first<packet_size>(),
                          [&](std::uint32_t lane, const Walk& walk) HWY_ATTR { receive(first + lane, walk); }))
            for (std::size_t i = 0; i < count; ++i)
                alone.push_back(static_cast<std::uint32_t>(first + i));
    }
    walk_all(tables, rays, alone, receive);
}

static void trace_rays(const TraceTables& tables, std::span<const VoxelRay> rays, VoxelHit* hits) {
    find_all(tables, rays, [&](std::size_t ray, const Walk& walk) HWY_ATTR { hits[ray] = walk.hit(); });
}
static void find_hits(const TraceTables& tables, std::span<const VoxelRay> rays, bool* are_hits) {
    find_all(tables, rays, [&](std::size_t ray, const Walk&) HWY_ATTR { are_hits[ray] = true; });
}
static void trace_ray(const TraceTables& tables, const VoxelRay& ray, VoxelHit& hit) {
    Walk walk;
    hit = walk_one(walk, tables, ray) == Walk::State::Hits ? walk.hit() : VoxelHit{};
}
static bool has_hit(const TraceTables& tables, const VoxelRay& ray) {
    Walk walk;
    return walk_one(walk, tables, ray) == Walk::State::Hits;
}
} // namespace tyndall::voxel_dag::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#if HWY_ONCE
namespace tyndall::voxel_dag {
HWY_EXPORT(trace_ray);
HWY_EXPORT(trace_rays);
HWY_EXPORT(has_hit);
HWY_EXPORT(find_hits);
VoxelHit trace_by_vectors(const TraceTables& tables, const VoxelRay& ray) {
    VoxelHit hit;
    HWY_DYNAMIC_DISPATCH(trace_ray)(tables, ray, hit);
    return hit;
}
void trace_by_vectors(const TraceTables& tables, std::span<const VoxelRay> rays, VoxelHit* hits) {
    std::fill_n(hits, rays.size(), VoxelHit{});
    HWY_DYNAMIC_DISPATCH(trace_rays)(tables, rays, hits);
}
bool is_hit_by_vectors(const TraceTables& tables, const VoxelRay& ray) {
    return HWY_DYNAMIC_DISPATCH(has_hit)(tables, ray);
}
void is_hit_by_vectors(const TraceTables& tables, std::span<const VoxelRay> rays, bool* are_hits) {
    std::fill_n(are_hits, rays.size(), false);
    HWY_DYNAMIC_DISPATCH(find_hits)(tables, rays, are_hits);
}
} // namespace tyndall::voxel_dag
#endif
