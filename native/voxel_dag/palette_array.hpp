// SPDX-License-Identifier: GPL-3.0-or-later
// An attribute array as palette blocks: bytes with random access. The baseline that benchmarks compare run arrays with.
// Based on: Kol, dissertation, TU Delft 2018, section 2.4.2: material array, palettes, block directory, indices.
// Differs:  palettes ascend, so that blocks with the same values share one; every number is packed to the bits that it
//           needs, those of the directory, too.
// Bound:    a value costs a binary search in the directory and three loads; opening costs 1 ns per block and palette
//           entry, and nothing per index.
#pragma once
#include "voxel_dag/palette_blocks.hpp"

namespace tyndall::voxel_dag {
/// Bytes of the values, from which PaletteArray reads them. Throws InvalidInput beyond 2^32 - 1 values, and Cancelled.
[[nodiscard]] std::vector<std::uint8_t> encode_palettes(std::span<const std::uint32_t> values,
                                                        const palette_blocks::Config& config, const Progress& progress);

/// Reads what encode_palettes() wrote, in place: the bytes stay the caller's.
class PaletteArray {
public:
    /// Throws InvalidInput, which names the section that is damaged or cut off. Whatever indices say then, values are
    /// materials.
    explicit PaletteArray(std::span<const std::uint8_t> bytes);

    [[nodiscard]] std::uint32_t size() const { return entry_count_; }
    /// entry is below size().
    [[nodiscard]] std::uint32_t at(std::uint32_t entry) const;
    /// values[i] becomes that of entry begin + i; begin + values.size() is at most size().
    void decode(std::uint32_t begin, std::span<std::uint32_t> values) const;

    /// Where the bytes are; the header and the zeros at the end are in none of them.
    struct Parts {
        std::uint64_t block_count, palette_count;
        std::uint64_t material_bytes, directory_bytes, palette_bytes, index_bytes;
    };
    [[nodiscard]] const Parts& parts() const { return parts_; }

private:
    struct Block {
        std::uint64_t first_entry, first_in_palettes, first_bit; ///< Of the array, the palettes, the indices.
        std::uint32_t index_bits;
    };
    [[nodiscard]] std::uint64_t first_entry(std::uint64_t block) const;
    [[nodiscard]] Block block(std::uint64_t number) const;
    [[nodiscard]] std::uint64_t block_of(std::uint64_t entry) const;
    [[nodiscard]] std::uint32_t value(const Block& block, std::uint64_t entry) const;

    std::uint32_t entry_count_ = 0, material_count_ = 0, value_bits_ = 0;
    std::uint64_t block_count_ = 0, palette_entry_count_ = 0, index_bit_count_ = 0;
    std::uint32_t entry_bits_ = 0, palette_bits_ = 0, offset_bits_ = 0,
                  material_bits_ = 0; // of the directory, a palette
    const std::uint8_t *materials_ = nullptr, *directory_ = nullptr, *palettes_ = nullptr, *indices_ = nullptr;
    Parts parts_{};
};
} // namespace tyndall::voxel_dag
