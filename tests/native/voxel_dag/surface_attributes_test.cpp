// SPDX-License-Identifier: GPL-3.0-or-later
// What voxels of a surface carry: closed forms, the same bytes however they are made, and errors that name the culprit.
#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "image/srgb.hpp"
#include "native/voxel_dag/step_meshes.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include "voxel_dag/surface_attributes.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace surface_attributes_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::voxel_dag::oracle;
using enum VoxelizeRule;

namespace {
struct Colored {
    LeafMasks leaves;
    VoxelAttributes attributes;

    /// The number of a voxel that is set.
    [[nodiscard]] std::size_t number(const Voxel& voxel) const {
        REQUIRE(leaves.contains(voxel));
        const std::uint64_t code = morton_code(voxel);
        std::size_t number = 0, brick = 0;
        for (; leaves.codes[brick] != code >> 6; ++brick)
            number += static_cast<std::size_t>(std::popcount(leaves.masks[brick]));
        return number +
               static_cast<std::size_t>(std::popcount(leaves.masks[brick] & ((std::uint64_t{1} << (code & 63)) - 1)));
    }
    [[nodiscard]] std::uint32_t red(const Voxel& voxel) const { return attributes.colors[number(voxel)] & 255; }
    [[nodiscard]] dvec3 normal(const Voxel& voxel) const {
        return octahedral::decode(attributes.normals[number(voxel)], octahedral::most_bits);
    }
    template <typename Use>
    void for_voxels(const Use& use) const {
        std::size_t index = 0;
        for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick)
            for (std::uint64_t left = leaves.masks[brick]; left != 0; left &= left - 1)
                use(index++, voxel_at(leaves.codes[brick] << 6 | static_cast<std::uint64_t>(std::countr_zero(left))));
    }
};

Colored colored(const Mesh& mesh, const VoxelizeConfig& config, const Surface& surface) {
    Colored result;
    const std::span<const dvec3> positions(mesh.positions);
    result.leaves = voxelize(positions, mesh.triangles, config, Progress()).leaves;
    result.attributes = surface_attributes(positions, mesh.triangles, config, result.leaves, surface, Progress());
    return result;
}
Colored colored(const Mesh& mesh, std::uint32_t level, VoxelizeRule rule, const Surface& surface) {
    return colored(mesh, config_of(level, rule), surface);
}

/// Two triangles: corner, corner + a, corner + a + b, corner + b, in voxels.
Mesh quad(const dvec3& corner, const dvec3& a, const dvec3& b) {
    return {.positions = {corner, corner + a, corner + a + b, corner + b}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
}
Mesh together(Mesh mesh, const Mesh& other) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (const uvec3& triangle : other.triangles)
        mesh.triangles.push_back(triangle + first);
    return mesh;
}
/// A ball of 20 * 4^divisions triangles, counter-clockwise from outside.
Mesh ball(const dvec3& centre, double radius, int divisions) {
    Mesh mesh{.positions = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
              .triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}}};
    for (int division = 0; division < divisions; ++division) {
        std::vector<uvec3> finer;
        for (const uvec3& t : mesh.triangles) {
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            for (const auto& [a, b] : {std::pair(t.x, t.y), std::pair(t.y, t.z), std::pair(t.z, t.x)})
                mesh.positions.push_back(glm::normalize(mesh.positions[a] + mesh.positions[b]));
            finer.insert(finer.end(), {uvec3(t.x, first, first + 2), uvec3(first, t.y, first + 1),
                                       uvec3(first + 2, first + 1, t.z), uvec3(first, first + 1, first + 2)});
        }
        mesh.triangles = finer;
    }
    for (dvec3& position : mesh.positions)
        position = centre + radius * position;
    return mesh;
}
std::vector<vec3> random_directions(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<vec3> values;
    for (std::size_t i = 0; i < count; ++i) {
        const auto one = [&] { return static_cast<float>(random_below(random, 2001) - 1000) / 1000.0f; };
        values.emplace_back(one(), one(), one());
    }
    return values;
}
double degrees_between(const dvec3& a, const dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180.0 / std::numbers::pi;
}
} // namespace

TEST_CASE("a surface of one colour gives that colour, each of the 256 bytes of it, to every voxel") {
    const Mesh mesh =
        mesh_of(tetrahedron({Point{300, 500, 700}, {15000, 2000, 900}, {3000, 14000, 4000}, {900, 900, 15500}}));
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
        const std::vector<vec3> colors(mesh.positions.size(), vec3(static_cast<float>(byte) / 255.0f));
        const Colored result = colored(mesh, 6, byte % 2 == 0 ? Thin : Conservative, {.colors = colors});
        REQUIRE(result.attributes.colors == std::vector<std::uint32_t>(result.leaves.voxel_count(), byte * 0x010101u));
    }
}

