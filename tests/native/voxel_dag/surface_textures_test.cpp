// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures on the surface of voxels: what a picture of a formula becomes, and one that is finer than the voxels.
#include "image/srgb.hpp"
#include "native/voxel_dag/step_meshes.hpp"
#include "voxel_dag/surface_attributes.hpp"
#include <doctest/doctest.h>
#include <functional>

namespace surface_textures_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::voxel_dag::oracle;

namespace {
/// Linear floats, rows from the bottom.
SurfaceMaterial picture(std::uint32_t width, std::uint32_t height,
                        const std::function<vec3(std::uint32_t, std::uint32_t)>& color,
                        TextureExtension extension = TextureExtension::Repeat) {
    Texture texture{.name = "test", .width = width, .height = height, .is_srgb = false, .extension = extension};
    std::vector<float> texels;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            const vec3 at = color(x, y);
            texels.insert(texels.end(), {at.x, at.y, at.z, 1.0f});
        }
    texture.floats = std::move(texels);
    return {.texture = std::make_shared<FilteredTexture>(std::make_shared<Texture>(std::move(texture)))};
}

/// The floor of a cube of 2^level voxels, on which the picture lies `times` times along either axis.
struct Floor {
    std::vector<dvec3> positions;
    std::vector<uvec3> triangles{{0, 1, 2}, {0, 2, 3}};
    std::vector<vec2> uvs;
    std::uint32_t level;

