// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/mutated_bytes.hpp"
#include "support/vox_bytes.hpp"
#include "voxel_dag/vox_scene.hpp"
#include <doctest/doctest.h>
#include <random>

namespace vox_file_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support::vox_bytes;

namespace {
const Progress progress;

/// What a file is refused for; "" where it is not.
std::string complaint_about(const std::string& file) {
    try {
        static_cast<void>(vox::voxels_of(vox::parse(bytes_of(file), progress), {}, progress));
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "";
}

/// Of every kind of chunk at least one.
std::string many_chunks() {
    std::string map;
    for (int i = 0; i < 256; ++i)
        map += static_cast<char>(255 - i);
    return file(chunk("PACK", number(2)) + model(3, 4, 5, {{0, 1, 2, 7}, {2, 3, 4, 255}}) +
                model(1, 1, 1, {{0, 0, 0, 9}}) + transform(0, 1, {{"", ""}}) + group(1, {2, 4}) +
                transform(2, 3, {{"40", "5 -6 7"}}, {}, 1) + shape(3, {0, 1}) +
                transform(4, 5, {{"", "1 2 3"}}, {{"_name", "far"}}) + shape(5, {1}) +
                chunk("LAYR", number(1) + entries({{"_name", "first"}}) + number(-1)) + chunk("IMAP", map) +
                chunk("RGBA", std::string(1024, 'a')) +
                chunk("MATL", number(9) + entries({{"_type", "_metal"}, {"_metal", "0.5"}, {"_rough", "0.25"}})) +
                chunk("NOTE", "what nobody knows"));
}
} // namespace

TEST_CASE("a model's sides, voxels and colours are what the file says, and index 1 is the palette's first colour") {
    std::string colors;
    for (int i = 0; i < 256; ++i)
        colors += {static_cast<char>(i), static_cast<char>(2 * i), static_cast<char>(255 - i), '\x80'};
    const vox::File read = vox::parse(
        bytes_of(file(model(3, 4, 256, {{2, 3, 255, 1}, {0, 0, 0, 255}}) + chunk("RGBA", colors))), progress);
    REQUIRE(read.models.size() == 1);
    CHECK(read.models[0].sides == std::array{3u, 4u, 256u});
    CHECK(read.models[0].voxels == std::vector<vox::ModelVoxel>{{2, 3, 255, 1}, {0, 0, 0, 255}});
    CHECK(read.palette[1] == 0xff0000);
    CHECK(read.palette[11] == (10u | 20u << 8 | 245u << 16));
    CHECK(read.palette[255] == (254u | 252u << 8 | 1u << 16));
}

TEST_CASE("a file without a palette has MagicaVoxel's") {
    const vox::File read = vox::parse(bytes_of(file(model(1, 1, 1, {{0, 0, 0, 1}}))), progress);
    // Entries of the table in the format's text, which has red in the lowest byte.
    for (const auto& [index, color] : std::vector<std::pair<std::size_t, std::uint32_t>>{{1, 0xffffff},
                                                                                         {2, 0xccffff},
                                                                                         {6, 0x00ffff},
                                                                                         {7, 0xffccff},
                                                                                         {16, 0x6699ff},
                                                                                         {37, 0xffffcc},
                                                                                         {80, 0xcccc99},
                                                                                         {215, 0x330000},
                                                                                         {216, 0x0000ee},
                                                                                         {225, 0x000011},
                                                                                         {226, 0x00ee00},
                                                                                         {236, 0xee0000},
                                                                                         {246, 0xeeeeee},
                                                                                         {255, 0x111111}})
        CHECK(read.palette[index] == color);
}

TEST_CASE("nodes, layers and materials are read, and what is behind a first frame is passed over") {
    const vox::File read = vox::parse(bytes_of(many_chunks()), progress);
    REQUIRE(read.nodes.size() == 6);
    CHECK(read.nodes.at(1).children == std::vector<std::int32_t>{2, 4});
    CHECK(read.nodes.at(2).rotation == 40);
    CHECK(read.nodes.at(2).translation == std::array{5, -6, 7});
    CHECK(read.nodes.at(2).layer == 1);
    CHECK(read.nodes.at(3).children == std::vector<std::int32_t>{0});
    CHECK(read.is_hidden.at(1) == false);
    CHECK(read.materials[9] == vox::Material{.roughness = 64, .metallic = 128, .emission = 0});
    CHECK(read.materials[8] == vox::Material{});
}

// Seen to fail where a chunk's size is not compared with what is left of the file.
TEST_CASE("a file that ends early is refused, wherever it ends, and names the chunk") {
    const std::string whole = many_chunks();
    CHECK(complaint_about(whole) == "");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        CAPTURE(length);
        const std::string complaint = complaint_about(whole.substr(0, length));
        REQUIRE(complaint.find(length < 8    ? "no .vox file"
                               : length < 20 ? "chunk"
                                             : "chunk MAIN at byte 8") != std::string::npos);
    }
}

