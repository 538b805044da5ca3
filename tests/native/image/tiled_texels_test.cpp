// SPDX-License-Identifier: GPL-3.0-or-later
// Images in a file: what they show is what they show in memory, bit for bit, however few tiles are kept.
#include "core/errors.hpp"
#include "image/texture.hpp"
#include "image/tiled_texels.hpp"
#include <bit>
#include <doctest/doctest.h>
#include <random>
#include <thread>

namespace tiled_texels_test {
using namespace tyndall;

namespace {
std::filesystem::path folder() { return std::filesystem::temp_directory_path(); }

/// Of a size that no tile divides.
Texture random_image(std::uint32_t width, std::uint32_t height, bool is_float, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::uint8_t> bytes;
    std::vector<float> floats;
    std::uniform_real_distribution<float> uniform(-1.0f, 9.0f);
    for (std::size_t i = 0; i < std::size_t{4} * width * height; ++i)
        if (is_float)
            floats.push_back(uniform(random));
        else
            bytes.push_back(static_cast<std::uint8_t>(random() % 256));
    Texture texture{.name = "image", .width = width, .height = height};
    texture.bytes = std::move(bytes), texture.floats = std::move(floats);
    return texture;
}
Texture in_file(Texture texture, const std::shared_ptr<TileCache>& cache) {
    texture.tiles = texture.floats.empty() ? std::make_shared<TiledTexels>(cache, texture.name, texture.width,
                                                                           texture.height, std::span(texture.bytes))
                                           : std::make_shared<TiledTexels>(cache, texture.name, texture.width,
                                                                           texture.height, std::span(texture.floats));
    texture.bytes = {}, texture.floats = {};
    return texture;
}
std::array<std::uint32_t, 4> bits(const vec4& value) { return std::bit_cast<std::array<std::uint32_t, 4>>(value); }

/// How many of so many random lookups differ in a bit.
int differences(const Texture& one, const Texture& other, int count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(-1.5f, 2.5f);
    int found = 0;
    for (int i = 0; i < count; ++i) {
        const vec2 uv(uniform(random), uniform(random));
        const auto column = static_cast<std::int64_t>(uv.x * 300.0f), row = static_cast<std::int64_t>(uv.y * 200.0f);
        found += bits(one.lookup(uv)) != bits(other.lookup(uv)) ||
                 bits(one.at(column, row)) != bits(other.at(column, row)) ||
                 std::bit_cast<std::uint32_t>(one.alpha(uv)) != std::bit_cast<std::uint32_t>(other.alpha(uv));
    }
    return found;
}
} // namespace

// Seen to fail with tiles laid out by the columns of texels, not of tiles.
TEST_CASE("lookups of an image in a file are those of the image in memory, bit for bit") {
    for (const bool is_float : {false, true})
        for (const std::size_t tile_count : {1, 3, 1000}) {
            const auto cache = std::make_shared<TileCache>(folder(), tile_count * TileCache::tile_bytes);
            Texture memory = random_image(301, 203, is_float, 1);
            Texture file = in_file(memory, cache);
            for (const bool has_alpha : {false, true})
                for (int extension = 0; extension < 4; ++extension)
                    for (int interpolation = 0; interpolation < 3; ++interpolation)
                        for (Texture* texture : {&memory, &file}) {
                            texture->has_alpha = has_alpha;
                            texture->is_srgb = extension % 2 == 0;
                            texture->extension = static_cast<TextureExtension>(extension);
                            texture->interpolation = static_cast<TextureInterpolation>(interpolation);
                            if (texture == &file)
                                CHECK(differences(memory, file, 300, 2) == 0);
                        }
            CHECK(cache->counts().resident_bytes <= tile_count * TileCache::tile_bytes);
            CHECK(cache->counts().tiles_read > 0);
        }
}

// Seen to fail without the look at whose a slot is. That its version changes between two looks is too rare to be seen.
TEST_CASE("many threads that evict each other's tiles see the same bits") {
    const auto cache = std::make_shared<TileCache>(folder(), 9 * TileCache::tile_bytes);
    std::vector<Texture> memory, file;
    for (unsigned image = 0; image < 3; ++image) {
        memory.push_back(random_image(301, 203, image == 2, image));
        file.push_back(in_file(memory.back(), cache));
    }
    std::array<int, 4> found{};
    {
        std::vector<std::jthread> threads;
        for (unsigned thread = 0; thread < found.size(); ++thread)
            threads.emplace_back([&, thread] {
                for (unsigned round = 0; round < 30; ++round)
                    found[thread] += differences(memory[round % 3], file[round % 3], 200, 100 * round + thread);
            });
    }
    for (const int count : found)
        CHECK(count == 0);
}

TEST_CASE("a tile that is kept is not read again, and one that is used is kept before one that is not") {
    const auto cache = std::make_shared<TileCache>(folder(), 4 * TileCache::tile_bytes);
    Texture file = in_file(random_image(64 * 6, 64, false, 1), cache);
    file.interpolation = TextureInterpolation::Closest;
    const auto look = [&](int tile) { (void)file.at(64 * tile, 0); };
    for (int round = 0; round < 3; ++round)
        for (int tile = 0; tile < 4; ++tile)
            look(tile);
    CHECK(cache->counts().tiles_read == 4);
    look(4); // a full round of the hand: the first has to go, and all are taken for unused
    look(1);
    look(5); // in place of the second or later ones, not of 1
    CHECK(cache->counts().tiles_read == 6);
    look(1);
    CHECK(cache->counts().tiles_read == 6);
}

TEST_CASE("all texels come back as they were given") {
    const auto cache = std::make_shared<TileCache>(folder(), TileCache::tile_bytes);
    const Texture memory = random_image(130, 67, true, 4), file = in_file(memory, cache);
    std::vector<float> texels(memory.floats.size());
    file.tiles->copy_to(std::as_writable_bytes(std::span(texels)));
    CHECK(std::ranges::equal(texels, memory.floats));
}

TEST_CASE("a folder that is not there, and a full disk, are named") {
    CHECK_THROWS_WITH_AS(TileCache("/nowhere/at/all", 1 << 20),
                         "/nowhere/at/all: no room for textures: No such file or directory", IoError);
    if (!std::filesystem::exists("/dev/full"))
        return;
    const auto cache = std::make_shared<TileCache>(folder(), 1 << 20);
    const Texture image = random_image(8, 8, false, 1);
    // Beyond the size that any file may have: the same way out as for a disk that is full.
    (void)cache->file().reserve(std::uint64_t{1} << 62);
    CHECK_THROWS_AS(in_file(image, cache), IoError);
}
} // namespace tiled_texels_test
