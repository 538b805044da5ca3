// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/vox_bytes.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/cielab.hpp"
#include "voxel_dag/vox_scene.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <map>
#include <numeric>
#include <random>

namespace vox_scene_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;
using namespace tyndall::support::vox_bytes;
using Coordinate = std::array<std::int64_t, 3>;

namespace {
const Progress progress;

vox::SceneVoxels voxels_in(const std::string& chunks) {
    return vox::voxels_of(vox::parse(bytes_of(file(chunks)), progress), {}, progress);
}

/// Colours by coordinates of the file.
std::map<Coordinate, std::uint32_t> colors_in(const vox::SceneVoxels& scene) {
    require_usable(scene.leaves);
    REQUIRE(scene.attributes.colors.size() == scene.leaves.voxel_count());
    std::map<Coordinate, std::uint32_t> colors;
    std::size_t number = 0;
    for (std::size_t brick = 0; brick < scene.leaves.codes.size(); ++brick)
        for (std::uint64_t bit = 0; bit < 64; ++bit)
            if ((scene.leaves.masks[brick] >> bit & 1) != 0) {
                const Voxel voxel = voxel_at(scene.leaves.codes[brick] << 6 | bit);
                colors[{voxel[0] + scene.lower[0], voxel[1] + scene.lower[1], voxel[2] + scene.lower[2]}] =
                    scene.attributes.colors[number++];
            }
    return colors;
}
std::vector<Coordinate> places_in(const std::string& chunks) {
    std::vector<Coordinate> places;
    for (const auto& [place, color] : colors_in(voxels_in(chunks)))
        places.push_back(place);
    return places;
}

using Matrix = std::array<std::array<int, 3>, 3>;
/// The format's text: "store a row-major rotation in the bits of a byte".
int rotation_byte(const Matrix& matrix) {
    int byte = 0;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column) {
            if (matrix[row][column] != 0 && row < 2)
                byte |= static_cast<int>(column) << 2 * row;
            if (matrix[row][column] < 0)
                byte |= 1 << (4 + row);
        }
    return byte;
}
/// All 48 matrices of one 1 or -1 in each row and column.
std::vector<Matrix> all_turns() {
    std::vector<Matrix> turns;
    std::array<std::size_t, 3> axis{0, 1, 2};
    do
        for (int signs = 0; signs < 8; ++signs) {
            Matrix matrix{};
            for (std::size_t row = 0; row < 3; ++row)
                matrix[row][axis[row]] = (signs >> row & 1) != 0 ? -1 : 1;
            turns.push_back(matrix);
        }
    while (std::ranges::next_permutation(axis).found);
    return turns;
}
std::array<double, 3> times(const Matrix& matrix, const std::array<double, 3>& point) {
    std::array<double, 3> product{};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            product[row] += matrix[row][column] * point[column];
    return product;
}
std::string translation_text(const std::array<int, 3>& along) {
    return std::to_string(along[0]) + " " + std::to_string(along[1]) + " " + std::to_string(along[2]);
}
} // namespace

TEST_CASE("the rotation byte of the format's text is the matrix that it prints") {
    const Matrix matrix{{{0, 1, 0}, {0, 0, -1}, {-1, 0, 0}}};
    REQUIRE(rotation_byte(matrix) == ((1 << 0) | (2 << 2) | (0 << 4) | (1 << 5) | (1 << 6)));
    const std::string turned = transform(0, 1, {{std::to_string(rotation_byte(matrix)), ""}}) + shape(1, {0});
    // The centre of voxel (2, 0, 0) of a cube of 4 is (0.5, -1.5, -1.5) from the middle; turned, (-1.5, 1.5, -0.5).
    CHECK(places_in(model(4, 4, 4, {{2, 0, 0, 1}}) + turned) == std::vector<Coordinate>{{-2, 1, -1}});
}

