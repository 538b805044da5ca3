// SPDX-License-Identifier: GPL-3.0-or-later
#include "image/tiled_texels.hpp"
#include "core/errors.hpp"
#include "core/partial_file.hpp"
#include <algorithm>
#include <utility>

namespace tyndall {
static constexpr std::uint32_t nowhere = ~0u;

TiledTexels::TiledTexels(std::shared_ptr<TileCache> cache, const std::string& name, std::uint32_t width,
                         std::uint32_t height, std::span<const std::uint8_t> bytes)
    : cache_(std::move(cache)), width_(width), height_(height), side_(byte_side),
      tile_columns_((width + side_ - 1) / side_), tile_count_(tile_columns_ * ((height + side_ - 1) / side_)),
      image_(cache_->next_image()) {
    require(bytes.size() == std::size_t{4} * width * height, "image \"", name, "\" has ", bytes.size(), " values");
    write(std::as_bytes(bytes), name);
}

TiledTexels::TiledTexels(std::shared_ptr<TileCache> cache, const std::string& name, std::uint32_t width,
                         std::uint32_t height, std::span<const float> floats)
    : cache_(std::move(cache)), width_(width), height_(height), side_(float_side),
      tile_columns_((width + side_ - 1) / side_), tile_count_(tile_columns_ * ((height + side_ - 1) / side_)),
      image_(cache_->next_image()) {
    require(floats.size() == std::size_t{4} * width * height, "image \"", name, "\" has ", floats.size(), " values");
    write(std::as_bytes(floats), name);
}

TiledTexels::~TiledTexels() { cache_->file().release(file_place_, file_bytes()); }

void TiledTexels::write(std::span<const std::byte> texels, const std::string& name) {
    places_ = std::make_unique<TileCache::Place[]>(tile_count_);
    for (std::uint32_t tile = 0; tile < tile_count_; ++tile)
        places_[tile].store(nowhere, std::memory_order_relaxed);
    TexelFile& file = cache_->file();
    file_place_ = file.reserve(file_bytes());
    const std::size_t texel_bytes = is_float() ? 16 : 4, row_bytes = texel_bytes * width_;
    const std::size_t row_of_tile = texel_bytes * side_, row_of_tiles = TileCache::tile_bytes * tile_columns_;
    std::vector<std::byte> tiles(row_of_tiles);
    std::uint64_t place = file_place_;
    try {
        for (std::uint32_t first_row = 0; first_row < height_; first_row += side_, place += row_of_tiles) {
            std::ranges::fill(tiles, std::byte{0});
            for (std::uint32_t row = first_row; row < std::min(first_row + side_, height_); ++row)
                for (std::size_t from = 0, column = 0; from < row_bytes; from += row_of_tile, ++column)
                    std::memcpy(&tiles[column * TileCache::tile_bytes + (row - first_row) * row_of_tile],
                                &texels[row * row_bytes + from], std::min(row_of_tile, row_bytes - from));
            file.write(place, tiles);
        }
    } catch (const IoError& error) {
        file.release(file_place_, file_bytes());
        throw IoError("image \"" + name + "\" is beyond the textures' memory budget: " + error.what());
    }
}

void TiledTexels::copy_to(std::span<std::byte> texels) const {
    const std::size_t texel_bytes = is_float() ? 16 : 4, row_bytes = texel_bytes * width_;
    require(texels.size() == row_bytes * height_, "texels have a size of ", texels.size(), " bytes");
    const std::size_t row_of_tile = texel_bytes * side_, row_of_tiles = TileCache::tile_bytes * tile_columns_;
    std::vector<std::byte> tiles(row_of_tiles);
    std::uint64_t place = file_place_;
    for (std::uint32_t first_row = 0; first_row < height_; first_row += side_, place += row_of_tiles) {
        if (const int error = cache_->file().read(place, tiles); error != 0)
            refuse_file(cache_->file().folder(),
                        "textures cannot be read again: " + std::generic_category().message(error));
        for (std::uint32_t row = first_row; row < std::min(first_row + side_, height_); ++row)
            for (std::size_t from = 0, column = 0; from < row_bytes; from += row_of_tile, ++column)
                std::memcpy(&texels[row * row_bytes + from],
                            &tiles[column * TileCache::tile_bytes + (row - first_row) * row_of_tile],
                            std::min(row_of_tile, row_bytes - from));
    }
}
} // namespace tyndall
