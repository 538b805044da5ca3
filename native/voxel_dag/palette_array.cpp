// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/palette_array.hpp"
#include "core/random.hpp"
#include "voxel_dag/byte_sections.hpp"
#include "voxel_dag/material_indices.hpp"
#include <algorithm>
#include <unordered_map>

namespace tyndall::voxel_dag {
static constexpr std::uint32_t palette_mark = 0x31415054; // "TPA1"
static constexpr std::uint32_t index_width_bits = 4;      // holds [0, 8]
static constexpr std::uint32_t most_index_bits = 8;

namespace {
/// All palettes one behind the other, each once.
class PalettePool {
public:
    explicit PalettePool(std::size_t material_count) : slot_(material_count) {}

    /// Place of the block's palette; slot() says then where in it a material is.
    std::uint32_t place(std::span<const std::uint32_t> block) {
        palette_.clear();
        ++stamp_;
        for (const std::uint32_t material : block)
            if (slot_[material].stamp != stamp_) {
                slot_[material].stamp = stamp_;
                palette_.push_back(material);
            }
        std::ranges::sort(palette_);
        std::uint64_t key = palette_.size();
        for (std::uint32_t i = 0; i < palette_.size(); ++i) {
            slot_[palette_[i]].in_palette = i;
            key = (key ^ hash(palette_[i])) * 0x9e3779b97f4a7c15u;
            key ^= key >> 29;
        }
        const auto [first, last] = known_.equal_range(key);
        for (auto it = first; it != last; ++it)
            if (std::ranges::equal(std::span(entries_).subspan(it->second.begin, it->second.size), palette_))
                return it->second.begin;
        const auto begin = static_cast<std::uint32_t>(entries_.size());
        known_.emplace(key, Place{begin, static_cast<std::uint32_t>(palette_.size())});
        entries_.insert(entries_.end(), palette_.begin(), palette_.end());
        return begin;
    }
    std::uint32_t slot(std::uint32_t material) const { return slot_[material].in_palette; }
    std::uint32_t count() const { return static_cast<std::uint32_t>(known_.size()); }
    /// With zeros, so that whatever index of a block's width leads into the pool.
    std::vector<std::uint32_t> take(std::size_t least_size) {
        if (entries_.size() < least_size)
            entries_.resize(least_size);
        return std::move(entries_);
    }

private:
    struct Place {
        std::uint32_t begin, size;
    };
    struct Slot {
        std::uint32_t stamp = 0, in_palette = 0;
    };
    std::vector<std::uint32_t> entries_, palette_;
    std::unordered_multimap<std::uint64_t, Place> known_;
    std::vector<Slot> slot_;
    std::uint32_t stamp_ = 0;
};
} // namespace

static void append_indices(std::span<const std::uint32_t> block, std::uint32_t index_bits, const PalettePool& pool,
                           BitPacker& indices) {
    for (std::size_t i = 0; i < block.size() && index_bits > 0;) {
        std::size_t end = i + 1;
        while (end < block.size() && block[end] == block[i])
            ++end;
        indices.append_run(pool.slot(block[i]), index_bits, end - i);
        i = end;
    }
}

std::vector<std::uint8_t> encode_palettes(std::span<const std::uint32_t> values, const palette_blocks::Config& config,
                                          const Progress& progress) {
    const auto [materials, entries] = material_indices_of(values, progress);
    const auto material_count = static_cast<std::uint32_t>(materials.size());
    const auto blocks = palette_blocks::partition(entries, material_count, config, progress);
    PalettePool pool(material_count);
    BitPacker indices;
    struct Placed {
        std::uint64_t palette, first_bit;
    };
    std::vector<Placed> placed;
    std::size_t pool_size = 0;
    for (const palette_blocks::Block& block : blocks) {
        progress.poll();
        const auto of_block = std::span(entries).subspan(block.begin, block.entry_count);
        placed.push_back({pool.place(of_block), indices.bit_count()});
        pool_size = std::max(pool_size, placed.back().palette + (std::size_t{1} << block.index_bits));
        append_indices(of_block, block.index_bits, pool, indices);
    }
    const std::uint32_t palette_count = pool.count();
    const std::vector<std::uint32_t> palettes = pool.take(pool_size);
    const std::uint32_t value_bits = materials.empty() ? 0 : bits_for(std::uint64_t{materials.back()} + 1);
    const std::uint64_t index_bit_count = indices.bit_count();

    SectionWriter writer;
    writer.number(palette_mark);
    writer.number(static_cast<std::uint32_t>(values.size()));
    writer.number(material_count);
    writer.number(value_bits);
    writer.number(static_cast<std::uint32_t>(blocks.size()));
    writer.number(palette_count);
    writer.number(std::uint64_t{palettes.size()});
    writer.number(index_bit_count);
    BitPacker bits;
    for (const std::uint32_t material : materials)
        bits.append(material, value_bits);
    writer.packed(bits);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        bits.append(blocks[i].begin, bits_for(values.size()));
        bits.append(placed[i].palette, bits_for(palettes.size()));
        bits.append(placed[i].first_bit, bits_for(index_bit_count + 1));
        bits.append(blocks[i].index_bits, index_width_bits);
    }
    writer.packed(bits);
    for (const std::uint32_t material : palettes)
        bits.append(material, bits_for(material_count));
    writer.packed(bits);
    writer.packed(indices);
    return writer.finish();
}

