// SPDX-License-Identifier: GPL-3.0-or-later
// Up to 4096 values as runs and a dictionary of their own, any of which can be read without those before it.
//
//   entries     A A A B B A A A B C ... | C C C C C C ... |     groups of 16
//   occupied             1              |        0        |     does any differ from the one before?
//   codes       of each group that does: run_patterns.hpp
//   indices     A, B, C: of runs whose value is not that of the run before last, in the dictionary
//
// To read an entry, codes are followed from the block's begin, as far as to know where they lie and how many indices they
// bring; then back from the entry's own to the one that brought its value, most often the same or the one before. The
// dictionary ascends: Elias-Fano.
// Based on: Jacobson, Space-Efficient Static Trees and Graphs, FOCS 1989 (rank by counting); Elias 1974 and Fano 1971
//           (ascending numbers: low bits as they are, high bits in unary).
// Bound:    at most 2^log2_entries / 16 codes, 1 division by a power of the dictionary's size.
#pragma once
#include "voxel_dag/run_patterns.hpp"

namespace tyndall::voxel_dag::run_block {
/// What all blocks of an array share.
struct Shape {
    std::uint32_t log2_entries; ///< Of a block, [9, 12].
    std::uint32_t value_bits;   ///< Of a value, [0, 32].
};
/// Values as runs.
struct Runs {
    std::vector<run_patterns::Pattern> groups; ///< Of 16 entries; entry 0 is no change.
    std::vector<std::uint32_t> firsts;         ///< Values of runs that are no return.
};
[[nodiscard]] Runs runs_of(std::span<const std::uint32_t> values);
/// One to 2^log2_entries values, the last of which lasts to the block's end.
void append(std::span<const std::uint32_t> values, const Shape& shape, const run_patterns::Writer& patterns,
            BitPacker& bits);

/// Where the parts of a block are.
class Reader {
public:
    /// Of the block at bit `begin`. Nothing behind `end` is read but the zeros of bit_packing.hpp. patterns outlives it.
    Reader(const std::uint8_t* bytes, std::uint64_t begin, std::uint64_t end, const Shape& shape,
           const run_patterns::Reader& patterns);
    /// Null, or the part that is damaged. Only where it is null may values be read: then any can be, and none leads
    /// outside.
    [[nodiscard]] const char* damage() const;

    /// Of the values in the dictionary.
    [[nodiscard]] std::uint32_t largest() const;
    [[nodiscard]] std::uint32_t at(std::uint32_t entry) const;
    /// All values of the block, or as many as there is space for.
    void decode(std::span<std::uint32_t> values) const;

private:
    [[nodiscard]] std::uint32_t dictionary_value(std::uint32_t index) const;
    [[nodiscard]] const char* find_parts(std::uint64_t begin, const Shape& shape);
    template <class Visit>
    void visit_dictionary(const Visit& visit) const;
    template <class Visit>
    void visit_codes(std::uint32_t count, const Visit& visit) const;

    static constexpr std::uint32_t most_groups = 4096 / run_patterns::entries;

    const std::uint8_t* bytes_;
    std::uint64_t end_;
    const run_patterns::Reader& patterns_;
    std::uint32_t minimum_ = 0, dictionary_size_ = 0, index_count_ = 0, low_bits_ = 0, code_count_ = 0;
    std::uint64_t occupied_ = 0, low_ = 0, high_ = 0, indices_ = 0, classes_ = 0, codes_ = 0;
    const char* cut_off_; // the part at which a damaged block ends; last, because finding it sets all others
};
} // namespace tyndall::voxel_dag::run_block
