// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/run_array.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/byte_sections.hpp"
#include "voxel_dag/fingerprint.hpp"
#include <string>
#include <unordered_set>

namespace tyndall::voxel_dag {
static constexpr std::uint32_t magic = 0x32415254, old_magic = 0x31415254; // "TRA2", "TRA1"
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

/// How often groups of 16 entries look alike, of those that have changes; blocks of equal contents count once.
static std::unordered_map<run_patterns::Pattern, std::uint64_t>
count_patterns(std::span<const std::uint32_t> values, std::size_t block_entries, const Progress& progress) {
    constexpr std::size_t part_count = 64; // tables of their own, side by side
    const std::size_t block_count = (values.size() + block_entries - 1) / block_entries;
    const auto block = [&](std::size_t number) {
        return values.subspan(number * block_entries, std::min(block_entries, values.size() - number * block_entries));
    };
    std::vector<std::uint64_t> prints(block_count);
    const auto find_print = [&](std::size_t number) {
        Fingerprint print;
        print.add(std::as_bytes(block(number)));
        prints[number] = print.value()[0];
    };
    parallel_for(block_count, progress, find_print, 64);
    std::vector<std::size_t> different;
    std::unordered_set<std::uint64_t> known;
    for (std::size_t number = 0; number < block_count; ++number)
        if (known.insert(prints[number]).second)
            different.push_back(number);
    std::vector<std::unordered_map<run_patterns::Pattern, std::uint64_t>> of_parts(part_count);
    const auto count = [&](std::size_t part) {
        for (std::size_t i = part * different.size() / part_count; i < (part + 1) * different.size() / part_count; ++i)
            for (const run_patterns::Pattern pattern : run_block::runs_of(block(different[i])).groups)
                if (pattern != 0)
                    ++of_parts[part][pattern];
    };
    parallel_for(part_count, progress, count, 1);
    for (std::size_t part = 1; part < part_count; ++part)
        for (const auto& [pattern, uses] : of_parts[part])
            of_parts[0][pattern] += uses;
    return std::move(of_parts[0]);
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
    const run_patterns::Table patterns = run_patterns::best_table(count_patterns(values, block_entries, progress));
    const run_patterns::Writer pattern_writer(patterns);
    BitPacker blocks;
    std::vector<std::uint64_t> offsets;
    std::unordered_map<std::string, std::uint64_t> offset_of; // of equal blocks; a block's bytes say where it ends
    std::vector<Packed> packed(std::min(blocks_at_once, block_count));
    for (std::size_t first = 0; first < block_count; first += blocks_at_once) {
        const std::size_t count = std::min(blocks_at_once, block_count - first);
        const auto pack = [&](std::size_t i) {
            const std::size_t begin = (first + i) * block_entries;
            BitPacker bits;
            run_block::append(values.subspan(begin, std::min(block_entries, values.size() - begin)), shape,
                              pattern_writer, bits);
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
    for (const std::uint32_t width : patterns.widths)
        writer.number(width);
    writer.number(static_cast<std::uint32_t>(patterns.patterns.size()));
    BitPacker digits;
    for (const run_patterns::Pattern pattern : patterns.patterns)
        digits.append(run_patterns::digits_of(pattern), run_patterns::digit_bits);
    writer.packed(digits);
    BitPacker directory;
    for (const std::uint64_t offset : offsets)
        directory.append(offset, bits_for(blocks.bit_count()));
    writer.packed(directory);
    writer.packed(blocks);
    return writer.finish();
}

RunArray::RunArray(std::span<const std::uint8_t> bytes) {
    SectionReader reader(bytes, "run array");
    const auto mark = reader.number<std::uint32_t>("header");
    reader.check(mark != old_magic, "header", "is of an older version, which is not read: make the file again");
    reader.check(mark == magic, "header", "does not begin with its mark");
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
    run_patterns::Table table;
    for (std::uint32_t& width : table.widths) {
        width = reader.number<std::uint32_t>("header");
        reader.check(width <= run_patterns::Table::most_width, "header", "has patterns of ", width, " bits");
    }
    const auto pattern_count = reader.number<std::uint32_t>("header");
    const std::uint64_t rank_count = std::uint64_t{table.begins().back()} + (std::uint64_t{1} << table.widths.back());
    reader.check(pattern_count <= rank_count, "header", "has ", pattern_count, " patterns; there are ranks for ",
                 rank_count);
    const auto patterns = reader.take_packed(pattern_count, run_patterns::digit_bits, "patterns");
    const auto directory = reader.take_packed(block_count_, offset_bits_, "directory");
    const auto blocks = reader.take_packed(block_bit_count_, 1, "blocks");
    reader.finish();
    for (std::uint64_t rank = 0; rank < pattern_count; ++rank) {
        const std::uint64_t digits =
            read_bits(patterns.data(), rank * run_patterns::digit_bits, run_patterns::digit_bits);
        reader.check(digits < run_patterns::digit_count, "patterns", "has a number that pattern ", rank, " is not");
        table.patterns.push_back(run_patterns::pattern_of(static_cast<std::uint32_t>(digits)));
    }
    patterns_ = run_patterns::Reader(table);
    directory_ = directory.data(), blocks_ = blocks.data();
    for (std::uint64_t i = 0; i < block_count_; ++i) {
        reader.check(read_bits(directory_, i * offset_bits_, offset_bits_) < block_bit_count_, "directory",
                     "has block ", i, " behind the last");
        if (const char* const part = block(i).damage())
            reader.check(false, "blocks", "has block ", i, " with damaged ", part);
    }
}

run_block::Reader RunArray::block(std::uint64_t number) const {
    return {blocks_, read_bits(directory_, number * offset_bits_, offset_bits_), block_bit_count_, shape_, patterns_};
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
