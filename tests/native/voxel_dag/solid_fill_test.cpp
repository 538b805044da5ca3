// SPDX-License-Identifier: GPL-3.0-or-later
// Solids: closed forms, a brute force of exact crossings, and meshes without an inside.
#include "core/parallel.hpp"
#include "native/voxel_dag/step_meshes.hpp"
#include "voxel_dag/closed_mesh.hpp"
#include "voxel_dag/solid_fill.hpp"
#include "voxel_dag/wide_integer.hpp"
#include <algorithm>
#include <bit>
#include <doctest/doctest.h>
#include <numbers>

namespace solid_fill_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::voxel_dag::oracle;
using enum VoxelizeRule;

namespace {
struct Solid {
    LeafMasks surface, all;
};
Solid solid_of(const Mesh& mesh, const VoxelizeConfig& config) {
    const std::span<const dvec3> positions(mesh.positions);
    Solid solid{.surface = voxelize(positions, mesh.triangles, config, Progress()).leaves, .all = {}};
    solid.all = solid_fill(positions, mesh.triangles, config, solid.surface, Progress());
    return solid;
}
/// Counter-clockwise as seen from outside, of something that is convex.
std::vector<Triangle> outwards(std::vector<Triangle> triangles) {
    Point centre{};
    for (const Triangle& t : triangles)
        for (const Point& corner : t)
            for (std::size_t axis = 0; axis < 3; ++axis)
                centre[axis] += corner[axis];
    const auto count = static_cast<std::int64_t>(3 * triangles.size());
    for (Triangle& t : triangles) {
        double side = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
            const auto along = [&](std::size_t corner, std::size_t of) {
                return static_cast<double>(t[corner][of] - t[0][of]);
            };
            const double normal = along(1, b) * along(2, c) - along(1, c) * along(2, b);
            side += normal * static_cast<double>(count * t[0][axis] - centre[axis]);
        }
        if (side < 0)
            std::swap(t[1], t[2]);
    }
    return triangles;
}
std::vector<Triangle> together(std::vector<Triangle> a, const std::vector<Triangle>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}
std::vector<Triangle> turned_over(std::vector<Triangle> triangles) {
    for (Triangle& t : triangles)
        std::swap(t[1], t[2]);
    return triangles;
}
std::vector<Triangle> voxel_box(const Point& lower, const Point& upper, std::int64_t steps = 0) {
    Point from, to;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        from[axis] = lower[axis] * steps_per_voxel + steps;
        to[axis] = upper[axis] * steps_per_voxel + steps;
    }
    return outwards(box(from, to));
}
/// Corners lie `grid` steps apart, among them centres of voxels.
std::vector<Triangle> random_tetrahedron(std::mt19937& random, std::int64_t side, std::int64_t beyond,
                                         std::int64_t grid) {
    std::array<Point, 4> corners;
    for (Point& corner : corners)
        for (std::int64_t& at : corner)
            at = (random_below(random, (side + 2 * beyond) * steps_per_voxel / grid)) * grid + 128 -
                 beyond * steps_per_voxel;
    return outwards(tetrahedron(corners));
}

/// Sign of the volume of a, b, c, p; where it is 0, that of p moved by -(e, e^2, e^3).
int side_of(const Triangle& t, const Point& p) {
    std::array<Int128, 3> normal;
    Int128 volume = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
        normal[axis] =
            Int128{t[1][b] - t[0][b]} * (t[2][c] - t[0][c]) - Int128{t[1][c] - t[0][c]} * (t[2][b] - t[0][b]);
        volume += normal[axis] * (p[axis] - t[0][axis]);
    }
    if (volume != 0)
        return volume > 0 ? 1 : -1;
    for (const Int128 component : normal)
        if (component != 0)
            return component > 0 ? -1 : 1;
    return 0;
}
/// Of convex things: whether the moved centre is behind all faces of one of them.
bool is_within(const std::vector<std::vector<Triangle>>& parts, const Point& centre) {
    return std::ranges::any_of(parts, [&](const std::vector<Triangle>& part) {
        return std::ranges::all_of(part, [&](const Triangle& t) { return side_of(t, centre) < 0; });
    });
}
Mesh octahedral_ball(const dvec3& centre, double radius, int divisions) {
    std::vector<std::array<dvec3, 3>> faces;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0}) {
                const dvec3 a(x, 0, 0), b(0, y, 0), c(0, 0, z);
                faces.push_back(x * y * z > 0 ? std::array{a, b, c} : std::array{a, c, b});
            }
    for (int division = 0; division < divisions; ++division) {
        std::vector<std::array<dvec3, 3>> finer;
        for (const auto& [a, b, c] : faces) {
            const dvec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c), ca = glm::normalize(c + a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    Mesh mesh;
    for (const auto& face : faces) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const dvec3& corner : face)
            mesh.positions.push_back(centre + radius * corner);
        mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
    return mesh;
}
} // namespace

