// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/decode.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <set>

namespace build_dag_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

static Dag built(const LeafMasks& voxels) {
    const Progress progress;
    Dag dag = build_dag(voxels, {}, progress);
    require_usable(dag);
    return dag;
}
static LeafMasks decoded(const Dag& dag) {
    const Progress progress;
    return decode(dag, progress);
}

// Seen to fail with a table that compares 32 bits of the hash in place of records, of 20 bits.
TEST_CASE("a DAG decodes to the voxels it was built of, at each resolution, from sparse to dense") {
    for (std::uint32_t level = leaf_level; level <= 8; ++level)
        for (const double probability : {1e-6, 1e-3, 0.05, 0.5, 0.999}) {
            CAPTURE(level);
            CAPTURE(probability);
            const LeafMasks voxels = random_voxels(level, probability, level);
            const Dag dag = built(voxels);
            REQUIRE(decoded(dag) == voxels);
            REQUIRE(dag.voxel_count() == voxels.voxel_count());
        }
    for (const LeafMasks& voxels : {sphere_voxels(8, {128, 128, 128}, 100), sphere_voxels(9, {100.3, 260.1, 240}, 99.5),
                                    sierpinski_voxels(9), full_voxels(7)})
        REQUIRE(decoded(built(voxels)) == voxels);
}

TEST_CASE("a DAG contains each voxel of its set, no other one, and none beyond the cube") {
    for (const double probability : {0.01, 0.4}) {
        const LeafMasks voxels = random_voxels(5, probability, 5);
        const Dag dag = built(voxels);
        for (std::uint64_t code = 0; code < 1 << 15; ++code)
            REQUIRE(dag.contains(voxel_at(code)) == voxels.contains(voxel_at(code)));
        CHECK_FALSE(dag.contains({32, 0, 0}));
        CHECK_FALSE(dag.contains({0, 0, ~0u}));
    }
}

TEST_CASE("no two nodes of a level are equal, and nodes are in the order of first use") {
    const Dag dag = built(sphere_voxels(8, {128, 128, 128}, 100));
    CHECK(std::set(dag.leaves.begin(), dag.leaves.end()).size() == dag.leaves.size());
    for (const DagLevel& nodes : dag.levels) {
        std::set<std::pair<std::uint8_t, std::vector<std::uint32_t>>> distinct;
        for (std::size_t node = 0; node < nodes.node_count(); ++node)
            distinct.insert({nodes.child_masks[node],
                             {nodes.children.begin() + nodes.first_children[node],
                              nodes.children.begin() + nodes.first_children[node + 1]}});
        CHECK(distinct.size() == nodes.node_count());
        std::uint32_t past = 0;
        for (const std::uint32_t child : nodes.children) {
            REQUIRE(child <= past);
            past = std::max(past, child + 1);
        }
    }
}

TEST_CASE("Sierpinski's tetrahedron has 4^level voxels and one node per level, and so have full cubes of 8^level") {
    for (const std::uint32_t level : {2u, 3u, 6u, 9u}) {
        const Dag dag = built(sierpinski_voxels(level));
        CHECK(dag.voxel_count() == std::uint64_t{1} << 2 * level);
        CHECK(dag.node_count() == level - leaf_level + 1);
    }
    for (const std::uint32_t level : {2u, 3u, 7u}) {
        const Dag dag = built(full_voxels(level));
        CHECK(dag.voxel_count() == std::uint64_t{1} << 3 * level);
        CHECK(dag.node_count() == level - leaf_level + 1);
    }
}

TEST_CASE("without voxels there are no nodes, and nothing comes back") {
    for (const std::uint32_t level : {2u, 3u, 17u}) {
        const LeafMasks none{.level = level, .codes = {}, .masks = {}};
        const Dag dag = built(none);
        CHECK(dag.node_count() == 0);
        CHECK(dag.voxel_count() == 0);
        CHECK_FALSE(dag.contains({0, 0, 0}));
        CHECK(decoded(dag) == none);
    }
}

TEST_CASE("one voxel at the far corner of the largest cube is one path") {
    const std::uint32_t last = (1u << most_level) - 1;
    const LeafMasks voxels = leaf_masks_of({{last, last, last}}, most_level);
    const Dag dag = built(voxels);
    CHECK(dag.node_count() == most_level - leaf_level + 1);
    CHECK(dag.contains({last, last, last}));
    CHECK_FALSE(dag.contains({last, last, last - 1}));
    CHECK(decoded(dag) == voxels);
}

