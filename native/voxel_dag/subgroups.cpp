// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/subgroups.hpp"
#include <algorithm>
#include <bit>
#include <set>

namespace tyndall::voxel_dag {
template <class Visit>
static void for_each_member(std::uint64_t members, const Visit& visit) {
    for (; members != 0; members &= members - 1)
        visit(static_cast<std::uint32_t>(std::countr_zero(members)));
}

static std::uint64_t products(std::uint64_t some, std::uint64_t others) {
    std::uint64_t result = 0;
    for_each_member(some, [&](std::uint32_t a) {
        for_each_member(others, [&](std::uint32_t b) { result |= std::uint64_t{1} << cube_group.product[a][b]; });
    });
    return result;
}

/// The smallest subgroup around a subgroup and one element.
static std::uint64_t generated(std::uint64_t subgroup, std::uint32_t element) {
    const std::uint64_t generators = subgroup | std::uint64_t{1} << element;
    std::uint64_t all = generators;
    for (std::uint64_t next = products(all, generators); next != all; next = products(all, generators))
        all = next;
    return all;
}

static Subgroups make_subgroups() {
    std::set<std::uint64_t> found{1};
    for (std::vector<std::uint64_t> open{1}; !open.empty();) {
        const std::uint64_t subgroup = open.back();
        open.pop_back();
        for (std::uint32_t element = 1; element < cube_element_count; ++element)
            if ((subgroup >> element & 1) == 0)
                if (const std::uint64_t larger = generated(subgroup, element); found.insert(larger).second)
                    open.push_back(larger);
    }
    Subgroups all{.members = {found.begin(), found.end()}, .coset = {}};
    for (const std::uint64_t subgroup : all.members) {
        std::array<std::uint8_t, cube_element_count> smallest{};
        for (std::uint32_t element = 0; element < cube_element_count; ++element)
            smallest[element] =
                static_cast<std::uint8_t>(std::countr_zero(products(std::uint64_t{1} << element, subgroup)));
        all.coset.push_back(smallest);
    }
    return all;
}

std::uint8_t Subgroups::index_of(std::uint64_t wanted) const {
    return static_cast<std::uint8_t>(std::ranges::lower_bound(members, wanted) - members.begin());
}

const Subgroups& subgroups() {
    static const Subgroups all = make_subgroups();
    return all;
}
} // namespace tyndall::voxel_dag
