// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/box_mesh.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/numbered_values.hpp"
#include "voxel_dag/open_faces.hpp"
#include <bit>

namespace tyndall::voxel_dag {
namespace {
constexpr std::uint64_t square_bytes = 2 * sizeof(uvec3) + sizeof(std::uint32_t) + sizeof(dvec3) + 24;
constexpr std::size_t bricks_at_once = 4096;

std::uint64_t square_count(const LeafMasks& leaves, const Progress& progress) {
    return parallel_sum(leaves.codes.size(), bricks_at_once, std::uint64_t{0}, progress,
                        [&](std::size_t begin, std::size_t end) {
                            std::uint64_t count = 0;
                            for (std::size_t brick = begin; brick < end; ++brick)
                                for (const std::uint64_t open : open_faces(leaves, brick))
                                    count += static_cast<std::uint64_t>(std::popcount(open));
                            return count;
                        });
}

/// Corners of a face, against the clock as seen from outside.
std::array<Voxel, 4> corners_of(const Voxel& voxel, std::size_t face) {
    const std::size_t axis = face / 2, right = (axis + 1) % 3, up = (axis + 2) % 3;
    std::array<Voxel, 4> corners;
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
        corners[corner] = voxel;
        corners[corner][axis] += face % 2 == 1;
        const std::uint32_t turn = face % 2 == 1 ? corner : 3 - corner; // seen from below, the other way round
        corners[corner][right] += turn == 1 || turn == 2;
        corners[corner][up] += turn >= 2;
    }
    return corners;
}
} // namespace

BoxMesh box_mesh_of(const LeafMasks& leaves, std::uint64_t memory_budget_bytes, const Progress& progress) {
    const std::uint64_t count = square_count(leaves, progress);
    const std::uint64_t voxel_count = leaves.voxel_count();
    require(voxel_count <= std::uint64_t{1} << 32, "a mesh of ", voxel_count,
            " voxels would number them with more than 32 bits: choose a coarser level");
    constexpr std::uint64_t most_squares = std::uint64_t{1} << 31; // corners are numbered with 32 bits
    require(count <= most_squares, "a mesh of these voxels has ", count, " squares; ", most_squares,
            " are possible: choose a coarser level");
    require(count * square_bytes <= memory_budget_bytes, "a mesh of these voxels has ", count,
            " squares, and takes some ", count * square_bytes, " bytes: more than the memory budget, ",
            memory_budget_bytes, ": choose a coarser level, or raise the budget");
    BoxMesh mesh;
    mesh.triangles.reserve(2 * count);
    mesh.voxel_numbers.reserve(count);
    NumberedValues<std::uint64_t> corners;
    std::uint32_t voxel_number = 0;
    for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick) {
        if (brick % bricks_at_once == 0)
            progress.poll();
        const OpenFaces open = open_faces(leaves, brick);
        for (std::uint64_t left = leaves.masks[brick]; left != 0; left &= left - 1, ++voxel_number) {
            const auto bit = static_cast<std::uint64_t>(std::countr_zero(left));
            const Voxel voxel = voxel_at(leaves.codes[brick] << 3 * leaf_level | bit);
            for (std::size_t face = 0; face < 6; ++face) {
                if ((open[face] >> bit & 1) == 0)
                    continue;
                std::array<std::uint32_t, 4> numbers;
                const std::array<Voxel, 4> places = corners_of(voxel, face);
                for (std::size_t corner = 0; corner < 4; ++corner)
                    numbers[corner] = corners.number_of(morton_code(places[corner]));
                mesh.triangles.emplace_back(numbers[0], numbers[1], numbers[2]);
                mesh.triangles.emplace_back(numbers[0], numbers[2], numbers[3]);
                mesh.voxel_numbers.push_back(voxel_number);
            }
        }
    }
    mesh.positions.reserve(corners.values().size());
    for (const std::uint64_t code : corners.values()) {
        const Voxel corner = voxel_at(code);
        mesh.positions.emplace_back(corner[0], corner[1], corner[2]);
    }
    return mesh;
}
} // namespace tyndall::voxel_dag
