// SPDX-License-Identifier: GPL-3.0-or-later
// Sets of voxels that tests and benchmarks of voxel DAGs share.
#pragma once
#include "core/parallel.hpp"
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include <algorithm>
#include <functional>
#include <random>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace tyndall::support {
using voxel_dag::LeafMasks;
using voxel_dag::Voxel;

/// Voxels of which each is there with the same probability.
inline LeafMasks random_voxels(std::uint32_t level, double probability, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::bernoulli_distribution is_there(probability);
    LeafMasks voxels{.level = level, .codes = {}, .masks = {}};
    for (std::uint64_t code = 0; code < std::uint64_t{1} << 3 * (level - voxel_dag::leaf_level); ++code) {
        std::uint64_t mask = 0;
        for (std::uint32_t i = 0; i < 64; ++i)
            mask |= std::uint64_t{is_there(random)} << i;
        if (mask != 0)
            voxels.codes.push_back(code), voxels.masks.push_back(mask);
    }
    return voxels;
}

/// Voxels that a function of them says yes to, asked brick by brick where it may have any: `has_any` says so of a
/// cube, by its lowest voxel and its width.
inline LeafMasks chosen_voxels(std::uint32_t level, const std::function<bool(const Voxel&)>& is_there,
                               const std::function<bool(const Voxel&, std::uint32_t)>& has_any) {
    LeafMasks voxels{.level = level, .codes = {}, .masks = {}};
    const std::function<void(std::uint64_t, std::uint32_t)> visit = [&](std::uint64_t code, std::uint32_t at) {
        if (!has_any(voxel_dag::voxel_at(code << 3 * at), 1u << at))
            return;
        if (at > voxel_dag::leaf_level) {
            for (std::uint64_t octant = 0; octant < 8; ++octant)
                visit(code << 3 | octant, at - 1);
            return;
        }
        std::uint64_t mask = 0;
        for (std::uint64_t i = 0; i < 64; ++i)
            mask |= std::uint64_t{is_there(voxel_dag::voxel_at(code << 6 | i))} << i;
        if (mask != 0)
            voxels.codes.push_back(code), voxels.masks.push_back(mask);
    };
    visit(0, level);
    return voxels;
}

/// Voxels that a sphere's surface goes through. Its centre, in voxels, need not be that of the cube.
inline LeafMasks sphere_voxels(std::uint32_t level, const std::array<double, 3>& centre, double radius) {
    const auto has_any = [=](const Voxel& lowest, std::uint32_t width) {
        double nearest_2 = 0.0, farthest_2 = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double below = lowest[axis] - centre[axis], above = below + width;
            nearest_2 += below > 0.0 ? below * below : above < 0.0 ? above * above : 0.0;
            farthest_2 += std::max(below * below, above * above);
        }
        return nearest_2 <= radius * radius && radius * radius < farthest_2;
    };
    return chosen_voxels(
        level, [&](const Voxel& voxel) { return has_any(voxel, 1); }, has_any);
}

/// Sierpinski's tetrahedron: at each scale the octants of even parity, 4^level voxels.
inline LeafMasks sierpinski_voxels(std::uint32_t level) {
    const auto is_there = [](const Voxel& voxel) { return (voxel[0] ^ voxel[1] ^ voxel[2]) == 0; };
    return chosen_voxels(level, is_there, [&](const Voxel& lowest, std::uint32_t width) {
        return is_there({lowest[0] / width, lowest[1] / width, lowest[2] / width});
    });
}

inline LeafMasks full_voxels(std::uint32_t level) {
    LeafMasks voxels{.level = level, .codes = {}, .masks = {}};
    for (std::uint64_t code = 0; code < std::uint64_t{1} << 3 * (level - voxel_dag::leaf_level); ++code)
        voxels.codes.push_back(code), voxels.masks.push_back(~std::uint64_t{0});
    return voxels;
}

/// Voxels that an element of the cube's symmetries has turned about the centre.
inline LeafMasks turned_voxels(const LeafMasks& voxels, std::uint32_t element) {
    std::vector<std::pair<std::uint64_t, std::uint64_t>> bricks;
    for (std::size_t brick = 0; brick < voxels.codes.size(); ++brick) {
        std::uint64_t code = 0;
        for (std::uint32_t digit = 0; digit + voxel_dag::leaf_level < voxels.level; ++digit)
            code |= std::uint64_t{voxel_dag::cube_group.octant[element][voxels.codes[brick] >> 3 * digit & 7]}
                    << 3 * digit;
        bricks.emplace_back(code, voxel_dag::turned_leaf(element, voxels.masks[brick]));
    }
    std::ranges::sort(bricks);
    LeafMasks turned{.level = voxels.level, .codes = {}, .masks = {}};
    for (const auto& [code, mask] : bricks)
        turned.codes.push_back(code), turned.masks.push_back(mask);
    return turned;
}

/// Two sets of one level in opposite octants of a cube of the next.
inline LeafMasks in_opposite_octants(const LeafMasks& first, const LeafMasks& second) {
    LeafMasks both{.level = first.level + 1, .codes = first.codes, .masks = first.masks};
    const std::uint64_t octant = std::uint64_t{7} << 3 * (first.level - voxel_dag::leaf_level);
    for (const std::uint64_t code : second.codes)
        both.codes.push_back(octant | code);
    both.masks.insert(both.masks.end(), second.masks.begin(), second.masks.end());
    return both;
}

/// Cubes put together of few smaller ones, turned at random: many merges, at each scale, and many that look the same
/// after some turns.
inline LeafMasks kaleidoscope_voxels(std::uint32_t level, std::uint32_t seed) {
    std::mt19937_64 random(seed);
    const auto below = [&](std::size_t past) { return static_cast<std::size_t>(random() % past); };
    const std::vector<std::uint64_t> bricks{
        ~std::uint64_t{0}, 1, 0x000000000000ffff, 0x8000000000000001, random() & random() & random(), random()};
    std::vector<LeafMasks> pool;
    for (const std::uint64_t mask : bricks)
        pool.push_back({.level = voxel_dag::leaf_level, .codes = {0}, .masks = {mask}});
    for (std::uint32_t at = voxel_dag::leaf_level + 1; at <= level; ++at) {
        std::vector<LeafMasks> larger;
        for (int i = 0; i < 6; ++i) {
            LeafMasks cube{.level = at, .codes = {}, .masks = {}};
            const std::size_t same = below(pool.size()), kinds = i < 3 ? 1 : 1 + below(3);
            for (std::uint64_t octant = 0; octant < 8; ++octant) {
                if (below(8) < 2 && octant > 0)
                    continue;
                const LeafMasks part = turned_voxels(pool[(same + below(kinds)) % pool.size()],
                                                     static_cast<std::uint32_t>(below(i % 3 == 0 ? 1 : 48)));
                for (std::size_t brick = 0; brick < part.codes.size(); ++brick) {
                    cube.codes.push_back(octant << 3 * (at - 1 - voxel_dag::leaf_level) | part.codes[brick]);
                    cube.masks.push_back(part.masks[brick]);
                }
            }
            larger.push_back(std::move(cube));
        }
        pool = std::move(larger);
    }
    return pool[seed % pool.size()];
}

/// All that with_threads() does, and more threads than cores where the machine has too few to test with.
template <typename Work>
auto with_exactly(int thread_count, Work&& work) {
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(thread_count));
    tbb::task_arena arena(thread_count);
    return arena.execute(std::forward<Work>(work));
}
} // namespace tyndall::support