// Seen to fail, for odd sides, with mirrored voxels at -v in place of -v - 1.
TEST_CASE("voxels lie where the matrices of two transforms bring their centres, for each of 48 turns") {
    std::mt19937 random(5);
    const std::vector<Matrix> turns = all_turns();
    REQUIRE(turns.size() == 48);
    for (std::size_t first = 0; first < turns.size(); ++first) {
        const Matrix &outer = turns[first], &inner = turns[random() % 48];
        const std::array<int, 3> sides{3, 4, 5}, outer_shift{7, -20, 300}, inner_shift{-5, 6, 11};
        const Voxel4 voxel{static_cast<std::uint8_t>(random() % 3), static_cast<std::uint8_t>(random() % 4),
                           static_cast<std::uint8_t>(random() % 5), 1};
        std::array<double, 3> centre;
        for (std::size_t axis = 0; axis < 3; ++axis)
            centre[axis] = voxel[axis] + 0.5 - sides[axis] / 2;
        centre = times(inner, centre);
        for (std::size_t axis = 0; axis < 3; ++axis)
            centre[axis] += inner_shift[axis];
        centre = times(outer, centre);
        Coordinate wanted;
        for (std::size_t axis = 0; axis < 3; ++axis)
            wanted[axis] = static_cast<std::int64_t>(std::floor(centre[axis] + outer_shift[axis]));
        CHECK(places_in(model(3, 4, 5, {voxel}) +
                        transform(0, 1, {{std::to_string(rotation_byte(outer)), translation_text(outer_shift)}}) +
                        group(1, {2}) +
                        transform(2, 3, {{std::to_string(rotation_byte(inner)), translation_text(inner_shift)}}) +
                        shape(3, {0})) == std::vector<Coordinate>{wanted});
    }
}

TEST_CASE("where models overlap, the later in the graph gives its colour, and within a model the later voxel") {
    const std::string models =
        model(2, 1, 1, {{0, 0, 0, 1}, {1, 0, 0, 2}, {1, 0, 0, 3}}) + model(1, 1, 1, {{0, 0, 0, 4}});
    const std::array<std::uint32_t, 256> palette = vox::default_palette();
    const std::string shapes = shape(3, {0}) + shape(5, {1});
    for (const bool small_last : {false, true}) {
        const auto colors =
            colors_in(voxels_in(models + group(0, small_last ? std::vector{2, 4} : std::vector{4, 2}) +
                                transform(2, 3, {{"", "1 0 0"}}) + transform(4, 5, {{"", "0 0 0"}}) + shapes));
        CHECK(colors ==
              std::map<Coordinate, std::uint32_t>{{{0, 0, 0}, palette[small_last ? 4 : 1]}, {{1, 0, 0}, palette[3]}});
    }
}

TEST_CASE("hidden nodes and layers leave nothing, and of several frames the first is taken") {
    const std::string models = model(1, 1, 1, {{0, 0, 0, 1}}) + model(1, 1, 1, {{0, 0, 0, 2}});
    const auto placed = [&](const Entries& of_node, int layer) {
        return models + group(0, {1, 3}) + transform(1, 2, {{"", "9 0 0"}, {"", "99 0 0"}}) + shape(2, {0, 1}) +
               transform(3, 4, {{"", "-3 0 0"}}, of_node, layer) + shape(4, {1});
    };
    const std::vector<Coordinate> both{{-3, 0, 0}, {9, 0, 0}}, one{{9, 0, 0}};
    const auto layer = [](int number_of_it, const char* hidden) {
        return chunk("LAYR", number(number_of_it) + entries({{"_hidden", hidden}}) + number(-1));
    };
    CHECK(places_in(placed({}, 1)) == both);
    CHECK(places_in(placed({{"_hidden", "1"}}, 1)) == one);
    CHECK(places_in(placed({{"_hidden", "0"}}, 1)) == both);
    CHECK(places_in(placed({}, 1) + layer(1, "1")) == one);
    CHECK(places_in(placed({}, 1) + layer(1, "0") + layer(2, "1")) == both);
    CHECK(colors_in(voxels_in(placed({}, 1))).at({9, 0, 0}) == vox::default_palette()[1]);
    CHECK(voxels_in(models + transform(0, 1, {{"", ""}}, {{"_hidden", "1"}}) + shape(1, {0})).leaves.codes.empty());
}

