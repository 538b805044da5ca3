// SPDX-License-Identifier: GPL-3.0-or-later
// An image whose texels lie in a file, in square tiles that a cache keeps while they are looked up.
#pragma once
#include "image/tile_cache.hpp"
#include <bit>
#include <cstring>

namespace tyndall {
class TiledTexels {
public:
    /// Of width * height * 4 values, rows bottom to top, which are written to the file of the cache. Throws IoError, which
    /// names the image and the folder.
    TiledTexels(std::shared_ptr<TileCache> cache, const std::string& name, std::uint32_t width, std::uint32_t height,
                std::span<const std::uint8_t> bytes);
    TiledTexels(std::shared_ptr<TileCache> cache, const std::string& name, std::uint32_t width, std::uint32_t height,
                std::span<const float> floats);
    TiledTexels(const TiledTexels&) = delete;
    TiledTexels& operator=(const TiledTexels&) = delete;
    ~TiledTexels();

    [[nodiscard]] bool is_float() const { return side_ == float_side; }
    [[nodiscard]] std::uint32_t width() const { return width_; }
    [[nodiscard]] std::uint32_t height() const { return height_; }
    [[nodiscard]] TileCache& cache() const { return *cache_; }
    [[nodiscard]] std::shared_ptr<TileCache> shared_cache() const { return cache_; }
    [[nodiscard]] std::uint64_t file_bytes() const { return std::uint64_t{tile_count_} * TileCache::tile_bytes; }

    /// Of a texel inside of the image, as it was stored.
    [[nodiscard]] std::array<std::uint8_t, 4> bytes_at(std::size_t x, std::size_t y) const {
        return std::bit_cast<std::array<std::uint8_t, 4>>(words_at<1, byte_side>(x, y));
    }
    [[nodiscard]] std::array<float, 4> floats_at(std::size_t x, std::size_t y) const {
        return std::bit_cast<std::array<float, 4>>(words_at<4, float_side>(x, y));
    }
    /// All texels, as they were given: width * height * 4 values of the image's kind. Throws IoError.
    void copy_to(std::span<std::byte> texels) const;

private:
    static constexpr std::uint32_t byte_side = 64, float_side = 32; ///< Tiles of either kind have the same size.

    template <std::size_t WordsPerTexel, std::uint32_t Side>
    [[nodiscard]] std::array<std::uint32_t, WordsPerTexel> words_at(std::size_t x, std::size_t y) const {
        static_assert(WordsPerTexel * Side * Side == TileCache::tile_words);
        const auto tile = static_cast<std::uint32_t>(y / Side * tile_columns_ + x / Side);
        const std::size_t word = WordsPerTexel * (y % Side * Side + x % Side);
        return cache_->words<WordsPerTexel>(image_, file_place_, tile, places_[tile], word);
    }
    void write(std::span<const std::byte> texels, const std::string& name);

    std::shared_ptr<TileCache> cache_;
    std::uint32_t width_, height_, side_, tile_columns_, tile_count_, image_;
    std::uint64_t file_place_ = 0;
    std::unique_ptr<TileCache::Place[]> places_; ///< Of each tile.
};
} // namespace tyndall
