// SPDX-License-Identifier: GPL-3.0-or-later
// Whatever the parts, the threads and the interruptions: the file is the one that is made at once, byte for byte.
#include "native/voxel_dag/part_jobs.hpp"
#include "voxel_dag/join_parts.hpp"
#include <doctest/doctest.h>

namespace out_of_core_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::voxel_dag::in_parts;
using namespace tyndall::support;

static constexpr std::uint64_t no_limit = ~std::uint64_t{0};

TEST_CASE("in parts or at once, the file has the same bytes") {
    const TestFolder folder;
    int split_count = 0;
    for (std::uint32_t seed = 0; seed < 18; ++seed) {
        CAPTURE(seed);
        Job job = soup(seed % 4 == 0 ? 6 : 7 + seed % 3, 100 + 20 * static_cast<int>(seed), seed);
        job.rule = seed % 2 == 0 ? VoxelizeRule::Thin : VoxelizeRule::Conservative;
        job.symmetry = static_cast<Symmetry>(seed % 3);
        const std::string wanted = job.at_once(folder);
        OutOfCoreStatistics statistics;
        CHECK((job.in_parts(folder, 1, &statistics) == wanted));
        CHECK(statistics.part_count == 1);
        for (const std::uint32_t worker_count : {64u, 256u}) {
            CHECK((job.in_parts(folder, worker_count, &statistics) == wanted));
            CHECK(std::filesystem::is_empty(folder / "scratch"));
        }
        split_count += statistics.part_count > 1;
    }
    CHECK(split_count >= 4);
}

TEST_CASE("the file depends on neither the number of threads nor on the order in which parts were made") {
    const TestFolder folder;
    const Job job = soup(9, 400, 77);
    const std::string wanted = job.at_once(folder);
    for (const int thread_count : {1, 2, 7})
        with_exactly(thread_count, [&] {
            OutOfCore parts = job.out_of_core(folder, 256);
            REQUIRE(parts.part_count() > 8);
            for (std::size_t part = parts.part_count(); part-- > 0;)
                parts.make_part(part, Progress());
            OutOfCoreStatistics statistics;
            CHECK((job.in_parts(folder, 256, &statistics) == wanted));
            CHECK(statistics.kept_part_count == parts.part_count());
        });
}

TEST_CASE("a cube of one brick, an empty one and one with most of its parts empty") {
    const TestFolder folder;
    Job job = soup(2, 3, 1);
    CHECK((job.in_parts(folder, 1) == job.at_once(folder)));
    for (const std::int64_t corner : {0, 511, -40})
        for (const Symmetry symmetry : {Symmetry::None, Symmetry::Cube}) {
            job = {.mesh = oracle::mesh_of(oracle::box({corner * 256, corner * 256, corner * 256},
                                                       {corner * 256 + 700, corner * 256 + 800, corner * 256 + 900})),
                   .level = 9,
                   .symmetry = symmetry};
            CHECK((job.in_parts(folder, 128) == job.at_once(folder)));
        }
}

TEST_CASE("what was finished before an interruption is kept, and a damaged part is made again and named") {
    const TestFolder folder;
    const Job job = soup(9, 400, 5);
    const std::string wanted = job.at_once(folder);
    for (const std::uintmax_t damaged_byte : {0u, 60u, 380u, 900u}) {
        OutOfCore interrupted = job.out_of_core(folder, 64);
        for (std::size_t part = 0; part < 5; ++part)
            interrupted.make_part(part, Progress());
        {
            std::fstream file(interrupted.part_path(3), std::ios::binary | std::ios::in | std::ios::out);
            file.seekg(static_cast<std::streamoff>(damaged_byte));
            const int byte = file.get();
            file.seekp(static_cast<std::streamoff>(damaged_byte));
            file.put(static_cast<char>(byte ^ 16));
        }
        std::filesystem::resize_file(interrupted.part_path(4),
                                     std::filesystem::file_size(interrupted.part_path(4)) - 1);
        OutOfCoreStatistics statistics;
        CHECK((job.in_parts(folder, 64, &statistics) == wanted));
        CHECK(statistics.kept_part_count == 3);
        CHECK(statistics.damaged_parts ==
              std::vector{interrupted.part_path(3).filename().string(), interrupted.part_path(4).filename().string()});
        CHECK(std::filesystem::is_empty(folder / "scratch"));
    }
}

TEST_CASE("with a larger budget a job goes on with the parts that it has") {
    const TestFolder folder;
    const Job job = soup(9, 400, 6);
    OutOfCore interrupted = job.out_of_core(folder, 256);
    for (std::size_t part = 0; part < 7; ++part)
        interrupted.make_part(part, Progress());
    REQUIRE(job.out_of_core(folder, 1).part_count() == interrupted.part_count());
    OutOfCoreStatistics statistics;
    CHECK((job.in_parts(folder, 1, &statistics) == job.at_once(folder)));
    CHECK(statistics.kept_part_count == 7);
    CHECK(job.out_of_core(folder, 1).part_count() == 1);
}