TEST_CASE("without a graph the first model lies at 0") {
    CHECK(places_in(model(5, 6, 7, {{0, 0, 0, 1}, {4, 5, 6, 1}}) + model(9, 9, 9, {{8, 8, 8, 1}})) ==
          std::vector<Coordinate>{{0, 0, 0}, {4, 5, 6}});
}

TEST_CASE("materials become channels where a voxel has one, and the order of shown colours changes nothing") {
    std::string order;
    for (int i = 0; i < 256; ++i)
        order += static_cast<char>(255 - i);
    const std::string models = model(3, 1, 1, {{0, 0, 0, 3}, {1, 0, 0, 4}, {2, 0, 0, 5}});
    const auto material = [](int index, const Entries& values) {
        return chunk("MATL", number(index) + entries(values));
    };
    CHECK(voxels_in(models + material(9, {{"_type", "_metal"}, {"_metal", "1"}})).attributes.channels.empty());
    CHECK(voxels_in(models + material(3, {{"_type", "_diffuse"}, {"_rough", "0.1"}, {"_metal", "1"}}))
              .attributes.channels.empty());
    const vox::SceneVoxels scene =
        voxels_in(models + material(4, {{"_type", "_metal"}, {"_metal", "0.6"}, {"_rough", "0"}}) +
                  material(5, {{"_type", "_emit"}, {"_emit", "7"}}) + chunk("IMAP", order));
    CHECK(scene.attributes.channels == std::vector<VoxelChannel>{{"roughness", {255, 0, 255}},
                                                                 {"metallic", {0, 153, 0}},
                                                                 {"emission", {0, 0, 255}}});
    CHECK(scene.attributes.colors == voxels_in(models).attributes.colors);
}

TEST_CASE("a small file that asks for much is refused with what it asks for") {
    const std::string one = model(1, 1, 1, {{0, 0, 0, 1}});
    std::string bomb = model(1, 1, 1, {{0, 0, 0, 1}});
    for (int node = 0; node < 40; ++node)
        bomb += group(node, {node + 1, node + 1});
    CHECK_THROWS_WITH_AS(static_cast<void>(voxels_in(bomb + shape(40, {0}))),
                         "the scene graph places more than 4194304 nodes", InvalidInput);
    CHECK_THROWS_WITH_AS(
        static_cast<void>(voxels_in(one + group(0, {1, 3}) + transform(1, 2, {{"", "131072 0 0"}}) + shape(2, {0}) +
                                    transform(3, 2, {{"", "0 0 0"}}))),
        "its models span 131073 voxels; 131072 are possible: move them together, or hide those that are "
        "far away",
        InvalidInput);
    std::vector<int> many;
    std::string nodes;
    for (int i = 0; i < 200; ++i) {
        many.push_back(2 + i);
        nodes += transform(2 + i, 1, {{"", std::to_string(8 * i) + " 0 0"}});
    }
    const vox::File file =
        vox::parse(bytes_of(vox_bytes::file(one + shape(1, {0}) + group(0, many) + nodes)), progress);
    CHECK(vox::voxels_of(file, {}, progress).leaves.voxel_count() == 200);
    CHECK_THROWS_AS(static_cast<void>(vox::voxels_of(file, {.memory_budget_bytes = 20000}, progress)), InvalidInput);
    Progress cancelled;
    cancelled.cancel();
    CHECK_THROWS_AS(static_cast<void>(vox::voxels_of(file, {}, cancelled)), Cancelled);
}

namespace {
std::vector<ByteColor> random_colors(const LeafMasks& leaves, std::uint32_t kinds, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::vector<ByteColor> palette(kinds), colors(leaves.voxel_count());
    for (ByteColor& color : palette)
        for (std::uint8_t& channel : color)
            channel = static_cast<std::uint8_t>(random());
    for (ByteColor& color : colors)
        color = palette[random() % kinds];
    return colors;
}
/// As VoxelAttributes has them.
std::vector<std::uint32_t> as_attributes(const std::vector<ByteColor>& colors) {
    std::vector<std::uint32_t> attributes;
    for (const auto& [red, green, blue] : colors)
        attributes.push_back(red + 256u * green + 65536u * blue);
    return attributes;
}
vox::SceneVoxels round_trip(const vox::File& file) {
    return vox::voxels_of(vox::parse(vox::to_bytes(file, progress), progress), {}, progress);
}
} // namespace

