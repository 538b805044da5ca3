// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh fills of boxes: closed forms, a brute force of places, and what is refused.
#include "native/voxel_dag/step_meshes.hpp"
#include "support/close_to.hpp"
#include "voxel_dag/filled_shares.hpp"
#include <algorithm>
#include <doctest/doctest.h>

namespace filled_shares_test {
using namespace tyndall;
using tyndall::support::close_to;
using namespace tyndall::voxel_dag;
using namespace tyndall::voxel_dag::oracle;

namespace {
struct Solid {
    std::vector<vec3> positions;
    std::vector<uvec3> triangles;

    void add_box(const dvec3& lower, const dvec3& upper, bool is_turned_over = false) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (int corner = 0; corner < 8; ++corner)
            positions.emplace_back((corner & 1) != 0 ? upper.x : lower.x, (corner & 2) != 0 ? upper.y : lower.y,
                                   (corner & 4) != 0 ? upper.z : lower.z);
        for (const auto& [a, b, c, d] : {std::array{0u, 4u, 6u, 2u},
                                         {1u, 3u, 7u, 5u},
                                         {0u, 1u, 5u, 4u},
                                         {2u, 6u, 7u, 3u},
                                         {0u, 2u, 3u, 1u},
                                         {4u, 5u, 7u, 6u}})
            for (uvec3 triangle : {uvec3(a, b, c), uvec3(a, c, d)}) {
                if (is_turned_over)
                    std::swap(triangle.y, triangle.z);
                triangles.push_back(triangle + first);
            }
    }
    [[nodiscard]] std::vector<float> in(const BoxLattice& lattice) const {
        return filled_shares(positions, triangles, lattice, Progress());
    }
};
float overlap(double lower, double upper, double box, double step) {
    return static_cast<float>(std::max(0.0, std::min(upper, box + step) - std::max(lower, box)) / step);
}
std::size_t index_of(const BoxLattice& lattice, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return (std::size_t{x} * lattice.counts.y + y) * lattice.counts.z + z;
}
template <typename Use>
void for_each_box(const BoxLattice& lattice, const Use& use) {
    for (std::uint32_t x = 0; x < lattice.counts.x; ++x)
        for (std::uint32_t y = 0; y < lattice.counts.y; ++y)
            for (std::uint32_t z = 0; z < lattice.counts.z; ++z)
                use(x, y, z);
}
} // namespace

// Seen to fail with sides of the wrong axis, and with columns of one tile alone.
TEST_CASE("a block fills of each box what lies in both, whichever side of the lattice is the longest") {
    for (const uvec3& counts : {uvec3(70, 9, 20), uvec3(9, 70, 20), uvec3(20, 9, 70), uvec3(1, 1, 1)}) {
        const BoxLattice lattice{.lower_m = {-1.0, 2.0, 0.5}, .step_m = {0.25, 0.5, 0.125}, .counts = counts};
        // Faces lie at quarters of boxes: places of columns are as far apart.
        const dvec3 lower = lattice.lower_m + lattice.step_m * glm::floor(dvec3(counts) * 0.5) / 4.0,
                    upper = lattice.lower_m + lattice.step_m * (dvec3(counts) - 0.25);
        Solid block;
        block.add_box(lower, upper);
        const std::vector<float> shares = block.in(lattice);
        REQUIRE(shares.size() == counts.x * counts.y * counts.z);
        for_each_box(lattice, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
            const dvec3 box = lattice.lower_m + lattice.step_m * dvec3(x, y, z);
            float expected = 1.0f;
            for (int axis = 0; axis < 3; ++axis)
                expected *= overlap(lower[axis], upper[axis], box[axis], lattice.step_m[axis]);
            CAPTURE(x);
            CAPTURE(y);
            CAPTURE(z);
            REQUIRE(shares[index_of(lattice, x, y, z)] == close_to(expected, 1e-5));
        });
    }
}

