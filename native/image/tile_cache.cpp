// SPDX-License-Identifier: GPL-3.0-or-later
#include "image/tile_cache.hpp"
#include "core/partial_file.hpp"
#include <algorithm>
#include <system_error>

namespace tyndall {
static std::uint32_t slots_of(std::size_t budget_bytes) {
    return static_cast<std::uint32_t>(std::clamp<std::size_t>(budget_bytes / TileCache::tile_bytes, 1, 1u << 30));
}

TileCache::TileCache(std::filesystem::path folder, std::size_t budget_bytes)
    : file_(std::move(folder)), slot_count_(slots_of(budget_bytes)), slots_(slot_count_),
      shards_(std::clamp(slot_count_ / 8, 1u, 16u)),
      words_(std::make_unique_for_overwrite<std::uint32_t[]>(slot_count_ * tile_words)) {
    const auto shard_count = static_cast<std::uint32_t>(shards_.size());
    for (std::uint32_t index = 0; index < shard_count; ++index) {
        shards_[index].first_slot = static_cast<std::uint32_t>(std::uint64_t{slot_count_} * index / shard_count);
        const auto end = static_cast<std::uint32_t>(std::uint64_t{slot_count_} * (index + 1) / shard_count);
        shards_[index].slot_count = end - shards_[index].first_slot;
    }
}

const TileCache::Tile& TileCache::read(std::uint64_t owner, std::uint64_t file_place, Place& place) {
    thread_local Tile tile;
    if (const int error = file_.read(file_place, std::as_writable_bytes(std::span(tile))); error != 0) {
        // Lookups happen where nothing may be thrown, inside of Embree's filters: require_whole tells.
        read_error_.store(error, std::memory_order_relaxed);
        tile.fill(0);
        return tile;
    }
    tiles_read_.fetch_add(1, std::memory_order_relaxed);
    keep(owner, tile, place);
    return tile;
}

/// The first that was not used since the hand last came by.
std::uint32_t TileCache::freed_slot(Shard& shard) {
    if (shard.filled_count < shard.slot_count)
        return shard.first_slot + shard.filled_count++;
    for (std::uint32_t step = 0;; ++step) {
        const std::uint32_t slot = shard.first_slot + shard.hand;
        shard.hand = (shard.hand + 1) % shard.slot_count;
        // Others may use them all the while: after a round any will do.
        if (!slots_[slot].was_used.exchange(false, std::memory_order_relaxed) || step == shard.slot_count)
            return slot;
    }
}

void TileCache::keep(std::uint64_t owner, const Tile& tile, Place& place) {
    Shard& shard = shards_[(owner ^ owner >> 32) % shards_.size()];
    const std::lock_guard lock(shard.filling);
    const std::uint32_t known = place.load(std::memory_order_relaxed);
    if (known < slot_count_ && slots_[known].owner.load(std::memory_order_relaxed) == owner)
        return; // another thread was faster
    const std::uint32_t index = freed_slot(shard);
    Slot& slot = slots_[index];
    const std::uint32_t version = slot.version.load(std::memory_order_relaxed);
    slot.version.store(version + 1, std::memory_order_relaxed);
    slot.owner.store(owner, std::memory_order_release);
    for (std::size_t i = 0; i < tile_words; ++i)
        word(index, i).store(tile[i], std::memory_order_release);
    slot.was_used.store(true, std::memory_order_relaxed);
    slot.version.store(version + 2, std::memory_order_release);
    place.store(index, std::memory_order_relaxed);
}

TileCache::Counts TileCache::counts() const {
    std::uint64_t filled = 0;
    for (const Slot& slot : slots_)
        filled += slot.owner.load(std::memory_order_relaxed) != no_owner;
    return {.tiles_read = tiles_read_.load(std::memory_order_relaxed),
            .resident_bytes = filled * tile_bytes,
            .budget_bytes = std::uint64_t{slot_count_} * tile_bytes};
}

void TileCache::require_whole() {
    if (const int error = read_error_.exchange(0, std::memory_order_relaxed); error != 0)
        refuse_file(file_.folder(), "textures cannot be read again: " + std::generic_category().message(error));
}
} // namespace tyndall