TEST_CASE("the first chunk that is damaged is named, with its place and what is wrong") {
    const std::string good = model(2, 2, 2, {{0, 0, 0, 1}});
    const auto with_graph = [&](const std::string& nodes) { return file(good + nodes); };
    const std::string root = transform(0, 1, {{"", ""}});
    for (const auto& [bytes, wanted] : std::vector<std::pair<std::string, std::string>>{
             {"VOX " + number(99) + chunk("MAIN", ""), "version 99"},
             {"VOX " + number(150) + chunk("SIZE", ""), "chunk SIZE at byte 8: the file's first chunk is not MAIN"},
             {file(""), "no model"},
             {file(chunk("SIZE", number(1) + number(1))), "chunk SIZE at byte 20: a side is cut off"},
             {file(model(0, 1, 1, {})), "chunk SIZE at byte 20: a side of 0 voxels"},
             {file(model(257, 1, 1, {})), "a side of 257 voxels"},
             {file(chunk("XYZI", number(0))), "chunk XYZI at byte 20: no SIZE comes before it"},
             {file(good + chunk("SIZE", number(1) + number(1) + number(1))), "no XYZI"},
             {file(chunk("SIZE", number(1) + number(1) + number(1)) + chunk("XYZI", number(1000) + "1234")),
              "chunk XYZI at byte 44: its voxels are 1000, more than its 4 bytes hold"},
             {file(chunk("SIZE", number(1) + number(1) + number(1)) + chunk("XYZI", number(-1) + "1234")), "are -1"},
             {file(model(2, 2, 2, {{0, 0, 0, 1}, {0, 2, 0, 1}})), "voxel 1 lies outside of its model, 2 x 2 x 2"},
             {file(model(2, 2, 2, {{0, 0, 0, 0}})), "voxel 0 has the colour 0"},
             {file(good + chunk("RGBA", "123456")), "chunk RGBA at byte 64: a colour is cut off"},
             {file(good + chunk("IMAP", "123456")), "chunk IMAP at byte 64"},
             {file(good + chunk("MATL", number(3) + entries({{"_type", "_emit"}, {"_emit", "lots"}}))),
              "chunk MATL at byte 64: _emit is \"lots\", no number"},
             {file(good + chunk("MATL", number(3) + entries({{"_type", "_emit"}, {"_emit", "nan"}}))), "not finite"},
             {with_graph(transform(0, 1, {})), "chunk nTRN at byte 64: it has no frame"},
             {with_graph(transform(0, 1, {{"5", ""}})), "chunk nTRN at byte 64: its rotation 5 is none"},
             {with_graph(transform(0, 1, {{"300", ""}})), "its rotation is \"300\""},
             {with_graph(transform(0, 1, {{"", "1 2"}})), "its translation is \"\""},
             {with_graph(transform(0, 1, {{"", "1 2 99999999999"}})), "its translation is \"99999999999\""},
             {with_graph(root + root), "node 0 comes twice"},
             {with_graph(root), "names node 1, which is not there"},
             {with_graph(transform(7, 1, {{"", ""}})), "names node 0"},
             {with_graph(root + group(1, {0})), "goes in circles"},
             {with_graph(root + shape(1, {1})), "chunk nSHP, node 1: model 1 is not there"},
             {with_graph(root + shape(1, {})), "chunk nSHP at byte"},
             {file(good +
                   "SI\x01"
                   "E" +
                   number(0) + number(0)),
              "what begins at byte 64 is no chunk"},
             {file(good) + "abc", "chunk at byte 64: its header is cut off"}}) {
        CAPTURE(wanted);
        CHECK(complaint_about(bytes).find(wanted) != std::string::npos);
    }
}

