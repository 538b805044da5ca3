// SPDX-License-Identifier: GPL-3.0-or-later
// What voxels carry, in parts: the file is the one that is made at once, byte for byte.
#include "native/voxel_dag/part_jobs.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace out_of_core_attributes_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::voxel_dag::in_parts;
using namespace tyndall::support;

namespace {
/// Of a mesh, all that voxels can carry, and the surface that has some of it.
struct Carried {
    explicit Carried(const oracle::Mesh& mesh) {
        std::mt19937 random(static_cast<std::uint32_t>(mesh.positions.size()));
        const auto share = [&] { return static_cast<float>(oracle::random_below(random, 256)) / 255.0f; };
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            colors.emplace_back(share(), share(), share());
            normals.emplace_back(share() - 0.5f, share() - 0.5f, share() - 0.5f);
            for (std::vector<float>& channel : channels)
                channel.push_back(share());
        }
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            of_triangle.push_back(static_cast<std::uint32_t>(i % 3));
            for (int corner = 0; corner < 3; ++corner)
                uvs.emplace_back(3.0f * share(), 3.0f * share());
        }
        Texture texture{.name = "checks", .width = 16, .height = 16};
        std::vector<std::uint8_t> texels;
        for (std::uint32_t texel = 0; texel < 256; ++texel)
            texels.insert(texels.end(), {static_cast<std::uint8_t>((texel % 16 + texel / 16) % 2 * 200),
                                         static_cast<std::uint8_t>(texel), 90, 255});
        texture.bytes = std::move(texels);
        materials = {{.color = vec3(0.2f, 0.5f, 0.1f)},
                     {.color = vec3(0.7f)},
                     {.texture = std::make_shared<FilteredTexture>(std::make_shared<Texture>(std::move(texture)))}};
    }

    /// Each kind alone, kinds together, and all.
    [[nodiscard]] std::vector<Surface> surfaces() const {
        const std::vector<SurfaceChannel> two{{"wet", channels[0]}, {"metallic", channels[1]}};
        return {
            {.colors = colors},
            {.materials = materials, .material_of_triangle = of_triangle, .corner_uvs = uvs},
            {.normals = SurfaceNormals::Faces},
            {.normals = SurfaceNormals::Vertices, .vertex_normals = normals},
            {.channels = two},
            {.colors = colors, .normals = SurfaceNormals::Vertices, .vertex_normals = normals, .channels = two},
            {.materials = std::span(materials).first(1), .normals = SurfaceNormals::Faces},
        };
    }

    std::vector<vec3> colors, normals;
    std::array<std::vector<float>, 2> channels;
    std::vector<std::uint32_t> of_triangle;
    std::vector<vec2> uvs;
    std::vector<SurfaceMaterial> materials;
};
const std::array<AttributeConfig, 4> ways_to_store{
    AttributeConfig{}, {.color_count = 40}, {.most_color_difference = 6.0, .normal_bits = 12}, {.normal_bits = 20}};
} // namespace

// Seen to fail with a part's voxels, and with its means, written as they lie in the world.
TEST_CASE("in parts or at once, the file has the same bytes, whatever voxels carry and however it is stored") {
    const TestFolder folder;
    std::uint32_t seed = 0;
    std::size_t split_count = 0;
    for (const std::uint32_t level : {3u, 6u, 8u, 9u}) {
        Job job = soup(level, level == 3 ? 5 : 60, level);
        const Carried carried(job.mesh);
        for (const Surface& surface : carried.surfaces())
            for (const AttributeConfig& attributes : ways_to_store) {
                CAPTURE(level);
                CAPTURE(seed);
                job.surface = surface;
                job.attributes = attributes;
                job.rule = ++seed % 2 == 0 ? VoxelizeRule::Thin : VoxelizeRule::Conservative;
                job.symmetry = static_cast<Symmetry>(seed % 3);
                const std::string wanted = job.at_once(folder);
                OutOfCoreStatistics statistics;
                for (const std::uint32_t worker_count : {1u, 64u}) {
                    CHECK((job.in_parts(folder, worker_count, &statistics) == wanted));
                    split_count += statistics.part_count > 1;
                }
                CHECK(std::filesystem::is_empty(folder / "scratch"));
            }
    }
    CHECK(split_count >= 28);
}

