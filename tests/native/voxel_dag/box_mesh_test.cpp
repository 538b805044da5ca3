// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/box_mesh.hpp"
#include "voxel_dag/open_faces.hpp"
#include <doctest/doctest.h>
#include <map>
#include <set>

namespace box_mesh_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

namespace {
const Progress progress;
constexpr std::uint64_t no_limit = ~std::uint64_t{0};

std::vector<LeafMasks> voxel_sets() {
    return {random_voxels(2, 0.5, 1), random_voxels(4, 0.3, 2),
            random_voxels(5, 0.9, 3), random_voxels(6, 0.01, 4),
            full_voxels(4),           sphere_voxels(6, {31, 32, 30}, 25.5),
            sierpinski_voxels(5),     LeafMasks{.level = 5, .codes = {}, .masks = {}}};
}
/// Calls visit(voxel, its number in Morton order).
template <typename Visit>
void for_each_voxel(const LeafMasks& leaves, const Visit& visit) {
    std::uint32_t number = 0;
    for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick)
        for (std::uint64_t bit = 0; bit < 64; ++bit)
            if ((leaves.masks[brick] >> bit & 1) != 0)
                visit(voxel_at(leaves.codes[brick] << 6 | bit), number++);
}
/// Across a face, below 0 and beyond the cube included.
bool is_open(const LeafMasks& leaves, Voxel voxel, std::size_t face) {
    voxel[face / 2] += face % 2 == 1 ? 1u : ~0u;
    return !leaves.contains(voxel);
}
} // namespace

// Seen to fail with the neighbours of y looked up a brick too far.
TEST_CASE("a face is open where asking the voxel beyond it says so") {
    for (const LeafMasks& leaves : voxel_sets())
        for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick) {
            const OpenFaces faces = open_faces(leaves, brick);
            for (std::uint64_t bit = 0; bit < 64; ++bit)
                for (std::size_t face = 0; face < 6; ++face) {
                    const Voxel voxel = voxel_at(leaves.codes[brick] << 6 | bit);
                    const bool is_set = (leaves.masks[brick] >> bit & 1) != 0;
                    REQUIRE((faces[face] >> bit & 1) == (is_set && is_open(leaves, voxel, face)));
                }
        }
}

TEST_CASE("a shell is the voxels that have an open face") {
    for (const LeafMasks& leaves : voxel_sets()) {
        const LeafMasks shell = shell_of(leaves, progress);
        require_usable(shell);
        for_each_voxel(leaves, [&](const Voxel& voxel, std::uint32_t) {
            bool any = false;
            for (std::size_t face = 0; face < 6; ++face)
                any = any || is_open(leaves, voxel, face);
            REQUIRE(shell.contains(voxel) == any);
        });
        CHECK(shell.voxel_count() <= leaves.voxel_count());
    }
}

// Seen to fail where the corners of a lower face go round as those of an upper one.
TEST_CASE("a mesh of boxes is closed, looks outward, and holds as much as there are voxels, exactly") {
    for (const LeafMasks& leaves : voxel_sets()) {
        const BoxMesh mesh = box_mesh_of(leaves, no_limit, progress);
        double sixfold_volume = 0.0;
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance; // of an edge: passes one way less the other
        std::set<std::array<double, 3>> places;
        for (const dvec3& position : mesh.positions)
            places.insert({position.x, position.y, position.z});
        for (const uvec3& triangle : mesh.triangles) {
            const dvec3 &a = mesh.positions[triangle.x], &b = mesh.positions[triangle.y],
                        &c = mesh.positions[triangle.z];
            sixfold_volume += glm::dot(a, glm::cross(b, c)); // whole numbers below 2^53
            CHECK(glm::dot(glm::cross(b - a, c - a), glm::cross(b - a, c - a)) == 1.0);
            for (int corner = 0; corner < 3; ++corner) {
                const std::uint32_t from = triangle[corner], to = triangle[(corner + 1) % 3];
                balance[std::minmax(from, to)] += from < to ? 1 : -1;
            }
        }
        CHECK(sixfold_volume == 6.0 * static_cast<double>(leaves.voxel_count()));
        CHECK(places.size() == mesh.positions.size());
        for (const auto& [edge, count] : balance)
            REQUIRE(count == 0);

        std::size_t square = 0;
        for_each_voxel(leaves, [&](const Voxel& voxel, std::uint32_t number) {
            for (std::size_t face = 0; face < 6; ++face)
                if (is_open(leaves, voxel, face)) {
                    REQUIRE(mesh.voxel_numbers.at(square) == number);
                    dvec3 middle(0.0);
                    for (const int corner : {0, 1, 2})
                        for (const std::size_t half : {2 * square, 2 * square + 1})
                            middle += mesh.positions[mesh.triangles.at(half)[corner]] / 6.0;
                    for (int axis = 0; axis < 3; ++axis)
                        REQUIRE(std::abs(middle[axis] - voxel[static_cast<std::size_t>(axis)] - 0.5) < 0.51);
                    ++square;
                }
        });
        CHECK(square == mesh.voxel_numbers.size());
        CHECK(2 * square == mesh.triangles.size());
    }
}

TEST_CASE("a mesh that is too large is refused with its size before it is made, and a cancelled call stops") {
    const LeafMasks leaves = full_voxels(6);
    CHECK_THROWS_WITH_AS(static_cast<void>(box_mesh_of(leaves, 1 << 20, progress)),
                         "a mesh of these voxels has 24576 squares, and takes some 1867776 bytes: more than the memory "
                         "budget, 1048576: choose a coarser level, or raise the budget",
                         InvalidInput);
    Progress cancelled;
    cancelled.cancel();
    CHECK_THROWS_AS(static_cast<void>(box_mesh_of(leaves, no_limit, cancelled)), Cancelled);
    CHECK_THROWS_AS(static_cast<void>(shell_of(leaves, cancelled)), Cancelled);
}
} // namespace box_mesh_test