// Seen to fail with numbers left as the threads gave them.
TEST_CASE("equal arrays for 1, 2 and 7 threads") {
    const LeafMasks voxels = sphere_voxels(10, {500.7, 512, 470.2}, 411.3); // some 20 blocks
    const Dag one = with_exactly(1, [&] { return built(voxels); });
    for (int run = 0; run < 3; ++run) {
        CHECK(with_exactly(2, [&] { return built(voxels); }) == one);
        CHECK(with_exactly(7, [&] { return built(voxels); }) == one);
    }
    CHECK(decoded(one) == voxels);
}

// Seen to fail with one number in 64 left out as the table grows.
TEST_CASE("tables that were taken too small grow, and nothing is lost") {
    // Of ever more different bricks, so that late blocks find those that came before the tables grew.
    std::mt19937_64 random(8);
    LeafMasks voxels = full_voxels(8);
    for (std::size_t brick = 0; brick < voxels.masks.size(); ++brick)
        voxels.masks[brick] = 0x9e3779b97f4a7c15ull * (random() % (brick / 2 + 1) + 1);
    const Dag dag = built(voxels);
    CHECK(dag.leaves.size() == std::set(voxels.masks.begin(), voxels.masks.end()).size());
    CHECK(dag.leaves.size() > voxels.masks.size() / 4);
    CHECK(decoded(dag) == voxels);
    CHECK(with_exactly(7, [&] { return built(voxels); }) == dag);
}

TEST_CASE("parts of a decoded DAG are as large as asked for, and follow each other") {
    const Progress progress;
    const LeafMasks voxels = sphere_voxels(7, {64, 60, 64}, 50);
    LeafMasks all{.level = voxels.level, .codes = {}, .masks = {}};
    decode(
        built(voxels), 100,
        [&](const LeafMasks& part) {
            REQUIRE(part.codes.size() == std::min<std::size_t>(100, voxels.codes.size() - all.codes.size()));
            all.codes.insert(all.codes.end(), part.codes.begin(), part.codes.end());
            all.masks.insert(all.masks.end(), part.masks.begin(), part.masks.end());
        },
        progress);
    CHECK(all == voxels);
}

TEST_CASE("voxels out of order, budgets that do not suffice and cancelled calls are refused") {
    Progress progress;
    LeafMasks voxels = sphere_voxels(9, {256, 256, 256}, 250);
    std::swap(voxels.codes[40000], voxels.codes[40001]);
    CHECK_THROWS_WITH_AS(build_dag(voxels, {}, progress),
                         "voxels: brick 40001 does not follow the one before it in Morton order", InvalidInput);
    std::swap(voxels.codes[40000], voxels.codes[40001]);
    CHECK_THROWS_AS(build_dag(voxels, {.memory_budget_bytes = 1 << 20}, progress), InvalidInput); // by the estimate
    const LeafMasks noise = random_voxels(8, 0.5, 8);
    const std::uint64_t bytes = estimated_build_bytes(noise.codes.size(), noise.level);
    CHECK_THROWS_AS(build_dag(noise, {.memory_budget_bytes = bytes}, progress), InvalidInput); // on the way
    CHECK_THROWS_AS(build_dag({.level = 18, .codes = {0}, .masks = {1}}, {}, progress), InvalidInput);
    CHECK_THROWS_AS(build_dag({.level = 3, .codes = {0}, .masks = {}}, {}, progress), InvalidInput);
    progress.cancel();
    CHECK_THROWS_AS(build_dag(voxels, {}, progress), Cancelled);
}

TEST_CASE("a DAG whose arrays do not fit together is refused by the level that is wrong") {
    const Dag dag = built(sphere_voxels(5, {16, 16, 16}, 12));
    const auto broken = [&](const auto& change) {
        Dag changed = dag;
        change(changed);
        return changed;
    };
    CHECK_THROWS_WITH_AS(require_usable(broken([](Dag& d) { d.levels[0].children[3] = 1u << 20; })),
                         "voxel DAG: a child in level 3 is not there", InvalidInput);
    CHECK_THROWS_AS(require_usable(broken([](Dag& d) { d.levels[1].child_masks[0] ^= 1; })), InvalidInput);
    CHECK_THROWS_AS(require_usable(broken([](Dag& d) { d.levels[1].first_children.pop_back(); })), InvalidInput);
    CHECK_THROWS_AS(require_usable(broken([](Dag& d) { d.levels[0].tags.assign(1, 1); })), InvalidInput);
    CHECK_THROWS_AS(require_usable(broken([](Dag& d) { d.levels.pop_back(); })), InvalidInput);
    CHECK_THROWS_AS(require_usable(broken([](Dag& d) { d.leaves[0] = 0; })), InvalidInput);
    CHECK_THROWS_AS(require_usable(broken([](Dag& d) { d.root_tag = 1; })), InvalidInput);
}
} // namespace build_dag_test