// Seen to fail with translations to the corner of a model's voxels in place of their middle.
TEST_CASE("voxels and colours that were written come back, in as many models as it takes") {
    for (const LeafMasks& leaves : {random_voxels(5, 0.01, 6), full_voxels(3), sphere_voxels(9, {256, 250, 260}, 90),
                                    sierpinski_voxels(9), random_voxels(2, 0.1, 7)}) {
        const std::vector<ByteColor> colors = random_colors(leaves, 255, 8);
        const Coordinate lower{-70, 5, 100000};
        const vox::File file = vox::file_of(leaves, colors, lower, vox::TooManyColors::Refuse, progress);
        CHECK(file.models.size() >= (leaves.level > 8 ? 4 : 1));
        const vox::SceneVoxels read = round_trip(file);
        const vox::SceneVoxels written{.leaves = leaves,
                                       .lower = lower,
                                       .attributes = {.colors = as_attributes(colors), .normals = {}, .channels = {}}};
        CHECK(read.attributes.channels.empty());
        CHECK(colors_in(read) == colors_in(written));
    }
}

TEST_CASE("more than 255 colours are refused, or the nearest of a palette") {
    const LeafMasks leaves = random_voxels(4, 0.3, 9);
    const std::vector<ByteColor> listed_colors = random_colors(leaves, 400, 10);
    const std::vector<std::uint32_t> colors = as_attributes(listed_colors);
    CHECK_THROWS_AS(static_cast<void>(vox::file_of(leaves, listed_colors, {}, vox::TooManyColors::Refuse, progress)),
                    InvalidInput);
    const vox::File file = vox::file_of(leaves, listed_colors, {}, vox::TooManyColors::Quantize, progress);
    const std::vector<std::uint32_t> read = round_trip(file).attributes.colors;
    REQUIRE(read.size() == colors.size());
    const auto lab = [](std::uint32_t color) { return lab_of((color & 0xff) << 16 | (color & 0xff00) | color >> 16); };
    std::size_t changed = 0;
    double worst = 0.0;
    for (std::size_t i = 0; i < colors.size(); ++i) {
        changed += read[i] != colors[i];
        worst = std::max(worst, cie94(lab(colors[i]), lab(read[i])));
    }
    CHECK(changed > 0);
    CHECK(worst <
          8.0); // 255 of 400 at random in the cube; red and blue exchanged in one of the ways would be 50 and more
}

TEST_CASE("voxels without colours are of one, and what cannot be written is said") {
    const LeafMasks leaves = random_voxels(4, 0.3, 11);
    CHECK(round_trip(vox::file_of(leaves, {}, {}, vox::TooManyColors::Refuse, progress)).attributes.colors ==
          std::vector<std::uint32_t>(leaves.voxel_count(), 0xffffff));
    const auto refusal = [&](const LeafMasks& what, const std::vector<ByteColor>& colors, const Coordinate& lower) {
        try {
            static_cast<void>(vox::file_of(what, colors, lower, vox::TooManyColors::Refuse, progress));
        } catch (const InvalidInput& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    CHECK(refusal({.level = 5, .codes = {}, .masks = {}}, {}, {}).find("no voxels") != std::string::npos);
    CHECK(refusal(leaves, {{}, {}}, {}).find("2 colours") != std::string::npos);
    CHECK(refusal(leaves, {}, {0, 0, std::int64_t{1} << 40}).find("move it") != std::string::npos);
    // 2^29 + 2^20 voxels: more than 2^31 bytes; at half the resolution there are an eighth as many.
    LeafMasks large{.level = 10, .codes = {}, .masks = {}};
    large.codes.resize((1u << 23) + (1u << 14));
    std::iota(large.codes.begin(), large.codes.end(), std::uint64_t{0});
    large.masks.resize(large.codes.size(), ~std::uint64_t{0});
    CHECK(refusal(large, {}, {}).find("a resolution of 512 would fit") != std::string::npos);
}
} // namespace vox_scene_test