TEST_CASE("a hollow is empty, whatever lies twice counts once, and what lies beyond the lattice does not") {
    const BoxLattice lattice{.lower_m = dvec3(0.0), .step_m = dvec3(1.0), .counts = uvec3(12)};
    const auto sum = [&](const Solid& solid) {
        double filled = 0.0;
        for (const float share : solid.in(lattice))
            filled += double{share};
        return filled;
    };
    Solid hollow;
    hollow.add_box(dvec3(1.0), dvec3(9.0));
    hollow.add_box(dvec3(2.0), dvec3(5.5), true);
    CHECK(sum(hollow) == close_to(512.0 - 3.5 * 3.5 * 3.5, 1e-5));
    Solid twice;
    twice.add_box(dvec3(1.0), dvec3(9.0));
    twice.add_box(dvec3(2.0), dvec3(5.5));
    CHECK(sum(twice) == close_to(512.0, 1e-5));
    Solid turned;
    turned.add_box(dvec3(1.0), dvec3(9.0), true);
    CHECK(sum(turned) == close_to(512.0, 1e-5));
    Solid beyond;
    beyond.add_box(dvec3(-40.0, 3.0, 3.0), dvec3(2.0, 30.0, 4.0));
    CHECK(sum(beyond) == close_to(2.0 * 9.0, 1e-5));
}

TEST_CASE("tetrahedra: as many places of each box as a brute force finds within") {
    std::mt19937 random(7);
    for (int round = 0; round < 6; ++round) {
        const BoxLattice lattice{.lower_m = {0.3, -2.0, 5.0}, .step_m = {0.5, 0.75, 1.25}, .counts = {17, 7, 6}};
        const dvec3 size = lattice.step_m * dvec3(lattice.counts);
        std::array<dvec3, 4> corners;
        Solid solid;
        for (dvec3& corner : corners) {
            for (int axis = 0; axis < 3; ++axis)
                corner[axis] =
                    lattice.lower_m[axis] + size[axis] * static_cast<double>(random_below(random, 4096) - 256) / 3584.0;
            solid.positions.emplace_back(corner);
            corner = dvec3(solid.positions.back());
        }
        const double volume =
            glm::dot(corners[3] - corners[0], glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
        solid.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
        const auto is_within = [&](const dvec3& at) {
            for (const uvec3& t : solid.triangles) {
                const dvec3 a = corners[t.x];
                if (glm::dot(at - a, glm::cross(corners[t.y] - a, corners[t.z] - a)) * volume > 0.0)
                    continue;
                return false;
            }
            return true;
        };
        // A vertex moves by half a 256th of a place: those that lie as near to a face may go either way.
        const std::vector<float> shares = solid.in(lattice);
        double filled = 0.0;
        int different = 0, some = 0;
        for_each_box(lattice, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
            int count = 0;
            for (int a = 0; a < 16; ++a)
                for (int b = 0; b < 4; ++b)
                    for (int c = 0; c < 4; ++c)
                        count += is_within(lattice.lower_m +
                                           lattice.step_m * (dvec3(x, y, z) +
                                                             dvec3((a + 0.5) / 16.0, (b + 0.5) / 4.0, (c + 0.5) / 4.0)))
                                     ? 1
                                     : 0;
            const float share = shares[index_of(lattice, x, y, z)];
            filled += double{share};
            some += count > 0;
            different += share * 256.0f != static_cast<float>(count);
            REQUIRE(std::abs(share * 256.0f - static_cast<float>(count)) <= 3.0f);
        });
        CHECK(some > 10);
        CHECK(different * 8 <= some);
        const double box_m3 = lattice.step_m.x * lattice.step_m.y * lattice.step_m.z;
        CHECK(filled * box_m3 <= std::abs(volume) / 6.0 * 1.02);
    }
}

TEST_CASE("an open mesh, no boxes and boxes without sides are refused by name") {
    Solid block;
    block.add_box(dvec3(0.0), dvec3(1.0));
    CHECK_THROWS_WITH_AS((void)block.in({.counts = {4, 0, 4}}), doctest::Contains("counts: 0"), InvalidInput);
    CHECK_THROWS_WITH_AS((void)block.in({.step_m = {1.0, 0.0, 1.0}}), doctest::Contains("step_m is 0"), InvalidInput);
    block.triangles.pop_back();
    CHECK_THROWS_WITH_AS((void)block.in({.counts = {4, 4, 4}}), doctest::Contains("does not close"), InvalidInput);
    block.positions[0].x = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH_AS((void)block.in({.counts = {4, 4, 4}}), doctest::Contains("vertex 0"), InvalidInput);
}
} // namespace filled_shares_test