TEST_CASE("a cube is solid: all its voxels, and no other") {
    for (const VoxelizeRule rule : {Thin, Conservative}) {
        const Solid aligned = solid_of(mesh_of(voxel_box({5, 6, 7}, {105, 76, 97}, 100)), config_of(7, rule));
        CHECK(aligned.all.voxel_count() == 101 * 71 * 91); // the surface's voxels are within
        CHECK(aligned.all.contains({5, 6, 7}));
        CHECK(aligned.all.contains({105, 76, 97}));
        CHECK_FALSE(aligned.all.contains({4, 30, 30}));
        const Solid whole = solid_of(mesh_of(voxel_box({0, 0, 0}, {128, 128, 128})), config_of(7, rule));
        CHECK(whole.all.voxel_count() == 128 * 128 * 128);
        CHECK(std::ranges::count(whole.all.masks, ~std::uint64_t{0}) == 32 * 32 * 32);
        const Solid beyond = solid_of(mesh_of(voxel_box({-70, -1, -300}, {20, 500, 1})), config_of(5, rule));
        CHECK(beyond.all.contains({0, 31, 0}));
        CHECK(beyond.all.contains({19, 7, 0}));
        CHECK(beyond.all.voxel_count() == 21 * 32 * 2); // surfaces at x = 20 and z = 1 belong to the upper voxels
    }
    const Solid small = solid_of(mesh_of(voxel_box({0, 0, 0}, {4, 4, 4})), config_of(2, Thin));
    CHECK(small.all.voxel_count() == 64);
}

// Seen to fail with edges that belong to both of their triangles.
TEST_CASE("exactly the voxels of the surface, and those whose centres lie within: tetrahedra that may overlap") {
    std::mt19937 random(12);
    std::uint64_t inside_count = 0;
    for (int round = 0; round < 40; ++round) {
        std::vector<std::vector<Triangle>> parts;
        std::vector<Triangle> triangles;
        for (int part = 0; part < 1 + round % 3; ++part) {
            parts.push_back(random_tetrahedron(random, 32, round % 4 == 0 ? 40 : 0, round % 3 == 0 ? 1 : 1024));
            triangles = together(triangles, parts.back());
        }
        const Solid solid = solid_of(mesh_of(triangles), config_of(5, round % 2 == 0 ? Thin : Conservative));
        for (std::uint32_t z = 0; z < 32; ++z)
            for (std::uint32_t y = 0; y < 32; ++y)
                for (std::uint32_t x = 0; x < 32; ++x) {
                    const Point centre{x * 256 + 128, y * 256 + 128, z * 256 + 128};
                    const bool is_inside = is_within(parts, centre);
                    inside_count += is_inside;
                    CAPTURE(round);
                    REQUIRE(solid.all.contains({x, y, z}) == (is_inside || solid.surface.contains({x, y, z})));
                }
        require_usable(solid.all);
    }
    CHECK(inside_count > 30000);
}

TEST_CASE("a hollow stays empty, and what overlaps is filled once") {
    const std::vector<Triangle> outer = voxel_box({2, 2, 2}, {60, 60, 60}),
                                inner = voxel_box({20, 20, 20}, {40, 40, 40});
    const Solid hollow = solid_of(mesh_of(together(outer, turned_over(inner))), config_of(6, Thin));
    CHECK_FALSE(hollow.all.contains({30, 30, 30}));
    CHECK(hollow.all.voxel_count() == 59 * 59 * 59 - 19 * 19 * 19);
    const Solid within = solid_of(mesh_of(together(outer, inner)), config_of(6, Thin));
    CHECK(within.all.voxel_count() == 59 * 59 * 59);
}