PaletteArray::PaletteArray(std::span<const std::uint8_t> bytes) {
    SectionReader reader(bytes, "palette array");
    reader.check(reader.number<std::uint32_t>("header") == palette_mark, "header", "does not begin with its mark");
    entry_count_ = reader.number<std::uint32_t>("header");
    material_count_ = reader.number<std::uint32_t>("header");
    value_bits_ = reader.number<std::uint32_t>("header");
    block_count_ = reader.number<std::uint32_t>("header");
    parts_.block_count = block_count_;
    parts_.palette_count = reader.number<std::uint32_t>("header");
    palette_entry_count_ = reader.number<std::uint64_t>("header");
    index_bit_count_ = reader.number<std::uint64_t>("header");
    reader.check(value_bits_ <= 32, "header", "has values of ", value_bits_, " bits");
    reader.check((block_count_ == 0) == (entry_count_ == 0), "header", "has ", block_count_, " blocks for ",
                 entry_count_, " entries");
    offset_bits_ = bits_for(index_bit_count_ + 1);
    palette_bits_ = bits_for(palette_entry_count_);
    reader.check(offset_bits_ <= 48 && palette_bits_ <= 48, "header", "has sizes beyond 2^48");
    entry_bits_ = bits_for(entry_count_);
    material_bits_ = bits_for(material_count_);
    const auto materials = reader.take_packed(material_count_, value_bits_, "materials");
    const std::uint32_t directory_bits = entry_bits_ + palette_bits_ + offset_bits_ + index_width_bits;
    const auto directory = reader.take((block_count_ * directory_bits + 7) / 8, "directory");
    const auto palettes = reader.take_packed(palette_entry_count_, material_bits_, "palettes");
    const auto indices = reader.take_packed(index_bit_count_, 1, "indices");
    reader.finish();
    materials_ = materials.data(), directory_ = directory.data(), palettes_ = palettes.data();
    indices_ = indices.data();
    parts_.material_bytes = materials.size(), parts_.directory_bytes = directory.size();
    parts_.palette_bytes = palettes.size(), parts_.index_bytes = indices.size();

    for (std::uint64_t i = 0; i < block_count_; ++i) {
        const Block at = block(i);
        const std::uint64_t end = i + 1 < block_count_ ? first_entry(i + 1) : entry_count_;
        reader.check(i > 0 || at.first_entry == 0, "directory", "begins with entry ", at.first_entry);
        reader.check(at.first_entry < end && end <= entry_count_, "directory", "has block ", i, " from entry ",
                     at.first_entry, " to ", end, " of ", entry_count_);
        reader.check(at.index_bits <= most_index_bits, "directory", "has indices of ", at.index_bits, " bits in block ",
                     i);
        reader.check(at.first_in_palettes + (std::uint64_t{1} << at.index_bits) <= palette_entry_count_, "directory",
                     "has a palette of block ", i, " that ends behind the last");
        reader.check(at.first_bit + (end - at.first_entry) * at.index_bits <= index_bit_count_, "directory",
                     "has indices of block ", i, " that end behind the last");
    }
    reader.check(material_count_ > 0 || entry_count_ == 0, "materials", "has none for ", entry_count_, " entries");
    for (std::uint64_t i = 0; i < palette_entry_count_ && material_bits_ > 0; ++i) // no bits: all are the one material
        reader.check(read_bits(palettes_, i * material_bits_, material_bits_) < material_count_, "palettes", "entry ",
                     i, " is no material");
}

std::uint64_t PaletteArray::first_entry(std::uint64_t block) const {
    return read_bits(directory_, block * (entry_bits_ + palette_bits_ + offset_bits_ + index_width_bits), entry_bits_);
}
PaletteArray::Block PaletteArray::block(std::uint64_t number) const {
    std::uint64_t bit = number * (entry_bits_ + palette_bits_ + offset_bits_ + index_width_bits);
    const auto field = [&](std::uint32_t width) {
        const std::uint64_t value = read_bits(directory_, bit, width);
        bit += width;
        return value;
    };
    Block block{};
    block.first_entry = field(entry_bits_);
    block.first_in_palettes = field(palette_bits_);
    block.first_bit = field(offset_bits_);
    block.index_bits = static_cast<std::uint32_t>(field(index_width_bits));
    return block;
}
std::uint64_t PaletteArray::block_of(std::uint64_t entry) const {
    std::uint64_t begin = 0, end = block_count_; // the last block that does not begin behind the entry
    while (end - begin > 1) {
        const std::uint64_t middle = begin + (end - begin) / 2;
        (first_entry(middle) <= entry ? begin : end) = middle;
    }
    return begin;
}
std::uint32_t PaletteArray::value(const Block& block, std::uint64_t entry) const {
    const std::uint64_t index =
        read_bits(indices_, block.first_bit + (entry - block.first_entry) * block.index_bits, block.index_bits);
    const std::uint64_t material =
        read_bits(palettes_, (block.first_in_palettes + index) * material_bits_, material_bits_);
    return static_cast<std::uint32_t>(read_bits(materials_, material * value_bits_, value_bits_));
}
std::uint32_t PaletteArray::at(std::uint32_t entry) const { return value(block(block_of(entry)), entry); }

void PaletteArray::decode(std::uint32_t begin, std::span<std::uint32_t> values) const {
    const std::uint64_t end = std::uint64_t{begin} + values.size();
    for (std::uint64_t entry = begin, number = block_of(begin); entry < end; ++number) {
        const Block of_entry = block(number);
        const std::uint64_t block_end = number + 1 < block_count_ ? std::min(end, first_entry(number + 1)) : end;
        for (; entry < block_end; ++entry)
            values[static_cast<std::size_t>(entry - begin)] = value(of_entry, entry);
    }
}
} // namespace tyndall::voxel_dag
