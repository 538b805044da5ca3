// SPDX-License-Identifier: GPL-3.0-or-later
// Pieces that are made side by side and put together in their order, one after the other, while others are still made.
// Differs from parallel_for into one result per piece: a few slots, which stay in the cache, hold what is on the way.
#pragma once
#include "core/progress.hpp"
#include <cstddef>
#include <tbb/parallel_pipeline.h>
#include <vector>

namespace tyndall {
/// make(index, slot) for each index below count, in any thread; then put(index, slot) in the order of the indices.
/// Slots are used again and again; at most as many pieces are on the way. Polls Progress before each piece.
template <typename Slot, typename Make, typename Put>
void parallel_in_order(std::size_t count, std::vector<Slot>& slots, const Progress& progress, const Make& make,
                       const Put& put) {
    std::size_t next = 0;
    // Pieces leave in order, so that those on the way are neighbours: no two of them share a slot.
    const auto slot_of = [&](std::size_t index) -> Slot& { return slots[index % slots.size()]; };
    tbb::parallel_pipeline(
        slots.size(),
        tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& control) {
            progress.poll();
            if (next == count)
                control.stop();
            return next++;
        }) & tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, [&](std::size_t index) {
            make(index, slot_of(index));
            return index;
        }) & tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, [&](std::size_t index) {
            put(index, slot_of(index));
        }));
}
} // namespace tyndall