TEST_CASE("colours are interpolated as light, at the voxels' centres") {
    // From black to white along x, over 128 voxels, and as dark along y in green and blue.
    const Mesh mesh = quad({0, 0, 20.5}, {128, 0, 0}, {0, 128, 0});
    const std::vector<vec3> colors{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const Colored result = colored(mesh, 7, Thin, {.colors = colors});
    CHECK(result.leaves.voxel_count() == 128 * 128);
    result.for_voxels([&](std::size_t index, const Voxel& voxel) {
        const auto byte = [](double light) {
            return static_cast<std::uint32_t>(std::lround(255.0f * srgb_from_linear(static_cast<float>(light))));
        };
        REQUIRE(result.attributes.colors[index] == (byte((voxel[0] + 0.5) / 128) | byte((voxel[1] + 0.5) / 128) << 8));
    });
}

// Seen to fail with weights of one for each triangle.
TEST_CASE("what shares a voxel counts by its area: a quarter white, three quarters black") {
    const Mesh mesh =
        together(quad({-4, -4, 20.5}, {14.25, 0, 0}, {0, 60, 0}), quad({10.25, -4, 20.5}, {60, 0, 0}, {0, 60, 0}));
    std::vector<vec3> colors(8, vec3(1));
    std::fill(colors.begin() + 4, colors.end(), vec3(0));
    const Colored result = colored(mesh, 5, Conservative, {.colors = colors});
    CHECK(result.red({9, 10, 20}) == 255);
    CHECK(result.red({11, 10, 20}) == 0);
    CHECK(result.red({10, 10, 20}) == std::lround(255.0f * srgb_from_linear(0.25f)));
}

TEST_CASE("a plane on the border of two layers colours the upper one, and a wall of two sides has both colours") {
    const Mesh mesh =
        together(quad({-4, -4, 20}, {60, 0, 0}, {0, 60, 0}), quad({-4, -4, 20.5}, {60, 0, 0}, {0, 60, 0}));
    std::vector<vec3> colors(8, vec3(1));
    std::fill(colors.begin() + 4, colors.end(), vec3(0));
    const Colored result = colored(mesh, 5, Conservative, {.colors = colors});
    CHECK(result.leaves.voxel_count() == 32 * 32);
    CHECK(result.red({10, 10, 20}) == std::lround(255.0f * srgb_from_linear(0.5f)));
}

TEST_CASE("normals of a ball are radial: those of vertices to a degree, those of faces to the faces' turn") {
    const dvec3 centre(64, 64, 64);
    const Mesh mesh = ball(centre, 50, 5);
    std::vector<vec3> normals;
    for (const dvec3& position : mesh.positions)
        normals.emplace_back(3.0 * (position - centre)); // of any length
    for (const VoxelizeRule rule : {Thin, Conservative})
        for (const SurfaceNormals kind : {SurfaceNormals::Vertices, SurfaceNormals::Faces}) {
            const Colored result = colored(mesh, 7, rule, {.normals = kind, .vertex_normals = normals});
            double most = 0;
            result.for_voxels([&](std::size_t index, const Voxel& voxel) {
                const dvec3 radial = dvec3(voxel[0], voxel[1], voxel[2]) + 0.5 - centre;
                most =
                    std::max(most, degrees_between(radial, octahedral::decode(result.attributes.normals[index], 32)));
            });
            CHECK(most <
                  (kind == SurfaceNormals::Vertices ? 1.0 : 3.0)); // a voxel is a degree, a triangle's radius two
        }
}

TEST_CASE("walls of a box have the very axes, its edges the mean of the walls that meet there") {
    Mesh mesh = mesh_of(
        box({10 * 256 + 100, 10 * 256 + 100, 10 * 256 + 100}, {40 * 256 + 100, 40 * 256 + 100, 40 * 256 + 100}));
    for (uvec3& t : mesh.triangles) { // outwards
        const dvec3 &a = mesh.positions[t.x], n = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
        if (glm::dot(n, a - dvec3(25)) < 0)
            std::swap(t.y, t.z);
    }
    const Colored result = colored(mesh, 6, Conservative, {.normals = SurfaceNormals::Faces});
    CHECK(result.normal({40, 20, 20}) == dvec3(1, 0, 0));
    CHECK(result.normal({10, 20, 20}) == dvec3(-1, 0, 0));
    CHECK(result.normal({20, 40, 20}) == dvec3(0, 1, 0));
    CHECK(result.normal({20, 20, 10}) == dvec3(0, 0, -1));
    const dvec3 edge = result.normal({40, 40, 20});
    CHECK(std::abs(edge.x - edge.y) < 1e-3);
    CHECK(std::abs(edge.z) < 1e-3);
}

TEST_CASE("both sides of a thin wall in a voxel: one of them is taken, the larger if there is one") {
    // Facing up at 20.5, and down at 20.4.
    const Mesh up = quad({-4, -4, 20.5}, {60, 0, 0}, {0, 60, 0}), down = quad({-4, -4, 20.4}, {0, 60, 0}, {60, 0, 0});
    const Colored wall = colored(together(up, down), 5, Thin, {.normals = SurfaceNormals::Faces});
    wall.for_voxels([&](std::size_t index, const Voxel&) {
        const dvec3 normal = octahedral::decode(wall.attributes.normals[index], 32);
        REQUIRE(std::abs(normal.z) == 1);
    });
    // The same upside down, and in the other order, is the same.
    CHECK(colored(together(down, up), 5, Thin, {.normals = SurfaceNormals::Faces}).attributes == wall.attributes);
    // A lid over a quarter of each voxel in the row x = 10 is outvoted from either side.
    const Mesh lid = quad({10, -4, 20.4}, {0, 60, 0}, {0.75, 0, 0});
    CHECK(colored(together(up, lid), 5, Conservative, {.normals = SurfaceNormals::Faces}).normal({10, 9, 20}).z == 1);
}

TEST_CASE("colours and channels follow the surface: within what a voxel spans, on a ball and on slivers") {
    Mesh mesh = ball({64, 64, 64}, 50, 4);
    for (std::size_t i = 0; i < 200; ++i) // slivers and lines that hang together with nothing
        mesh.triangles.push_back(uvec3(i, i + 1, i + 1 + i % 2));
    std::vector<vec3> colors;
    std::vector<float> heights;
    for (const dvec3& position : mesh.positions) {
        const vec3 light = vec3(position) / 128.0f;
        colors.emplace_back(srgb_from_linear(light.x), srgb_from_linear(light.y), srgb_from_linear(light.z));
        heights.push_back(light.z);
    }
    for (const VoxelizeRule rule : {Thin, Conservative}) {
        const Colored result = colored(mesh, 7, rule, {.colors = colors, .channels = {{"height", heights}}});
        REQUIRE(result.attributes.channels.size() == 1);
        CHECK(result.attributes.channels[0].name == "height");
        double most = 0; // in voxels, between a voxel's centre and the place that its colour tells
        result.for_voxels([&](std::size_t index, const Voxel& voxel) {
            const auto light = [&](std::size_t axis) {
                return linear_from_srgb(static_cast<float>(result.attributes.colors[index] >> 8 * axis & 255) / 255.0f);
            };
            for (std::size_t axis = 0; axis < 3; ++axis)
                most = std::max(most, std::abs(voxel[axis] + 0.5 - 128.0 * light(axis)));
            most = std::max(most, std::abs(voxel[2] + 0.5 - 128.0 * result.attributes.channels[0].values[index] / 255));
        });
        CHECK(most < 1.5); // the surface is up to 0.87 voxels from a centre, and half a byte of bright light is 0.57
    }
}

TEST_CASE("triangles far larger than the cube colour it as a part of them would") {
    const Mesh wide{.positions = {{-3e6, -2e6, 20.5}, {3e6, -2e6, 20.5}, {0, 4e6, 20.5}}, .triangles = {{0, 1, 2}}};
    const std::vector<vec3> colors{vec3(0.2f), vec3(0.2f), vec3(0.9f)};
    const Colored result = colored(wide, 6, Thin, {.colors = colors, .normals = SurfaceNormals::Faces});
    const float light = std::lerp(linear_from_srgb(0.2f), linear_from_srgb(0.9f), 1.0f / 3.0f);
    CHECK(result.leaves.voxel_count() == 64 * 64);
    for (const Voxel& voxel : {Voxel{0, 0, 20}, {63, 5, 20}, {31, 63, 20}}) {
        CHECK(result.red(voxel) == std::lround(255.0f * srgb_from_linear(light)));
        CHECK(result.normal(voxel) == dvec3(0, 0, 1));
    }
}

// Seen to fail with samples that are computed in the order of the scan's axes, which other triangles have a say in.
TEST_CASE("neither threads, nor vectors, nor the order of triangles change a bit") {
    std::mt19937 random(4);
    std::vector<Triangle> triangles;
    for (int i = 0; i < 3000; ++i)
        triangles.push_back(random_triangle(random, 8, i % 50 == 0 ? 200 : 6, 2, i % 3 == 0 ? 128 : 1));
    Mesh mesh = mesh_of(triangles);
    std::vector<vec3> normals = random_directions(mesh.positions.size(), 5), colors = normals;
    std::vector<float> values;
    for (vec3& color : colors) {
        color = glm::abs(color);
        values.push_back(color.x);
    }
    normals[17] = vec3(0);
    for (const VoxelizeRule rule : {Thin, Conservative}) {
        const Surface surface{.colors = colors,
                              .normals = SurfaceNormals::Vertices,
                              .vertex_normals = normals,
                              .channels = {{"a", values}, {"b", values}}};
        const Colored first = colored(mesh, 8, rule, surface);
        CHECK(first.leaves.voxel_count() > 100000);
        for (const int threads : {1, 2, 7})
            CHECK(with_threads(threads, [&] { return colored(mesh, 8, rule, surface); }).attributes ==
                  first.attributes);
        for (const SimdTarget target : available_simd_targets()) {
            const ForcedSimdTarget forced(target);
            CAPTURE(simd_target_name());
            CHECK(colored(mesh, 8, rule, surface).attributes == first.attributes);
        }
        Mesh shuffled = mesh;
        std::ranges::shuffle(shuffled.triangles, random);
        CHECK(colored(shuffled, 8, rule, surface).attributes == first.attributes);
    }
}

TEST_CASE("a closer look at one voxel: mean of exact areas of many small triangles, to a part in fifty") {
    // A tilted plane cut into triangles far smaller than a voxel; white where x < 20.3, black beyond.
    Mesh mesh;
    std::vector<vec3> colors;
    const int count = 300;
    const auto vertex = [&](int i, int j) { return dvec3(18 + i * 0.02, 18 + j * 0.02, 20.2 + i * 0.004); };
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) {
            const Mesh cell = quad(vertex(i, j), vertex(i + 1, j) - vertex(i, j), vertex(i, j + 1) - vertex(i, j));
            mesh = together(std::move(mesh), cell);
            colors.insert(colors.end(), 4, vec3(i < 115 ? 1.0f : 0.0f));
        }
    const Colored result = colored(mesh, 5, Conservative, {.colors = colors});
    const float light = linear_from_srgb(static_cast<float>(result.red({20, 20, 20})) / 255.0f);
    CHECK(std::abs(light - 0.3f) < 0.02f);
}