TEST_CASE("jobs of other meshes and settings share a scratch folder, not their parts") {
    const TestFolder folder;
    Job first = soup(9, 400, 8), second = first;
    second.mesh.positions[7].x += 1.0 / 256;
    Job third = first;
    third.rule = VoxelizeRule::Conservative;
    for (const Job* job : {&first, &second, &third})
        for (std::size_t part = 0; part < 3; ++part)
            job->out_of_core(folder, 64).make_part(part, Progress());
    for (const Job* job : {&second, &third, &first}) {
        OutOfCoreStatistics statistics;
        CHECK((job->in_parts(folder, 64, &statistics) == job->at_once(folder)));
        CHECK(statistics.kept_part_count == 3);
        CHECK(statistics.damaged_parts.empty());
    }
}

TEST_CASE("a part under the name of another one is not taken for it") {
    const TestFolder folder;
    const Job job = soup(9, 400, 9);
    OutOfCore parts = job.out_of_core(folder, 64);
    parts.make_part(0, Progress());
    std::filesystem::copy_file(parts.part_path(0), parts.part_path(1));
    OutOfCoreStatistics statistics;
    CHECK((job.in_parts(folder, 64, &statistics) == job.at_once(folder)));
    CHECK(statistics.damaged_parts == std::vector{parts.part_path(1).filename().string()});
}

TEST_CASE("a table that does not fit the budget is filled in several passes, to the same DAG") {
    const TestFolder folder;
    for (const Symmetry symmetry : {Symmetry::None, Symmetry::Reflections, Symmetry::Cube}) {
        Job job = soup(9, 400, 11);
        job.symmetry = symmetry;
        std::vector<PartFile> files;
        OutOfCore parts = job.out_of_core(folder, 32);
        for (std::size_t part = 0; part < parts.part_count(); ++part) {
            parts.make_part(part, Progress());
            files.push_back(parts.part(part, Progress()));
        }
        const auto joined = [&](std::uint64_t limit_bytes) {
            return join_parts(files,
                              {.level = 9,
                               .part_level = parts.part_level(),
                               .symmetry = symmetry,
                               .memory_budget_bytes = limit_bytes},
                              Progress(), [](double) {});
        };
        const JoinResult at_once = joined(no_limit);
        CHECK(at_once.statistics.most_passes == 1);
        std::uint64_t limit_bytes = 64 << 20;
        JoinResult in_passes = joined(limit_bytes);
        while (in_passes.statistics.most_passes < 5)
            in_passes = joined(limit_bytes = limit_bytes * 3 / 4);
        CHECK((in_passes.dag == at_once.dag));
        CHECK_THROWS_AS(joined(1 << 16), InvalidInput);
    }
}

TEST_CASE("a graph that the budget has no room for is refused before it is packed, and its parts are kept") {
    const TestFolder folder;
    Job job = soup(9, 400, 14);
    OutOfCoreConfig config = job.config(folder, 8);
    const Dag plain = build_dag(job.voxels(), {}, Progress());
    config.voxels.memory_budget_bytes = estimated_pack_bytes(merge_symmetric(plain, {}, Progress())) - 1;
    OutOfCore parts(std::span<const dvec3>(job.mesh.positions), job.mesh.triangles, config, Progress());
    Progress progress;
    CHECK_THROWS_WITH_AS(parts.finish(folder / "a.tdag", progress), doctest::Contains("parts are kept"), InvalidInput);
    CHECK_FALSE(std::filesystem::exists(folder / "a.tdag"));
    for (std::size_t part = 0; part < parts.part_count(); ++part)
        CHECK(std::filesystem::exists(parts.part_path(part)));
}

TEST_CASE("a cancelled call stops, and what it has finished is there for the next") {
    const TestFolder folder;
    const Job job = soup(9, 400, 12);
    job.out_of_core(folder, 64).make_part(0, Progress());
    Progress progress;
    progress.cancel();
    CHECK_THROWS_AS(job.out_of_core(folder, 64).finish(folder / "a.tdag", progress), Cancelled);
    OutOfCoreStatistics statistics;
    CHECK((job.in_parts(folder, 64, &statistics) == job.at_once(folder)));
    CHECK(statistics.kept_part_count == 1);
}

TEST_CASE("sub-cubes' voxels are those of the whole") {
    const Job job = soup(8, 1000, 13);
    const VoxelizeConfig config = oracle::config_of(job.level, VoxelizeRule::Conservative);
    const SnappedMesh mesh = snap(std::span<const dvec3>(job.mesh.positions), job.mesh.triangles, config, Progress());
    const LeafMasks whole = voxelize(mesh, config, Progress()).leaves;
    for (const std::uint64_t most_bricks : {1'000'000u, 4'096u}) {
        const SubVolumes parts = split(mesh, config.rule, most_bricks, most_level, Progress());
        LeafMasks all{.level = job.level, .codes = {}, .masks = {}};
        for (std::size_t part = 0; part < parts.count(); ++part) {
            const SubMesh sub = sub_mesh(mesh, parts, part);
            const LeafMasks leaves = voxelize(sub.mesh, config, Progress()).leaves;
            for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick) {
                all.codes.push_back(parts.codes[part] << 3 * (parts.level - leaf_level) | leaves.codes[brick]);
                all.masks.push_back(leaves.masks[brick]);
            }
        }
        CHECK((all == whole));
        CHECK(parts.count() == (most_bricks > 4'096 ? 1 : 64));
    }
    CHECK_THROWS_AS(static_cast<void>(split(mesh, config.rule, 10, most_level, Progress())), InvalidInput);
}
} // namespace out_of_core_test
