// SPDX-License-Identifier: GPL-3.0-or-later
// What packing takes beside what is estimated before it: the most memory of the process meanwhile, as Linux counts it.
// Meshes are those of TYNDALL_SHARED_DATA; without it nothing is compared, and a message says so.
#include "../benchmarks/support/voxel_meshes.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/voxelize.hpp"
#include <doctest/doctest.h>
#include <malloc.h>

using namespace tyndall;
using namespace tyndall::voxel_dag;

namespace {
/// Of this process, in bytes: a line of what Linux says of it.
std::uint64_t memory(const std::string& name) {
    std::ifstream status("/proc/self/status");
    std::string word;
    while (status >> word)
        if (word == name) {
            std::uint64_t kib = 0;
            status >> kib;
            return kib << 10;
        }
    return 0;
}
/// The most is what it is from now on. False where the system does not allow that, and where a sanitizer takes most of it.
bool forget_most_memory() {
#ifdef __SANITIZE_ADDRESS__
    return false;
#endif
    malloc_trim(0);
    std::ofstream file("/proc/self/clear_refs");
    file << 5 << std::flush;
    return file.good();
}

std::uint64_t bytes_of(const Dag& dag) {
    std::uint64_t bytes = 8 * dag.leaves.size();
    for (const DagLevel& level : dag.levels)
        bytes +=
            level.child_masks.size() + 4 * level.first_children.size() + 4 * level.children.size() + level.tags.size();
    return bytes;
}

// Seen to fail with an estimate of 92 bytes per node, the DAG's among them: Sponza at 2,048 takes 102.
void compare_at(std::uint32_t resolution) {
    for (const std::int64_t which : {0, 1}) {
        CAPTURE(which);
        const bench::BareMesh* const bare = bench::bare_mesh(which);
        if (bare == nullptr || !forget_most_memory()) {
            MESSAGE(
                "nothing is compared: TYNDALL_SHARED_DATA does not say where the meshes are, or the system does not "
                "say what a process takes");
            continue;
        }
        const Dag plain = build_dag(
            voxelize(std::span<const vec3>(bare->positions), bare->triangles, {.resolution = resolution}, Progress())
                .leaves,
            {}, Progress());
        for (const Symmetry symmetry : {Symmetry::None, Symmetry::Reflections, Symmetry::Cube}) {
            CAPTURE(static_cast<int>(symmetry));
            const Dag dag =
                symmetry == Symmetry::None ? plain : merge_symmetric(plain, {.symmetry = symmetry}, Progress());
            REQUIRE(forget_most_memory());
            const std::uint64_t before = memory("VmRSS:");
            const PackedDag packed = pack_dag(dag, Progress());
            const std::uint64_t taken = bytes_of(dag) + memory("VmHWM:") - before;
            CHECK(packed.node_count == dag.node_count());
            CHECK(taken <= estimated_pack_bytes(dag));
            CHECK(taken >= estimated_pack_bytes(dag) / 4); // an estimate that refuses what fits is none
        }
    }
}
} // namespace

TEST_CASE("packing the dragon and Sponza at 2,048 takes no more memory than was estimated") { compare_at(2048); }
TEST_CASE("packing the dragon and Sponza at 8,192 takes no more memory than was estimated" *
          doctest::test_suite("long")) {
    compare_at(8192);
}
