// SPDX-License-Identifier: GPL-3.0-or-later
// Pieces that are made side by side and put together in their order, one after the other, while others are still made.
// Differs from parallel_for into one result per piece: a few slots, which stay in the cache, hold what is on the way.
#pragma once
#include "core/progress.hpp"
#include <cstddef>
#include <utility>
#include <vector>

namespace tyndall {
namespace parallel {
void run_in_order(std::size_t count, std::size_t slot_count, const Progress& progress, const void* work,
                  void (*make)(const void* work, std::size_t index), void (*put)(const void* work, std::size_t index));
} // namespace parallel

/// make(index, slot) for each index below count, in any thread; then put(index, slot) in the order of the indices.
/// Slots are used again and again; at most as many pieces are on the way. Polls Progress before each piece.
template <typename Slot, typename Make, typename Put>
void parallel_in_order(std::size_t count, std::vector<Slot>& slots, const Progress& progress, const Make& make,
                       const Put& put) {
    // Pieces leave in order, so that those on the way are neighbours: no two of them share a slot.
    const auto make_piece = [&](std::size_t index) { make(index, slots[index % slots.size()]); };
    const auto put_piece = [&](std::size_t index) { put(index, slots[index % slots.size()]); };
    const auto work = std::pair(&make_piece, &put_piece);
    parallel::run_in_order(
        count, slots.size(), progress, &work,
        [](const void* called, std::size_t index) { (*static_cast<decltype(work)*>(called)->first)(index); },
        [](const void* called, std::size_t index) { (*static_cast<decltype(work)*>(called)->second)(index); });
}
} // namespace tyndall
