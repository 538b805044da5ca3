// SPDX-License-Identifier: GPL-3.0-or-later
// An attribute array as blocks of one length, each with its own runs and dictionary: bytes with random access.
// Differs:  from Kol 2018, section 2.4.2: the block of an entry is a shift, not a search; 73 to 93 % of neighbours are
//           equal, so that codes of runs take the place of most indices; blocks of equal contents are stored once, which a
//           palette shared between unequal blocks is not worth beside.
// Bound:    a value costs two loads of the directory and the scan of one block's codes, run_block.hpp.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/run_block.hpp"

namespace tyndall::voxel_dag {
namespace run_array {
struct Config {
    /// Of a block, [9, 12]. 9 reads values fastest; 10 to 12 is smallest, depending on how much repeats.
    std::uint32_t log2_block_entries = 11;
};
/// Bytes of the values, from which RunArray reads them; the same for any number of threads. Throws InvalidInput and
/// Cancelled.
[[nodiscard]] std::vector<std::uint8_t> encode(std::span<const std::uint32_t> values, const Config& config,
                                               const Progress& progress);
} // namespace run_array

/// Reads what run_array::encode() wrote, in place: the bytes stay the caller's.
class RunArray {
public:
    /// Throws InvalidInput, which names the section that is damaged or cut off. Whatever an undetected change says then,
    /// every entry can be read.
    explicit RunArray(std::span<const std::uint8_t> bytes);

    [[nodiscard]] std::uint64_t size() const { return entry_count_; }
    /// entry is below size().
    [[nodiscard]] std::uint32_t at(std::uint64_t entry) const;
    /// values[i] becomes that of entry begin + i; begin + values.size() is at most size().
    void decode(std::uint64_t begin, std::span<std::uint32_t> values) const;

    [[nodiscard]] std::uint64_t directory_bytes() const { return (block_count_ * offset_bits_ + 7) / 8; }
    [[nodiscard]] std::uint64_t block_bytes() const { return (block_bit_count_ + 7) / 8; }

private:
    [[nodiscard]] run_block::Reader block(std::uint64_t number) const;

    run_block::Shape shape_{};
    std::uint64_t entry_count_ = 0, block_count_ = 0, block_bit_count_ = 0;
    std::uint32_t offset_bits_ = 0;
    run_patterns::Reader patterns_;
    const std::uint8_t *directory_ = nullptr, *blocks_ = nullptr;
};
} // namespace tyndall::voxel_dag
