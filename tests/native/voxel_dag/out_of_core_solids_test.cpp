// SPDX-License-Identifier: GPL-3.0-or-later
// Solids part by part: the file is the one that is made at once, byte for byte.
#include "core/errors.hpp"
#include "native/voxel_dag/part_jobs.hpp"
#include "voxel_dag/solid_fill.hpp"
#include <doctest/doctest.h>

namespace out_of_core_solids_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::voxel_dag::in_parts;

namespace {
std::string solid_at_once(const Job& job, const TestFolder& folder) {
    const VoxelizeConfig config = oracle::config_of(job.level, job.rule);
    const LeafMasks solid =
        solid_fill(std::span<const dvec3>(job.mesh.positions), job.mesh.triangles, config, job.voxels(), Progress());
    Dag dag = build_dag(solid, {}, Progress());
    if (job.symmetry != Symmetry::None)
        dag = merge_symmetric(dag, {.symmetry = job.symmetry}, Progress());
    write_dag({.dag = pack_dag(dag, Progress()), .bounds_m = *config.bounds_m}, folder / "at_once.tdag", Progress());
    return bytes_of_file(folder / "at_once.tdag");
}
OutOfCore solid_parts(const Job& job, const TestFolder& folder, std::uint32_t worker_count) {
    OutOfCoreConfig config = job.config(folder, worker_count);
    config.is_solid = true;
    return {std::span<const dvec3>(job.mesh.positions), job.mesh.triangles, config, Progress()};
}
std::string solid_in_parts(const Job& job, const TestFolder& folder, std::uint32_t worker_count,
                           OutOfCoreStatistics* statistics = nullptr) {
    Progress progress;
    const auto made = solid_parts(job, folder, worker_count).finish(folder / "in_parts.tdag", progress);
    if (statistics != nullptr)
        *statistics = made;
    return bytes_of_file(folder / "in_parts.tdag");
}
void add_tetrahedron(std::vector<oracle::Triangle>& triangles, const std::array<oracle::Point, 4>& at) {
    for (const std::array<std::size_t, 3>& face :
         {std::array<std::size_t, 3>{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
        triangles.push_back({at[face[0]], at[face[1]], at[face[2]]});
}
/// Tetrahedra that overlap, some turned inside out, whose corners lie in and around the cube, on centres of voxels or on
/// the faces of sub-cubes now and then.
Job tetrahedra(std::uint32_t level, int count, std::uint32_t seed) {
    std::mt19937 random(seed);
    const std::int64_t side = std::int64_t{1} << level;
    constexpr std::array<std::int64_t, 3> grids{1, oracle::steps_per_voxel / 2, 32 * oracle::steps_per_voxel};
    std::vector<oracle::Triangle> triangles;
    for (int i = 0; i < count; ++i) {
        std::array<oracle::Point, 4> corners;
        const std::int64_t grid = grids[static_cast<std::size_t>(i) % grids.size()];
        for (oracle::Point& corner : corners)
            for (std::int64_t& at : corner)
                at = (oracle::random_below(random, 2 * side * oracle::steps_per_voxel) / grid) * grid -
                     side / 2 * oracle::steps_per_voxel;
        add_tetrahedron(triangles, corners);
    }
    return {.mesh = oracle::mesh_of(triangles), .level = level};
}
} // namespace

// Seen to fail where crossings before a part are left out, and where triangles before the cube are.
TEST_CASE("a solid in parts or at once: the file has the same bytes") {
    const TestFolder folder;
    std::size_t most_parts = 0;
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        CAPTURE(seed);
        Job job = tetrahedra(6 + seed % 4, 1 + static_cast<int>(seed), seed);
        job.rule = seed % 2 == 0 ? VoxelizeRule::Thin : VoxelizeRule::Conservative;
        job.symmetry = static_cast<Symmetry>(seed % 3);
        const std::string wanted = solid_at_once(job, folder);
        for (const std::uint32_t worker_count : {1u, 64u, 128u}) {
            OutOfCoreStatistics statistics;
            CHECK((solid_in_parts(job, folder, worker_count, &statistics) == wanted));
            most_parts = std::max(most_parts, statistics.part_count);
        }
    }
    CHECK(most_parts > 100);
}

TEST_CASE("a cube within the mesh is full, without a triangle in any part, and one beside it is empty") {
    const TestFolder folder;
    const std::int64_t far = std::int64_t{1} << 20;
    std::vector<oracle::Triangle> around;
    add_tetrahedron(around,
                    {{{-far, -far, -far}, {10 * far, -far, -far}, {-far, 10 * far, -far}, {-far, -far, 10 * far}}});
    Job job{.mesh = oracle::mesh_of(around), .level = 8};
    OutOfCoreStatistics statistics;
    CHECK((solid_in_parts(job, folder, 256, &statistics) == solid_at_once(job, folder)));
    CHECK(statistics.part_count == 64);
    CHECK(statistics.voxel_count == std::uint64_t{1} << 24);
    for (dvec3& position : job.mesh.positions)
        position.x += 1000.0 * far;
    CHECK((solid_in_parts(job, folder, 256, &statistics) == solid_at_once(job, folder)));
    CHECK(statistics.voxel_count == 0);
}

TEST_CASE("a solid's parts are no surface's: one does not go on with the other's") {
    const TestFolder folder;
    const Job job = tetrahedra(8, 3, 5);
    OutOfCore surface = job.out_of_core(folder, 256), solid = solid_parts(job, folder, 256);
    CHECK(surface.part_path(0).parent_path() != solid.part_path(0).parent_path());
}

TEST_CASE("a solid of a mesh that is open, and one whose voxels carry something, are refused") {
    const TestFolder folder;
    Job job = tetrahedra(6, 1, 3);
    const std::vector<vec3> colors(job.mesh.positions.size(), vec3(0.5f));
    Job colored = job;
    colored.surface.colors = colors;
    CHECK_THROWS_AS(solid_parts(colored, folder, 1), InvalidInput);
    job.mesh.triangles.pop_back();
    CHECK_THROWS_AS(solid_parts(job, folder, 1), InvalidInput);
}
} // namespace out_of_core_solids_test