TEST_CASE("an empty cube carries nothing, in parts or at once") {
    const TestFolder folder;
    Job job{.mesh = oracle::mesh_of(oracle::box({-900, -900, -900}, {-200, -200, -200})), .level = 8};
    const Carried carried(job.mesh);
    job.surface = carried.surfaces()[5];
    CHECK((job.in_parts(folder, 48) == job.at_once(folder)));
}

TEST_CASE("colours survive an interruption, and a part whose attributes are damaged is made again") {
    const TestFolder folder;
    Job job = soup(9, 120, 31);
    const Carried carried(job.mesh);
    job.surface = carried.surfaces()[5];
    const std::string wanted = job.at_once(folder);
    OutOfCore interrupted = job.out_of_core(folder, 64);
    for (std::size_t part = 0; part < 5; ++part)
        interrupted.make_part(part, Progress());
    const auto path = interrupted.part_path(3);
    {
        std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
        file.seekp(-200, std::ios::end); // within the sums, or just before them
        file.put('\x5a');
    }
    OutOfCoreStatistics statistics;
    CHECK((job.in_parts(folder, 64, &statistics) == wanted));
    CHECK(statistics.kept_part_count == 4);
    CHECK(statistics.damaged_parts == std::vector{path.filename().string()});
    CHECK(std::filesystem::is_empty(folder / "scratch"));
}

TEST_CASE("jobs that differ in one colour, one texel or the bits of normals do not share their parts") {
    const TestFolder folder;
    const Job job = soup(9, 60, 32);
    Carried first(job.mesh), other_color(job.mesh), other_texel(job.mesh);
    other_color.colors[17].y = 1.0f - other_color.colors[17].y;
    Texture texture = other_texel.materials[2].texture->texture();
    std::vector<std::uint8_t> texels(texture.bytes.begin(), texture.bytes.end());
    texels[3 * 4] ^= 255;
    texture.bytes = std::move(texels);
    other_texel.materials[2].texture = std::make_shared<FilteredTexture>(std::make_shared<Texture>(texture));
    std::vector<Job> jobs(5, job);
    jobs[0].surface = first.surfaces()[5];
    jobs[1].surface = other_color.surfaces()[5];
    jobs[2].surface = first.surfaces()[1];
    jobs[3].surface = other_texel.surfaces()[1];
    jobs[4].surface = first.surfaces()[5];
    jobs[4].attributes.normal_bits = 16;
    for (const Job& one : jobs)
        one.out_of_core(folder, 64).make_part(0, Progress());
    for (const Job& one : jobs) {
        OutOfCoreStatistics statistics;
        CHECK((one.in_parts(folder, 64, &statistics) == one.at_once(folder)));
        CHECK(statistics.kept_part_count == 1);
    }
}

TEST_CASE("a palette is chosen when parts are joined: another one goes on with the same parts") {
    const TestFolder folder;
    Job job = soup(9, 60, 33);
    const Carried carried(job.mesh);
    job.surface = carried.surfaces()[0];
    job.out_of_core(folder, 64).make_part(0, Progress());
    job.attributes.color_count = 20;
    OutOfCoreStatistics statistics;
    CHECK((job.in_parts(folder, 64, &statistics) == job.at_once(folder)));
    CHECK(statistics.kept_part_count == 1);
}

TEST_CASE("attributes that the budget has no room for are refused, and the parts are kept") {
    const TestFolder folder;
    Job job = soup(9, 60, 34);
    const Carried carried(job.mesh);
    job.surface = carried.surfaces()[3]; // normals of 32 bits: nearly each voxel has its own
    OutOfCoreConfig config = job.config(folder, 64);
    OutOfCore parts(std::span<const dvec3>(job.mesh.positions), job.mesh.triangles, config, Progress());
    for (std::size_t part = 0; part < parts.part_count(); ++part)
        parts.make_part(part, Progress());
    config.worker_count = 1;
    config.voxels.memory_budget_bytes = 3 << 20;
    OutOfCore tight(std::span<const dvec3>(job.mesh.positions), job.mesh.triangles, config, Progress());
    Progress progress;
    CHECK_THROWS_WITH_AS(tight.finish(folder / "a.tdag", progress), doctest::Contains("normal_bits"), InvalidInput);
    CHECK(std::filesystem::exists(parts.part_path(0)));
    CHECK_FALSE(std::filesystem::exists(folder / "a.tdag"));
}
} // namespace out_of_core_attributes_test
