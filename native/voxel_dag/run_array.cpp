// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/run_array.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/byte_sections.hpp"
#include "voxel_dag/fingerprint.hpp"
#include <algorithm>
#include <cstring>

namespace tyndall::voxel_dag {
static constexpr std::uint32_t runs_mark = 0x33415254; // "TRA3"
static constexpr std::array<std::uint32_t, 2> old_runs_marks{0x31415254, 0x32415254};
static constexpr std::uint32_t least_log2_entries = 9, most_log2_entries = 12;
static constexpr std::size_t packed_at_once = 4096; // packed side by side, then sifted in their order
/// Beyond, blocks are stored whether or not they are known: the memory that knowing takes is bounded.
static constexpr std::size_t most_known_blocks = std::size_t{1} << 20;

static std::uint64_t count_of_blocks(std::uint64_t entry_count, std::uint32_t log2_entries) {
    return (entry_count >> log2_entries) + ((entry_count & low_bits(log2_entries)) != 0);
}
static std::uint64_t whole_bytes(std::uint64_t bit_count) { return (bit_count + 7) / 8; }

namespace run_array {
Encoder::Encoder(const Config& config, std::uint32_t value_bits, SpilledBytes blocks, SpilledBytes offsets)
    : shape_{config.log2_block_entries, value_bits}, blocks_(std::move(blocks)), offsets_(std::move(offsets)) {
    require(least_log2_entries <= shape_.log2_entries && shape_.log2_entries <= most_log2_entries,
            "log2_block_entries is ", shape_.log2_entries, ", outside [", least_log2_entries, ", ", most_log2_entries,
            "]");
}

template <class Use>
void Encoder::in_blocks(std::span<const std::uint32_t> values, const Use& use) {
    const std::size_t block_entries = std::size_t{1} << shape_.log2_entries;
    if (!rest_.empty()) {
        const auto lacking = values.first(std::min(values.size(), block_entries - rest_.size()));
        rest_.insert(rest_.end(), lacking.begin(), lacking.end());
        values = values.subspan(lacking.size());
        if (rest_.size() < block_entries)
            return;
        use(rest_);
        rest_.clear();
    }
    const std::size_t whole = values.size() >> shape_.log2_entries << shape_.log2_entries;
    use(values.first(whole));
    rest_.assign(values.begin() + static_cast<std::ptrdiff_t>(whole), values.end());
}

void Encoder::learn(std::span<const std::uint32_t> values, const Progress& progress) {
    in_blocks(values, [&](std::span<const std::uint32_t> blocks) { count_patterns(blocks, progress); });
}

/// How often groups of 16 entries look alike, of those that have changes; blocks of equal contents count once.
void Encoder::count_patterns(std::span<const std::uint32_t> values, const Progress& progress) {
    constexpr std::size_t part_count = 64; // tables of their own, side by side
    const std::size_t block_entries = std::size_t{1} << shape_.log2_entries;
    const auto block_count = static_cast<std::size_t>(count_of_blocks(values.size(), shape_.log2_entries));
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
    for (std::size_t number = 0; number < block_count; ++number)
        if (learnt_blocks_.size() >= most_known_blocks ? !learnt_blocks_.contains(prints[number])
                                                       : learnt_blocks_.insert(prints[number]).second)
            different.push_back(number);
    std::vector<std::unordered_map<run_patterns::Pattern, std::uint64_t>> of_parts(part_count);
    const auto count = [&](std::size_t part) {
        for (std::size_t i = part * different.size() / part_count; i < (part + 1) * different.size() / part_count; ++i)
            for (const run_patterns::Pattern pattern : run_block::runs_of(block(different[i])).groups)
                if (pattern != 0)
                    ++of_parts[part][pattern];
    };
    parallel_for(part_count, progress, count, 1);
    for (const auto& of_part : of_parts)
        for (const auto& [pattern, uses] : of_part)
            pattern_counts_[pattern] += uses;
}

void Encoder::choose_codes(const Progress& progress) {
    if (patterns_)
        return;
    count_patterns(rest_, progress);
    rest_.clear();
    patterns_ = run_patterns::best_table(pattern_counts_);
    pattern_writer_.emplace(*patterns_);
    pattern_counts_ = {};
    learnt_blocks_ = {};
}

void Encoder::add(std::span<const std::uint32_t> values, const Progress& progress) {
    choose_codes(progress);
    entry_count_ += values.size();
    in_blocks(values, [&](std::span<const std::uint32_t> blocks) { pack(blocks, progress); });
}

void Encoder::finish(const Progress& progress) {
    choose_codes(progress);
    pack(rest_, progress);
    rest_.clear();
    block_bit_count_ += bits_.bit_count();
    blocks_.append(bits_.take());
}

void Encoder::pack(std::span<const std::uint32_t> values, const Progress& progress) {
    const std::size_t block_entries = std::size_t{1} << shape_.log2_entries;
    const auto block_count = static_cast<std::size_t>(count_of_blocks(values.size(), shape_.log2_entries));
    packed_.resize(std::max(packed_.size(), std::min(packed_at_once, block_count)));
    for (std::size_t first = 0; first < block_count; first += packed_at_once) {
        const std::size_t count = std::min(packed_at_once, block_count - first);
        const auto pack_one = [&](std::size_t i) {
            const std::size_t begin = (first + i) * block_entries;
            BitPacker bits;
            run_block::append(values.subspan(begin, std::min(block_entries, values.size() - begin)), shape_,
                              *pattern_writer_, bits);
            packed_[i].bit_count = bits.bit_count();
            packed_[i].bytes = bits.take();
        };
        parallel_for(count, progress, pack_one, 64);
        for (std::size_t i = 0; i < count; ++i)
            append(packed_[i]);
    }
}

void Encoder::append(const Packed& block) {
    Fingerprint fingerprint;
    fingerprint.add(std::as_bytes(std::span(block.bytes)));
    std::uint64_t offset = block_bit_count_ + bits_.bit_count();
    const auto known = offset_of_.find(fingerprint.value());
    const bool is_known = known != offset_of_.end();
    if (is_known)
        offset = known->second;
    std::array<std::uint8_t, sizeof(offset)> bytes;
    std::memcpy(bytes.data(), &offset, sizeof(offset));
    offsets_.append(bytes);
    if (is_known)
        return;
    if (offset_of_.size() < most_known_blocks)
        offset_of_.emplace(fingerprint.value(), offset);
    bits_.append_bits(block.bytes, block.bit_count);
    const std::vector<std::uint8_t> words = bits_.take_words();
    block_bit_count_ += 8 * words.size();
    blocks_.append(words);
}

std::uint64_t Encoder::byte_count() const {
    const std::uint64_t block_count = offsets_.size() / sizeof(std::uint64_t);
    return header().size() + whole_bytes(block_count * bits_for(block_bit_count_)) + whole_bytes(block_bit_count_) +
           bit_slack_bytes;
}

std::vector<std::uint8_t> Encoder::header() const {
    SectionWriter writer;
    writer.number(runs_mark);
    writer.number(shape_.log2_entries);
    writer.number(shape_.value_bits);
    writer.number(entry_count_);
    writer.number(block_bit_count_);
    for (const std::uint32_t width : patterns_->widths)
        writer.number(width);
    writer.number(static_cast<std::uint32_t>(patterns_->patterns.size()));
    writer.number(patterns_->narrow_width);
    writer.number(static_cast<std::uint32_t>(patterns_->halves.size()));
    BitPacker patterns, halves;
    for (const run_patterns::Pattern pattern : patterns_->patterns)
        patterns.append(run_patterns::digits_of(pattern), run_patterns::digit_bits);
    for (const std::uint32_t half : patterns_->halves)
        halves.append(half, run_patterns::half_bits);
    writer.packed(patterns);
    writer.packed(halves);
    std::vector<std::uint8_t> bytes = writer.finish();
    bytes.resize(bytes.size() - bit_slack_bytes); // which comes last
    return bytes;
}

void Encoder::read(const std::function<void(std::span<const std::uint8_t>)>& use) const {
    use(header());
    BitPacker directory;
    offsets_.read([&](std::span<const std::uint8_t> words) {
        for (std::size_t at = 0; at < words.size(); at += sizeof(std::uint64_t)) {
            std::uint64_t offset;
            std::memcpy(&offset, &words[at], sizeof(offset));
            directory.append(offset, bits_for(block_bit_count_));
        }
        use(directory.take_words());
    });
    use(directory.take());
    blocks_.read(use);
    use(std::array<std::uint8_t, bit_slack_bytes>{});
}

std::vector<std::uint8_t> encode(std::span<const std::uint32_t> values, const Config& config,
                                 const Progress& progress) {
    const std::uint32_t largest = values.empty() ? 0 : std::ranges::max(values);
    Encoder encoder(config, bits_for(std::uint64_t{largest} + 1));
    encoder.learn(values, progress);
    encoder.add(values, progress);
    encoder.finish(progress);
    std::vector<std::uint8_t> bytes;
    bytes.reserve(encoder.byte_count());
    encoder.read([&](std::span<const std::uint8_t> piece) { bytes.insert(bytes.end(), piece.begin(), piece.end()); });
    return bytes;
}
} // namespace run_array

static run_patterns::Table read_table(SectionReader& reader) {
    using namespace run_patterns;
    Table table;
    for (std::uint32_t& width : table.widths) {
        width = reader.number<std::uint32_t>("header");
        reader.check(width <= Table::most_width, "header", "has patterns of ", width, " bits");
    }
    const auto pattern_count = reader.number<std::uint32_t>("header");
    reader.check(pattern_count <= table.begins().back(), "header", "has ", pattern_count,
                 " patterns; there are ranks for ", table.begins().back());
    table.narrow_width = reader.number<std::uint32_t>("header");
    reader.check(table.narrow_width < half_bits, "header", "has halves of ", table.narrow_width, " bits");
    const auto half_total = reader.number<std::uint32_t>("header");
    reader.check(half_total <= 1u << table.narrow_width, "header", "has ", half_total, " halves in ",
                 table.narrow_width, " bits");
    const auto patterns = reader.take_packed(pattern_count, digit_bits, "patterns");
    const auto halves = reader.take_packed(half_total, half_bits, "halves");
    for (std::uint64_t rank = 0; rank < pattern_count; ++rank) {
        const auto digits = static_cast<std::uint32_t>(read_bits(patterns.data(), rank * digit_bits, digit_bits));
        reader.check(are_digits(digits), "patterns", "has a number that pattern ", rank, " is not");
        table.patterns.push_back(pattern_of(digits));
    }
    for (std::uint64_t rank = 0; rank < half_total; ++rank) {
        const auto digits = static_cast<std::uint32_t>(read_bits(halves.data(), rank * half_bits, half_bits));
        reader.check(digits < half_count, "halves", "has a number that half ", rank, " is not");
        table.halves.push_back(digits);
    }
    return table;
}

RunArray::RunArray(std::span<const std::uint8_t> bytes) {
    SectionReader reader(bytes, "run array");
    const auto mark = reader.number<std::uint32_t>("header");
    reader.check(std::ranges::count(old_runs_marks, mark) == 0, "header",
                 "is of an older version, which is not read: make the file again");
    reader.check(mark == runs_mark, "header", "does not begin with its mark");
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
    const run_patterns::Table table = read_table(reader);
    const auto directory = reader.take_packed(block_count_, offset_bits_, "directory");
    const auto blocks = reader.take_packed(block_bit_count_, 1, "blocks");
    reader.finish();
    patterns_ = run_patterns::Reader(table);
    directory_ = directory.data(), blocks_ = blocks.data();
    for (std::uint64_t i = 0; i < block_count_; ++i) {
        reader.check(read_bits(directory_, i * offset_bits_, offset_bits_) < block_bit_count_, "directory",
                     "has block ", i, " behind the last");
        const run_block::Reader read = block(i);
        if (const char* const part = read.damage())
            reader.check(false, "blocks", "has block ", i, " with damaged ", part);
        largest_ = std::max(largest_, read.largest());
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