TEST_CASE("what is wrong with a surface is refused, and the culprit named") {
    const Mesh mesh = quad({0, 0, 2.5}, {8, 0, 0}, {0, 8, 0});
    const auto run = [&](const Surface& surface) { return colored(mesh, 3, Thin, surface); };
    std::vector<vec3> four(4, vec3(0.5f));
    const std::vector<vec3> three(3, vec3(0.5f));
    CHECK_THROWS_WITH_AS(run({.colors = three}), "colors: 3 for 4 vertices", InvalidInput);
    CHECK_THROWS_WITH_AS(run({.normals = SurfaceNormals::Vertices, .vertex_normals = three}),
                         "normals: 3 for 4 vertices", InvalidInput);
    four[2].y = 1.5f;
    CHECK_THROWS_WITH_AS(run({.colors = four}), "colors: vertex 2 has (0.5, 1.5, 0.5), outside [0, 1]", InvalidInput);
    four[2].y = NAN;
    CHECK_THROWS_AS(run({.colors = four}), InvalidInput);
    CHECK_THROWS_WITH_AS(run({.normals = SurfaceNormals::Vertices, .vertex_normals = four}),
                         "normals: vertex 2 has (0.5, nan, 0.5)", InvalidInput);
    const std::vector<float> values{0, 1, 2, 0};
    CHECK_THROWS_WITH_AS(run({.channels = {{"roughness", values}}}),
                         "channel \"roughness\": vertex 2 has 2, outside [0, 1]", InvalidInput);
    const std::vector<float> fine(4), few(2);
    CHECK_THROWS_WITH_AS(run({.channels = {{"a", few}}}), "channel \"a\": 2 values for 4 vertices", InvalidInput);
    CHECK_THROWS_WITH_AS(run({.channels = {{"a", fine}, {"a", fine}}}), "channel \"a\" is there twice", InvalidInput);
    CHECK_THROWS_WITH_AS(run({.channels = {{"a", fine}, {"b", fine}, {"c", fine}, {"d", fine}, {"e", fine}}}),
                         "there are 5 channels; at most 4 are possible", InvalidInput);

    VoxelizeConfig config = config_of(3, Thin);
    config.memory_budget_bytes = 300; // four bricks are 64 bytes, 64 colours 256
    four.assign(4, vec3(1));
    CHECK_THROWS_WITH_AS(
        colored(mesh, config, {.colors = four}),
        "voxels and their attributes are 0 MiB, beyond the budget of 0 MiB: 64 voxels of 4 bytes each, "
        "and 0 MiB that say where they are",
        InvalidInput);
    const LeafMasks more = leaf_masks_of({{1, 1, 2}, {1, 1, 6}}, 3);
    CHECK_THROWS_WITH_AS(surface_attributes(std::span<const dvec3>(mesh.positions), mesh.triangles, config_of(3, Thin),
                                            more, {.colors = four}, Progress()),
                         "voxel (1, 1, 6) is set, but by no triangle of the mesh: it has no attributes", InvalidInput);
}
} // namespace surface_attributes_test