TEST_CASE("what is written is read back, and read by the format's text it is the same") {
    std::mt19937 random(1);
    vox::File file{.models = {}, .nodes = {}, .is_hidden = {}, .palette = vox::default_palette(), .materials = {}};
    for (std::uint32_t side : {1u, 17u, 256u}) {
        vox::Model& model = file.models.emplace_back();
        model.sides = {side, 256, 3};
        for (int i = 0; i < 500; ++i)
            model.voxels.push_back({static_cast<std::uint8_t>(random() % side), static_cast<std::uint8_t>(random()),
                                    static_cast<std::uint8_t>(random() % 3),
                                    static_cast<std::uint8_t>(1 + random() % 255)});
    }
    file.palette[255] = 0x123456;
    file.nodes[0] = {
        .kind = vox::NodeKind::Transform, .layer = 3, .rotation = 40, .translation = {-7, 0, 1 << 30}, .children = {1}};
    file.nodes[1] = {.kind = vox::NodeKind::Group, .is_hidden = true, .translation = {}, .children = {2, 2}};
    file.nodes[2] = {.kind = vox::NodeKind::Shape, .translation = {}, .children = {1}};
    CHECK(vox::parse(vox::to_bytes(file, progress), progress) == file);

    vox::File small{.models = {{.sides = {2, 3, 4}, .voxels = {{1, 2, 3, 9}}}},
                    .nodes = {},
                    .is_hidden = {},
                    .palette = {},
                    .materials = {}};
    small.palette.fill(0x616161);
    small.palette[0] = 0;
    small.nodes[0] = {.kind = vox::NodeKind::Transform, .translation = {1, -2, 3}, .children = {1}};
    small.nodes[1] = {.kind = vox::NodeKind::Shape, .translation = {}, .children = {0}};
    std::string colors;
    for (int i = 0; i < 255; ++i)
        colors += "aaa\xff";
    const std::string wanted =
        support::vox_bytes::file(model(2, 3, 4, {{1, 2, 3, 9}}) + transform(0, 1, {{"4", "1 -2 3"}}) + shape(1, {0}) +
                                 chunk("RGBA", colors + std::string("\0\0\0\xff", 4)));
    CHECK(vox::to_bytes(small, progress) == bytes_of(wanted));
}

/// Nothing but an InvalidInput, and nothing that takes longer or more memory than the file could ask for.
static void mutate_and_read(const std::string& whole, int times, std::uint32_t seed) {
    std::mt19937 random(seed);
    int read_count = 0, refused_count = 0;
    for (int time = 0; time < times; ++time) {
        const std::string changed = support::mutated(whole, random);
        try {
            const vox::File file = vox::parse(bytes_of(changed), progress);
            const vox::SceneVoxels scene = vox::voxels_of(file, {.memory_budget_bytes = 1 << 24}, progress);
            REQUIRE(scene.attributes.colors.size() == scene.leaves.voxel_count());
            ++read_count;
        } catch (const InvalidInput& error) {
            REQUIRE(std::string(error.what()).size() > 10);
            ++refused_count;
        }
    }
    CHECK(read_count + refused_count == times);
    CHECK(read_count > times / 50);
    CHECK(refused_count > times / 50);
}
TEST_CASE("a .vox file that was changed anywhere is read or refused") { mutate_and_read(many_chunks(), 600, 3); }
TEST_CASE("10,000 .vox files that were changed anywhere are read or refused" * doctest::test_suite("long")) {
    mutate_and_read(many_chunks(), 10000, 4);
}
} // namespace vox_file_test