    Floor(std::uint32_t floor_level, float times) : level(floor_level) {
        const double side = std::exp2(level), over = side / 8; // beyond the cube
        for (const auto& [x, y] : {std::pair(0.0, 0.0), {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
            positions.push_back({x * (side + 2 * over) - over, y * (side + 2 * over) - over, 0.5});
        for (const uvec3& t : triangles)
            for (int corner = 0; corner < 3; ++corner)
                uvs.push_back(times * vec2(positions[t[corner]]) / static_cast<float>(side));
    }
    /// Linear colours by voxel, x fastest.
    [[nodiscard]] std::vector<vec3> lit_by(std::span<const SurfaceMaterial> materials,
                                           std::span<const std::uint32_t> of_triangle = {}) const {
        const VoxelizeConfig config = config_of(level, VoxelizeRule::Thin);
        const std::span<const dvec3> at(positions);
        const LeafMasks leaves = voxelize(at, triangles, config, Progress()).leaves;
        const VoxelAttributes attributes = surface_attributes(
            at, triangles, config, leaves,
            {.materials = materials, .material_of_triangle = of_triangle, .corner_uvs = uvs}, Progress());
        std::vector<vec3> result(leaves.voxel_count());
        REQUIRE(result.size() == std::size_t{1} << 2 * level);
        std::size_t index = 0;
        for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick)
            for (std::uint64_t left = leaves.masks[brick]; left != 0; left &= left - 1) {
                const Voxel voxel =
                    voxel_at(leaves.codes[brick] << 6 | static_cast<std::uint64_t>(std::countr_zero(left)));
                const auto light = [&](std::uint32_t shift) {
                    return linear_from_srgb(static_cast<float>(attributes.colors[index] >> shift & 255) / 255.0f);
                };
                result[std::size_t{voxel[1]} << level | voxel[0]] = {light(0), light(8), light(16)};
                ++index;
            }
        return result;
    }
};
/// Half a byte of sRGB, at the brightest, as light.
constexpr float half_byte = 0.0045f;

vec3 mean_of(const std::vector<vec3>& colors) {
    dvec3 sum(0);
    for (const vec3& color : colors)
        sum += dvec3(color);
    return vec3(sum / static_cast<double>(colors.size()));
}
} // namespace

TEST_CASE("a picture of a wave gives each voxel the wave at its place") {
    const auto wave = [](float u, float v) {
        return vec3(0.5f + 0.4f * std::sin(6.2831853f * u), 0.5f + 0.4f * std::cos(6.2831853f * v), 0.25f);
    };
    const std::array materials{picture(256, 128, [&](std::uint32_t x, std::uint32_t y) {
        return wave((static_cast<float>(x) + 0.5f) / 256, (static_cast<float>(y) + 0.5f) / 128);
    })};
    for (const float times : {0.5f, 1.0f, 2.0f}) { // a voxel has 1, 2 and 4 texels of its 128
        const std::vector<vec3> colors = Floor(7, times).lit_by(materials);
        float most = 0;
        for (std::size_t y = 0; y < 128; ++y)
            for (std::size_t x = 0; x < 128; ++x) {
                const vec3 wanted =
                    wave(times * (static_cast<float>(x) + 0.5f) / 128, times * (static_cast<float>(y) + 0.5f) / 128);
                const vec3 off = glm::abs(colors[y << 7 | x] - wanted);
                most = std::max({most, off.x, off.y, off.z});
            }
        CHECK(most <
              half_byte + 0.01f); // what two filters as wide as a voxel take off the wave's crests, and round off
    }
}

TEST_CASE("a checkerboard finer than the voxels is grey, as light: a half, not what bytes add up to") {
    const std::array materials{
        picture(512, 512, [](std::uint32_t x, std::uint32_t y) { return vec3(static_cast<float>((x + y) % 2)); })};
    for (const float times : {1.0f, 3.0f})
        for (const vec3& color : Floor(6, times).lit_by(materials))
            REQUIRE(std::abs(color.x - 0.5f) < half_byte);
}

TEST_CASE("the mean over voxels is the mean of the picture, whatever its size, and wherever it is finer") {
    std::mt19937 random(3);
    for (const auto& [width, height] : {std::pair(512u, 512u), {256u, 640u}, {384u, 300u}}) {
        std::vector<vec3> texels;
        const auto texel = [&](std::uint32_t, std::uint32_t) {
            texels.emplace_back(static_cast<float>(random() % 100) / 99.0f, static_cast<float>(random() % 10) / 99.0f,
                                0.7f);
            return texels.back();
        };
        const std::array materials{picture(width, height, texel)};
        const vec3 off = glm::abs(mean_of(Floor(7, 1.0f).lit_by(materials)) - mean_of(texels));
        CHECK(off.x < 0.003f); // rounded bytes, 16,384 of them, and single texels at the floor's rim
        CHECK(off.y < 0.003f);
        CHECK(off.z < half_byte);
    }
}

TEST_CASE("beyond the picture: again and again, its edge, or nothing") {
    const auto left_is_white = [](std::uint32_t x, std::uint32_t) { return vec3(x < 32 ? 1.0f : 0.0f); };
    using enum TextureExtension;
    for (const auto& [extension, wanted] : {std::pair(Repeat, vec4(1, 0, 1, 0)),
                                            {Extend, vec4(1, 0, 0, 0)},
                                            {Clip, vec4(1, 0, 0, 0)},
                                            {Mirror, vec4(1, 0, 0, 1)}}) {
        const std::array materials{picture(64, 64, left_is_white, extension)};
        const std::vector<vec3> colors = Floor(6, 2.0f).lit_by(materials);
        for (int quarter = 0; quarter < 4; ++quarter)
            CHECK(colors[std::size_t{8} << 6 | (16 * static_cast<std::size_t>(quarter) + 8)].x == wanted[quarter]);
    }
    const std::array clipped{picture(
        64, 64, [](auto, auto) { return vec3(1.0f); }, Clip)};
    CHECK(Floor(6, 2.0f).lit_by(clipped)[std::size_t{50} << 6 | 50] == vec3(0)); // Extend has the white edge here
    const std::array extended{picture(
        64, 64, [](auto, auto) { return vec3(1.0f); }, Extend)};
    CHECK(Floor(6, 2.0f).lit_by(extended)[std::size_t{50} << 6 | 50] == vec3(1));
}

// Seen to fail with samples that are not drawn into their triangle.
TEST_CASE("at a seam each side keeps to its own part of the picture, and materials to their triangles") {
    // One triangle is red, the other green. Along the seam, which no voxel's centre lies on, both meet blue in the picture,
    // half a texel on: whoever looks beyond the seam sees it.
    Floor floor(6, 1.0f);
    for (dvec3& position : floor.positions)
        position.x += 0.3;
    for (std::size_t corner = 0; corner < 6; ++corner) {
        const dvec3& at = floor.positions[floor.triangles[corner / 3][static_cast<int>(corner % 3)]];
        const auto from_seam = static_cast<float>(std::abs(at.x - at.y - 0.3));
        floor.uvs[corner] = {0.5f + 0.5f / 256 + 0.1f / 64 * from_seam, corner < 3 ? 0.25f : 0.75f};
    }
    const std::array patches{picture(256, 256, [](std::uint32_t x, std::uint32_t y) {
        return x < 128 ? vec3(0, 0, 1) : y < 128 ? vec3(1, 0, 0) : vec3(0, 1, 0);
    })};
    const std::array plain{SurfaceMaterial{.color = {0, 1, 0}}, SurfaceMaterial{.color = {1, 0, 0}}};
    const std::vector<std::uint32_t> other_first{1, 0};
    const std::vector<vec3> colors = floor.lit_by(patches);
    CHECK(floor.lit_by(plain, other_first) == colors);
    std::size_t shared_count = 0;
    for (std::size_t y = 0; y < 64; ++y)
        for (std::size_t x = 0; x < 64; ++x) {
            const vec3& color = colors[y << 6 | x];
            REQUIRE(color.z == 0.0f);
            REQUIRE(std::abs(color.x + color.y - 1.0f) < 2 * half_byte);
            if (x > y + 1 || x + 1 < y)
                REQUIRE(color == (x > y ? vec3(1, 0, 0) : vec3(0, 1, 0)));
            shared_count += color.x != 0.0f && color.y != 0.0f;
        }
    CHECK(shared_count >= 60); // along the diagonal
}

TEST_CASE("what is wrong with materials is refused, and the culprit named") {
    Floor floor(3, 1.0f);
    std::array materials{picture(2, 2, [](auto, auto) { return vec3(1.0f); })};
    const std::vector<std::uint32_t> of_triangle{0, 1};
    CHECK_THROWS_WITH_AS(floor.lit_by(materials, of_triangle), "triangle 1 has material 1; there are 1", InvalidInput);
    CHECK_THROWS_WITH_AS(floor.lit_by(materials, std::span(of_triangle).first(1)),
                         "material_of_triangle: 1 for 2 triangles", InvalidInput);
    floor.uvs[4].y = NAN;
    CHECK_THROWS_WITH_AS(floor.lit_by(materials), "corner_uvs: corner 1 of triangle 1 has (1.125, nan)", InvalidInput);
    floor.uvs.pop_back();
    CHECK_THROWS_WITH_AS(floor.lit_by(materials), "corner_uvs: 5 for 6 corners of triangles", InvalidInput);
    materials[0] = {.color = {0, 2, 0}};
    CHECK_THROWS_WITH_AS(floor.lit_by(materials), "material 0 has the colour (0, 2, 0), outside [0, 1]", InvalidInput);
}
} // namespace surface_textures_test
