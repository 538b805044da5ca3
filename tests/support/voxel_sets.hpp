// SPDX-License-Identifier: GPL-3.0-or-later
// Sets of voxels that tests and benchmarks of voxel DAGs share.
#pragma once
#include "core/parallel.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include <functional>
#include <random>
#include <tbb/global_control.h>

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

/// All that with_threads() does, and more threads than cores where the machine has too few to test with.
template <typename Work>
auto with_exactly(int thread_count, Work&& work) {
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(thread_count));
    tbb::task_arena arena(thread_count);
    return arena.execute(std::forward<Work>(work));
}
} // namespace tyndall::support
