// SPDX-License-Identifier: GPL-3.0-or-later
// An attribute array as blocks of one length, each with its own runs and dictionary: bytes with random access.
// Differs:  from Kol 2018, section 2.4.2: the block of an entry is a shift, not a search; 73 to 93 % of neighbours are
//           equal, so that codes of runs take the place of most indices; blocks of equal contents are stored once, which a
//           palette shared between unequal blocks is not worth beside.
// Bound:    a value costs two loads of the directory and the scan of one block's codes, run_block.hpp. While values come in,
//           64 bytes for each of the first 2^20 different blocks, among which equal ones are looked for.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/run_block.hpp"
#include "voxel_dag/spilled_bytes.hpp"
#include <array>
#include <optional>
#include <unordered_map>
#include <unordered_set>

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

/// The same bytes, of values that come some at a time, and twice: codes are chosen by all of them.
class Encoder {
public:
    /// All values are below 2^value_bits, and fewer bits would not do. What becomes the bytes is gathered in the two stores,
    /// which are empty. Throws InvalidInput.
    Encoder(const Config& config, std::uint32_t value_bits, SpilledBytes blocks = {}, SpilledBytes offsets = {});
    /// All values in their order, before the first is added. Throws Cancelled.
    void learn(std::span<const std::uint32_t> values, const Progress& progress);
    /// The same again. Throws IoError where a store does, and Cancelled.
    void add(std::span<const std::uint32_t> values, const Progress& progress);
    /// After the last value.
    void finish(const Progress& progress);
    /// Of the finished array.
    [[nodiscard]] std::uint64_t byte_count() const;
    /// use(bytes), in pieces, one behind the other. Throws IoError.
    void read(const std::function<void(std::span<const std::uint8_t>)>& use) const;

private:
    struct Packed {
        std::vector<std::uint8_t> bytes;
        std::uint64_t bit_count;
    };
    using Digest = std::array<std::uint64_t, 2>;
    struct DigestHash {
        std::size_t operator()(const Digest& digest) const { return static_cast<std::size_t>(digest[0]); }
    };
    /// Whole blocks, or the last one.
    void pack(std::span<const std::uint32_t> values, const Progress& progress);
    void append(const Packed& block);
    template <class Use>
    void in_blocks(std::span<const std::uint32_t> values, const Use& use);
    void count_patterns(std::span<const std::uint32_t> values, const Progress& progress);
    void choose_codes(const Progress& progress);
    /// Of the finished array, up to its directory.
    [[nodiscard]] std::vector<std::uint8_t> header() const;

    run_block::Shape shape_;
    SpilledBytes blocks_, offsets_;
    BitPacker bits_;                                                          ///< What blocks_ does not have yet.
    std::vector<std::uint32_t> rest_;                                         ///< Less than a block.
    std::unordered_map<run_patterns::Pattern, std::uint64_t> pattern_counts_; ///< While values are learnt.
    std::unordered_set<std::uint64_t> learnt_blocks_;                         ///< Their fingerprints.
    std::optional<run_patterns::Table> patterns_;
    std::optional<run_patterns::Writer> pattern_writer_;
    std::vector<Packed> packed_;
    std::unordered_map<Digest, std::uint64_t, DigestHash>
        offset_of_; ///< Of blocks, by their bytes, which say where they end.
    std::uint64_t entry_count_ = 0, block_bit_count_ = 0;
};
} // namespace run_array

/// Reads what run_array::encode() wrote, in place: the bytes stay the caller's.
class RunArray {
public:
    /// Throws InvalidInput, which names the section that is damaged or cut off. Whatever an undetected change says then,
    /// every entry can be read.
    explicit RunArray(std::span<const std::uint8_t> bytes);

    [[nodiscard]] std::uint64_t size() const { return entry_count_; }
    /// No value is larger; 0 without values.
    [[nodiscard]] std::uint32_t largest() const { return largest_; }
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
    std::uint32_t offset_bits_ = 0, largest_ = 0;
    run_patterns::Reader patterns_;
    const std::uint8_t *directory_ = nullptr, *blocks_ = nullptr;
};
} // namespace tyndall::voxel_dag
