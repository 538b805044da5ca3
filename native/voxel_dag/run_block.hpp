// SPDX-License-Identifier: GPL-3.0-or-later
// Up to 4096 values as runs and a dictionary of their own, any of which can be read without those before it.
//
//   entries   A A A B B A A A | C C C C C C C C | C C ...          runs of equal values
//   flags     0 0 0 1 0 1 0 0 | all 0: absent   | ...              is it another value than the one before?
//   runs      A, B, A, C: "value before last" 0 0 1 0; the others are indices A, B, C of the dictionary
//
// Flags of 8 entries are a byte. A bit per 64 entries and then one per 8 say which bytes are there; where a block has few
// different bytes they are indices of a table. The index of an entry's run is a count of set bits. From a run that repeats
// the value before last one walks back in steps of two, 32 per word. The dictionary ascends: Elias-Fano.
// Based on: Jacobson, Space-Efficient Static Trees and Graphs, FOCS 1989 (rank by counting); Elias 1974 and Fano 1971
//           (ascending numbers: low bits as they are, high bits in unary).
// Bound:    at most 2^log2_entries / 64 words of flags, as many of repeats, 1 division by a power of the dictionary's size.
#pragma once
#include "voxel_dag/bit_packing.hpp"

namespace tyndall::voxel_dag::run_block {
/// What all blocks of an array share.
struct Shape {
    std::uint32_t log2_entries; ///< Of a block, [9, 12].
    std::uint32_t value_bits;   ///< Of a value, [0, 32].
};
/// One to 2^log2_entries values, the last of which lasts to the block's end.
void append(std::span<const std::uint32_t> values, const Shape& shape, BitPacker& bits);

/// Where the parts of a block are.
class Reader {
public:
    /// Of the block at bit `begin`. Nothing behind `end` is read but the zeros of bit_packing.hpp.
    Reader(const std::uint8_t* bytes, std::uint64_t begin, std::uint64_t end, const Shape& shape);
    /// Null, or the part that is damaged. Only where it is null may values be read: then any can be, and none leads
    /// outside.
    [[nodiscard]] const char* damage() const;

    [[nodiscard]] std::uint32_t at(std::uint32_t entry) const;
    /// All values of the block, or as many as there is space for.
    void decode(std::span<std::uint32_t> values) const;

private:
    [[nodiscard]] std::uint8_t byte_of_table(std::uint64_t index) const;
    [[nodiscard]] std::uint8_t flag_byte(std::uint32_t number) const;
    [[nodiscard]] std::uint32_t runs_before(std::uint32_t byte_count) const;
    [[nodiscard]] std::uint32_t run_of(std::uint32_t entry) const;
    [[nodiscard]] std::uint32_t origin_of(std::uint32_t run) const;
    [[nodiscard]] std::uint32_t dictionary_value(std::uint32_t index) const;
    [[nodiscard]] const char* find_parts(std::uint64_t begin, const Shape& shape);

    const std::uint8_t* bytes_;
    std::uint64_t end_;
    std::uint32_t minimum_ = 0, dictionary_size_ = 0, run_count_ = 1, index_count_ = 0;
    std::uint32_t low_bits_ = 0, byte_bits_ = 8, byte_count_ = 0, table_size_ = 0;
    std::uint64_t occupied_64_ = 0; // bit per 64 entries: is any flag set?
    std::uint64_t occupied_8_ = 0, byte_table_ = 0, bytes_at_ = 0, repeats_ = 0, low_ = 0, high_ = 0, indices_ = 0;
    const char* cut_off_; // the part at which a damaged block ends; last, because finding it sets all others
};
} // namespace tyndall::voxel_dag::run_block