TEST_CASE("a ball has its volume and half of its surface's voxels, ever more exactly") {
    for (const std::uint32_t level : {5u, 6u, 7u, 8u}) {
        const double side = std::exp2(level), radius = 0.45 * side;
        const Mesh mesh = octahedral_ball(dvec3(0.5 * side) + dvec3(0.11, 0.23, 0.37), radius, 5);
        double volume = 0; // of the faces, not of the ball
        for (const uvec3& t : mesh.triangles)
            volume += glm::dot(mesh.positions[t.x], glm::cross(mesh.positions[t.y], mesh.positions[t.z])) / 6;
        const Solid solid = solid_of(mesh, config_of(level, Thin));
        const auto surface = static_cast<double>(solid.surface.voxel_count());
        const double error = std::abs(static_cast<double>(solid.all.voxel_count()) - volume - 0.5 * surface) / surface;
        CHECK(error * side < 1.2); // as the curvature does, per voxel
        for (std::size_t brick = 0; brick < solid.surface.codes.size(); ++brick) {
            const auto at = std::ranges::lower_bound(solid.all.codes, solid.surface.codes[brick]);
            REQUIRE((at != solid.all.codes.end() && *at == solid.surface.codes[brick]));
            REQUIRE((solid.surface.masks[brick] &
                     ~solid.all.masks[static_cast<std::size_t>(at - solid.all.codes.begin())]) == 0);
        }
    }
}

TEST_CASE("neither the order of triangles nor threads change a solid") {
    std::mt19937 random(3);
    std::vector<Triangle> triangles;
    for (int i = 0; i < 30; ++i)
        triangles = together(triangles, random_tetrahedron(random, 128, 30, 64));
    const Mesh mesh = mesh_of(triangles);
    const LeafMasks first = solid_of(mesh, config_of(7, Thin)).all;
    for (const int threads : {1, 2, 7})
        CHECK(with_threads(threads, [&] { return solid_of(mesh, config_of(7, Thin)).all; }) == first);
    std::ranges::shuffle(triangles, random);
    CHECK(solid_of(mesh_of(triangles), config_of(7, Thin)).all == first);
    CHECK(solid_of(mesh_of(turned_over(triangles)), config_of(7, Thin)).all == first);
}

TEST_CASE("triangles far larger than 64 bits can multiply cut the same solid") {
    const std::int64_t far = std::int64_t{1} << 30;
    const std::array<Point, 4> corners{
        Point{-far * 256, -far * 256, 5000}, {far * 256, -far * 256, 5000}, {0, far * 256, 5000}, {3, 7, -far * 256}};
    const Solid solid = solid_of(mesh_of(outwards(tetrahedron(corners))), config_of(5, Thin));
    CHECK(solid.all.voxel_count() == 32 * 32 * 20); // z up to 19.53
}

TEST_CASE("a mesh that does not close is refused, with an edge; so is what the budget does not hold") {
    std::vector<Triangle> triangles = voxel_box({2, 2, 2}, {12, 12, 12});
    triangles.erase(triangles.begin() + 4);
    CHECK_THROWS_WITH_AS(solid_of(mesh_of(triangles), config_of(4, Thin)),
                         doctest::Contains("the mesh does not close, so that it has no inside to fill: at the edge of "
                                           "triangle "),
                         InvalidInput);
    triangles = voxel_box({2, 2, 2}, {12, 12, 12});
    std::swap(triangles[7][0], triangles[7][1]);
    CHECK_THROWS_AS(solid_of(mesh_of(triangles), config_of(4, Thin)), InvalidInput);
    const Mesh mesh = mesh_of(voxel_box({0, 0, 0}, {1024, 1024, 1024}));
    VoxelizeConfig config = config_of(10, Thin);
    config.memory_budget_bytes = 40 << 20; // the surface's bricks are 6 MiB, all of them 268
    CHECK_THROWS_WITH_AS(solid_of(mesh, config), doctest::Contains("a resolution of 512 may fit"), InvalidInput);
}
} // namespace solid_fill_test
