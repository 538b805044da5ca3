// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/material_indices.hpp"
#include "voxel_dag/numbered_values.hpp"
#include <bit>

namespace tyndall::voxel_dag {
static constexpr std::size_t entries_per_poll = std::size_t{1} << 22; // some ms

template <typename Work>
static void in_parts(std::size_t count, const Progress& progress, const Work& work) {
    for (std::size_t begin = 0; begin < count; begin += entries_per_poll) {
        progress.poll();
        work(begin, std::min(count, begin + entries_per_poll));
    }
}

/// One bit per possible value; the index of a value is the number of set bits below its own.
static MaterialIndices by_rank(std::span<const std::uint32_t> values, std::uint32_t largest, const Progress& progress) {
    std::vector<std::uint64_t> is_there(largest / 64 + 1);
    in_parts(values.size(), progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (i == begin || values[i] != values[i - 1])
                is_there[values[i] / 64] |= std::uint64_t{1} << values[i] % 64;
    });
    std::vector<std::uint32_t> rank(is_there.size());
    MaterialIndices result{.materials = {}, .indices = std::vector<std::uint32_t>(values.size())};
    for (std::size_t word = 0; word < is_there.size(); ++word) {
        rank[word] = static_cast<std::uint32_t>(result.materials.size());
        for (std::uint64_t left = is_there[word]; left != 0; left &= left - 1)
            result.materials.push_back(static_cast<std::uint32_t>(64 * word) +
                                       static_cast<std::uint32_t>(std::countr_zero(left)));
    }
    in_parts(values.size(), progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint64_t below = is_there[values[i] / 64] & ((std::uint64_t{1} << values[i] % 64) - 1);
            result.indices[i] = rank[values[i] / 64] + static_cast<std::uint32_t>(std::popcount(below));
        }
    });
    return result;
}

static MaterialIndices by_hash(std::span<const std::uint32_t> values, const Progress& progress) {
    NumberedValues<std::uint32_t> numbered;
    MaterialIndices result{.materials = {}, .indices = std::vector<std::uint32_t>(values.size())};
    in_parts(values.size(), progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            result.indices[i] = i > begin && values[i] == values[i - 1] ? result.indices[i - 1] //
                                                                        : numbered.number_of(values[i]);
    });
    AscendingOrder order(numbered.values());
    result.materials = std::move(order.values);
    in_parts(values.size(), progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            result.indices[i] = order.rank[result.indices[i]];
    });
    return result;
}

MaterialIndices material_indices_of(std::span<const std::uint32_t> values, const Progress& progress) {
    if (values.empty())
        return {};
    const std::uint32_t largest = std::ranges::max(values);
    return largest < 1u << 24 ? by_rank(values, largest, progress) : by_hash(values, progress);
}
} // namespace tyndall::voxel_dag
