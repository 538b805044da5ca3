// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/first_use.hpp"
#include "core/parallel.hpp"
#include <atomic>

namespace tyndall::voxel_dag {
static constexpr std::size_t block_size = 1 << 14;

static void keep_smallest(std::uint32_t& kept, std::uint32_t position) {
    const std::atomic_ref shared(kept);
    std::uint32_t seen = shared.load(std::memory_order_relaxed);
    while (position < seen && !shared.compare_exchange_weak(seen, position, std::memory_order_relaxed)) {
    }
}

std::vector<std::uint32_t> number_by_first_use(std::span<std::uint32_t> references, std::size_t name_count,
                                               const Progress& progress) {
    std::vector<std::uint32_t> first(name_count, ~std::uint32_t{0});
    parallel_for(
        references.size(), progress,
        [&](std::size_t i) { keep_smallest(first[references[i]], static_cast<std::uint32_t>(i)); }, block_size);

    std::vector<std::vector<std::uint32_t>> firsts((references.size() + block_size - 1) / block_size);
    parallel_for(
        references.size(), progress,
        [&](std::size_t i) {
            if (first[references[i]] == i)
                firsts[i / block_size].push_back(references[i]);
        },
        block_size);

    std::vector<std::size_t> begins(firsts.size() + 1, 0);
    for (std::size_t block = 0; block < firsts.size(); ++block)
        begins[block + 1] = begins[block] + firsts[block].size();
    std::vector<std::uint32_t> names(begins.back());
    // What was the first position of a name is its number from here on.
    parallel_for(
        firsts.size(), progress,
        [&](std::size_t block) {
            for (std::size_t i = 0; i < firsts[block].size(); ++i) {
                names[begins[block] + i] = firsts[block][i];
                first[firsts[block][i]] = static_cast<std::uint32_t>(begins[block] + i);
            }
        },
        1);
    parallel_for(
        references.size(), progress, [&](std::size_t i) { references[i] = first[references[i]]; }, block_size);
    return names;
}
} // namespace tyndall::voxel_dag
