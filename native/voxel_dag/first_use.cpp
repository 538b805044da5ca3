// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/first_use.hpp"
#include "core/parallel.hpp"
#include <atomic>
#include <bit>

namespace tyndall::voxel_dag {
static constexpr std::size_t block_size = 1 << 14;
static constexpr std::uint32_t unused = ~std::uint32_t{0};

static void keep_smallest(std::uint32_t& kept, std::uint32_t position) {
    const std::atomic_ref shared(kept);
    std::uint32_t seen = shared.load(std::memory_order_relaxed);
    while (position < seen && !shared.compare_exchange_weak(seen, position, std::memory_order_relaxed)) {
    }
}

std::vector<std::uint32_t> number_by_first_use(std::span<std::uint32_t> references, std::size_t name_count,
                                               const Progress& progress) {
    std::vector<std::uint32_t> first(name_count, unused);
    parallel_for(
        references.size(), progress,
        [&](std::size_t i) { keep_smallest(first[references[i]], static_cast<std::uint32_t>(i)); }, block_size);

    // A bit per reference that is the first of its name: how many bits are below it is that name's number.
    std::vector<std::uint64_t> is_first(references.size() / 64 + 1, 0);
    parallel_for(
        name_count, progress,
        [&](std::size_t name) {
            if (first[name] != unused)
                std::atomic_ref(is_first[first[name] / 64])
                    .fetch_or(std::uint64_t{1} << first[name] % 64, std::memory_order_relaxed);
        },
        block_size);
    std::vector<std::uint32_t> below(is_first.size() + 1, 0);
    for (std::size_t word = 0; word < is_first.size(); ++word)
        below[word + 1] = below[word] + static_cast<std::uint32_t>(std::popcount(is_first[word]));

    std::vector<std::uint32_t> names(below.back());
    parallel_for(
        name_count, progress,
        [&](std::size_t name) {
            if (first[name] == unused)
                return;
            const std::uint64_t before = is_first[first[name] / 64] & ((std::uint64_t{1} << first[name] % 64) - 1);
            first[name] = below[first[name] / 64] + static_cast<std::uint32_t>(std::popcount(before));
            names[first[name]] = static_cast<std::uint32_t>(name);
        },
        block_size);
    parallel_for(
        references.size(), progress, [&](std::size_t i) { references[i] = first[references[i]]; }, block_size);
    return names;
}
} // namespace tyndall::voxel_dag
