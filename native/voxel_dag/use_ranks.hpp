// SPDX-License-Identifier: GPL-3.0-or-later
// Which names are used most: in a packed DAG these have the shortest numbers.
#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

namespace tyndall::voxel_dag {
inline constexpr std::uint32_t no_rank = ~std::uint32_t{0};

/// Names in the order of how often they are named, and the rank of each; those below `fewest` uses have none.
struct Ranks {
    std::vector<std::uint32_t> uses;  ///< By rank, falling.
    std::vector<std::uint32_t> names; ///< By rank.
    std::vector<std::uint32_t> rank;  ///< By name.
};
inline Ranks ranked_by(const std::vector<std::uint32_t>& uses, std::uint32_t fewest) {
    Ranks ranks;
    ranks.names.reserve(
        static_cast<std::size_t>(std::ranges::count_if(uses, [&](auto times) { return times >= fewest; })));
    for (std::uint32_t name = 0; name < uses.size(); ++name)
        if (uses[name] >= fewest)
            ranks.names.push_back(name);
    std::ranges::stable_sort(ranks.names, std::greater(), [&](std::uint32_t name) { return uses[name]; });
    ranks.rank.assign(uses.size(), no_rank);
    for (std::uint32_t i = 0; i < ranks.names.size(); ++i) {
        ranks.rank[ranks.names[i]] = i;
        ranks.uses.push_back(uses[ranks.names[i]]);
    }
    return ranks;
}
/// Names of two or more references. How often each is used is not asked for again.
inline Ranks ranked(const std::vector<std::uint32_t>& references, std::size_t name_count) {
    std::vector<std::uint32_t> uses(name_count, 0);
    for (const std::uint32_t name : references)
        ++uses[name];
    Ranks ranks = ranked_by(uses, 2);
    ranks.uses = {};
    return ranks;
}
} // namespace tyndall::voxel_dag
