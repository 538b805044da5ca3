// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/run_array.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/byte_sections.hpp"
#include <string>
#include <unordered_map>

namespace tyndall::voxel_dag {
static constexpr std::uint32_t magic = 0x31415254; // "TRA1"
static constexpr std::uint32_t least_log2_entries = 9, most_log2_entries = 12;
static constexpr std::size_t blocks_at_once = 4096; // packed side by side, then sifted in their order

namespace {
struct Packed {
    std::vector<std::uint8_t> bytes;
    std::uint64_t bit_count;
};
} // namespace

static std::uint64_t count_of_blocks(std::uint64_t entry_count, std::uint32_t log2_entries) {
    return (entry_count >> log2_entries) + ((entry_count & low_bits(log2_entries)) != 0);
}

std::vector<std::uint8_t> run_array::encode(std::span<const std::uint32_t> values, const Config& config,
                                            const Progress& progress) {
    const std::uint32_t log2_entries = config.log2_block_entries;
    require(least_log2_entries <= log2_entries && log2_entries <= most_log2_entries, "log2_block_entries is ",
            log2_entries, ", outside [", least_log2_entries, ", ", most_log2_entries, "]");
    const std::uint32_t largest = values.empty() ? 0 : std::ranges::max(values);
    const run_block::Shape shape{log2_entries, bits_for(std::uint64_t{largest} + 1)};
    const auto block_count = static_cast<std::size_t>(count_of_blocks(values.size(), log2_entries));
    const std::size_t block_entries = std::size_t{1} << log2_entries;
    BitPacker blocks;
    std::vector<std::uint64_t> offsets;
    std::unordered_map<std::string, std::uint64_t> offset_of; // of equal blocks; a block's bytes say where it ends
    std::vector<Packed> packed(std::min(blocks_at_once, block_count));
    for (std::size_t first = 0; first < block_count; first += blocks_at_once) {
        const std::size_t count = std::min(blocks_at_once, block_count - first);
        const auto pack = [&](std::size_t i) {
            const std::size_t begin = (first + i) * block_entries;
            BitPacker bits;
            run_block::append(values.subspan(begin, std::min(block_entries, values.size() - begin)), shape, bits);
            packed[i].bit_count = bits.bit_count();
            packed[i].bytes = bits.take();
        };
        parallel_for(count, progress, pack, 64);
        for (std::size_t i = 0; i < count; ++i) {
            const auto [bytes, bit_count] = std::move(packed[i]);
            const auto [known, is_new] =
                offset_of.try_emplace(std::string(bytes.begin(), bytes.end()), blocks.bit_count());
            offsets.push_back(known->second);
            if (is_new)
                blocks.append_bits(bytes, bit_count);
        }
    }
    SectionWriter writer;
    writer.number(magic);
    writer.number(log2_entries);
    writer.number(shape.value_bits);
    writer.number(std::uint64_t{values.size()});
    writer.number(blocks.bit_count());
    BitPacker directory;
    for (const std::uint64_t offset : offsets)
        directory.append(offset, bits_for(blocks.bit_count()));
    writer.packed(directory);
    writer.packed(blocks);
    return writer.finish();
}

RunArray::RunArray(std::span<const std::uint8_t> bytes) {
    SectionReader reader(bytes, "run array");
    reader.check(reader.number<std::uint32_t>("header") == magic, "header", "does not begin with its mark");
    shape_.log2_entries = reader.number<std::uint32_t>("header");
    shape_.value_bits = reader.number<std::uint32_t>("header");
    entry_count_ = reader.number<std::uint64_t>("header");
    block_bit_count_ = reader.number<std::uint64_t>("header");
    reader.check(least_log2_entries <= shape_.log2_entries && shape_.log2_entries <= most_log2_entries, "header",
                 "has blocks of 2^", shape_.log2_entries, " entries");
    reader.check(shape_.value_bits <= 32, "header", "has values of ", shape_.value_bits, " bits");
    block_count_ = count_of_blocks(entry_count_, shape_.log2_entries);
    offset_bits_ = bits_for(block_bit_count_);
    reader.check((block_bit_count_ == 0) == (block_count_ == 0), "header", "has ", block_count_, " blocks in ",
                 block_bit_count_, " bits");
    // Blocks that are all equal need no bits of directory: without this, a damaged header could claim any number.
    reader.check(offset_bits_ > 0 || block_count_ == 0, "header", "has blocks of 1 bit");
    const auto directory = reader.take_packed(block_count_, offset_bits_, "directory");
    const auto blocks = reader.take_packed(block_bit_count_, 1, "blocks");
    reader.finish();
    directory_ = directory.data(), blocks_ = blocks.data();
    for (std::uint64_t i = 0; i < block_count_; ++i) {
        reader.check(read_bits(directory_, i * offset_bits_, offset_bits_) < block_bit_count_, "directory",
                     "has block ", i, " behind the last");
        if (const char* const part = block(i).damage())
            reader.check(false, "blocks", "has block ", i, " with damaged ", part);
    }
}

run_block::Reader RunArray::block(std::uint64_t number) const {
    return {blocks_, read_bits(directory_, number * offset_bits_, offset_bits_), block_bit_count_, shape_};
}
std::uint32_t RunArray::at(std::uint64_t entry) const {
    return block(entry >> shape_.log2_entries).at(static_cast<std::uint32_t>(entry & low_bits(shape_.log2_entries)));
}

void RunArray::decode(std::uint64_t begin, std::span<std::uint32_t> values) const {
    const std::uint64_t block_entries = std::uint64_t{1} << shape_.log2_entries;
    std::vector<std::uint32_t> whole(static_cast<std::size_t>(block_entries)); // for blocks that begin before `begin`
    for (std::size_t done = 0; done < values.size();) {
        const std::uint64_t entry = begin + done, number = entry >> shape_.log2_entries;
        const auto skipped = static_cast<std::size_t>(entry & (block_entries - 1));
        const std::size_t count = std::min(whole.size() - skipped, values.size() - done);
        if (skipped == 0) {
            block(number).decode(values.subspan(done, count));
        } else {
            block(number).decode(std::span(whole).first(skipped + count));
            std::copy_n(whole.begin() + static_cast<std::ptrdiff_t>(skipped), count,
                        values.begin() + static_cast<std::ptrdiff_t>(done));
        }
        done += count;
    }
}
} // namespace tyndall::voxel_dag
