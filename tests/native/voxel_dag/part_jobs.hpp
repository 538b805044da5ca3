// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes that become voxels in parts, and at once.
#pragma once
#include "native/voxel_dag/step_meshes.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/encode_attributes.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/out_of_core.hpp"
#include "voxel_dag/pack_dag.hpp"
#include <fstream>
#include <iterator>
#include <unistd.h>

namespace tyndall::voxel_dag::in_parts {
/// Shared by so many processes it leaves each little: what splits a small cube into many parts.
inline constexpr std::uint64_t budget_bytes = 128 << 20;

/// A folder that goes with the test.
class TestFolder {
public:
    TestFolder() : path_(std::filesystem::temp_directory_path() / ("tyndall_out_of_core_" + std::to_string(getpid()))) {
        std::filesystem::create_directories(path_);
    }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;
    ~TestFolder() { std::filesystem::remove_all(path_); }
    [[nodiscard]] std::filesystem::path operator/(const char* name) const { return path_ / name; }
    [[nodiscard]] std::size_t entry_count() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
    }

private:
    std::filesystem::path path_;
};

inline std::string bytes_of_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

struct Job {
    oracle::Mesh mesh;
    std::uint32_t level;
    VoxelizeRule rule = VoxelizeRule::Thin;
    Symmetry symmetry = Symmetry::Cube;
    Surface surface = {};
    AttributeConfig attributes = {};

    [[nodiscard]] OutOfCoreConfig config(const TestFolder& folder, std::uint32_t worker_count) const {
        VoxelizeConfig voxels = oracle::config_of(level, rule);
        voxels.memory_budget_bytes = budget_bytes;
        return {.voxels = voxels,
                .symmetry = symmetry,
                .surface = surface,
                .attributes = attributes,
                .worker_count = worker_count,
                .scratch_folder = folder / "scratch"};
    }
    [[nodiscard]] OutOfCore out_of_core(const TestFolder& folder, std::uint32_t worker_count) const {
        return {std::span<const dvec3>(mesh.positions), mesh.triangles, config(folder, worker_count), Progress()};
    }
    [[nodiscard]] LeafMasks voxels() const {
        return voxelize(std::span<const dvec3>(mesh.positions), mesh.triangles, oracle::config_of(level, rule),
                        Progress())
            .leaves;
    }
    [[nodiscard]] std::string at_once(const TestFolder& folder) const {
        const VoxelizeConfig config = oracle::config_of(level, rule);
        const LeafMasks leaves = voxels();
        Dag dag = build_dag(leaves, {}, Progress());
        if (symmetry != Symmetry::None)
            dag = merge_symmetric(dag, {.symmetry = symmetry}, Progress());
        PlacedDag placed{.dag = pack_dag(dag, Progress()), .bounds_m = *config.bounds_m};
        if (!surface.is_empty() && !leaves.codes.empty())
            placed.attributes =
                encode_attributes(placed.dag,
                                  surface_attributes(std::span<const dvec3>(mesh.positions), mesh.triangles, config,
                                                     leaves, surface, Progress()),
                                  attributes, Progress());
        write_dag(placed, folder / "at_once.tdag", Progress());
        return bytes_of_file(folder / "at_once.tdag");
    }
    [[nodiscard]] std::string in_parts(const TestFolder& folder, std::uint32_t worker_count,
                                       OutOfCoreStatistics* statistics = nullptr) const {
        Progress progress;
        const OutOfCoreStatistics made = out_of_core(folder, worker_count).finish(folder / "in_parts.tdag", progress);
        if (statistics != nullptr)
            *statistics = made;
        return bytes_of_file(folder / "in_parts.tdag");
    }
};

/// Triangles of all sizes in and around the cube, some on its faces and on those between sub-cubes.
inline Job soup(std::uint32_t level, int count, std::uint32_t seed) {
    std::mt19937 random(seed);
    const std::int64_t side = std::int64_t{1} << level;
    std::vector<oracle::Triangle> triangles;
    for (int i = 0; i < count; ++i)
        triangles.push_back(oracle::random_triangle(random, level, 1 + oracle::random_below(random, side / 4), side / 8,
                                                    i % 3 == 0 ? oracle::steps_per_voxel : 1));
    return {.mesh = oracle::mesh_of(triangles), .level = level};
}
} // namespace tyndall::voxel_dag::in_parts
