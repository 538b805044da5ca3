// SPDX-License-Identifier: GPL-3.0-or-later
// Tiles of images that lie in a file, as many of them in memory as a budget allows.
// Based on: Corbato, A Paging Experiment with the Multics System, 1968 (clock); Boehm, Can Seqlocks Get Along with
//           Programming Language Memory Models?, MSPC 2012.
// Differs:  who reads a tile that is in memory takes no lock and writes nothing but, once, that it was used; what it read
//           counts if the slot's version is the same before and after. Words of a slot are read and written by
//           acquire and release, which cost nothing on x86 and are no fences, of which the thread sanitizer knows nothing.
//           Clocks are per shard. A tile is read from its file outside of locks, so two threads may both read it.
// Bound:    per texel that is in memory 4 loads besides its own; 4 bytes per tile of all images, beside the budget.
#pragma once
#include "image/texel_file.hpp"
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace tyndall {
class TileCache {
public:
    static constexpr std::size_t tile_words = 4096; ///< Of 32 bits.
    static constexpr std::size_t tile_bytes = 4 * tile_words;
    /// In which slot a tile was last; it may have gone.
    using Place = std::atomic<std::uint32_t>;

    struct Counts {
        std::uint64_t tiles_read = 0; ///< From the file.
        std::uint64_t resident_bytes = 0, budget_bytes = 0;
    };

    /// A file in `folder`, and slots for tiles: at least one. Throws IoError, which names the folder.
    TileCache(std::filesystem::path folder, std::size_t budget_bytes);

    [[nodiscard]] TexelFile& file() { return file_; }
    /// Another one than any image of this cache has had.
    [[nodiscard]] std::uint32_t next_image() { return next_image_.fetch_add(1, std::memory_order_relaxed); }
    /// Words of tile `tile` of an image, whose tiles lie from `file_place` on.
    template <std::size_t Count>
    std::array<std::uint32_t, Count> words(std::uint32_t image, std::uint64_t file_place, std::uint32_t tile,
                                           Place& place, std::size_t first_word);
    [[nodiscard]] Counts counts() const;
    /// Throws IoError where a tile could not be read since the last call; its texels were 0.
    void require_whole();

private:
    static constexpr std::uint64_t no_owner = ~std::uint64_t{0};
    struct alignas(64) Slot {
        std::atomic<std::uint32_t> version{0}; ///< Odd: being written.
        std::atomic<bool> was_used{false};
        std::atomic<std::uint64_t> owner{no_owner};
    };
    struct alignas(64) Shard {
        std::mutex filling;
        std::uint32_t first_slot = 0, slot_count = 0, hand = 0;
        std::uint32_t filled_count = 0;
    };
    using Tile = std::array<std::uint32_t, tile_words>;

    static std::uint64_t owner_of(std::uint32_t image, std::uint32_t tile) { return std::uint64_t{image} << 32 | tile; }
    std::atomic_ref<std::uint32_t> word(std::uint32_t slot, std::size_t index) {
        return std::atomic_ref(words_[slot * tile_words + index]);
    }
    template <std::size_t Count>
    bool find(std::uint64_t owner, const Place& place, std::size_t first_word, std::array<std::uint32_t, Count>& found);
    /// The tile, in memory of the calling thread.
    const Tile& read(std::uint64_t owner, std::uint64_t file_place, Place& place);
    void keep(std::uint64_t owner, const Tile& tile, Place& place);
    std::uint32_t freed_slot(Shard& shard);

    TexelFile file_;
    std::uint32_t slot_count_;
    std::vector<Slot> slots_;
    std::vector<Shard> shards_;
    std::unique_ptr<std::uint32_t[]> words_; // untouched memory takes no room
    std::atomic<std::uint32_t> next_image_{0};
    std::atomic<std::uint64_t> tiles_read_{0};
    std::atomic<int> read_error_{0};
};

template <std::size_t Count>
bool TileCache::find(std::uint64_t owner, const Place& place, std::size_t first_word,
                     std::array<std::uint32_t, Count>& found) {
    const std::uint32_t index = place.load(std::memory_order_relaxed);
    if (index >= slot_count_)
        return false;
    Slot& slot = slots_[index];
    const std::uint32_t version = slot.version.load(std::memory_order_acquire);
    if ((version & 1) != 0 || slot.owner.load(std::memory_order_acquire) != owner)
        return false;
    for (std::size_t i = 0; i < Count; ++i)
        found[i] = word(index, first_word + i).load(std::memory_order_acquire);
    if (slot.version.load(std::memory_order_relaxed) != version)
        return false;
    if (!slot.was_used.load(std::memory_order_relaxed))
        slot.was_used.store(true, std::memory_order_relaxed);
    return true;
}

template <std::size_t Count>
std::array<std::uint32_t, Count> TileCache::words(std::uint32_t image, std::uint64_t file_place, std::uint32_t tile,
                                                  Place& place, std::size_t first_word) {
    const std::uint64_t owner = owner_of(image, tile);
    std::array<std::uint32_t, Count> found;
    if (find(owner, place, first_word, found)) [[likely]]
        return found;
    const Tile& whole = read(owner, file_place + std::uint64_t{tile} * tile_bytes, place);
    for (std::size_t i = 0; i < Count; ++i)
        found[i] = whole[first_word + i];
    return found;
}
} // namespace tyndall
