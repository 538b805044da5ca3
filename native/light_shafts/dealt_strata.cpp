// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/dealt_strata.hpp"
#include "core/random.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace tyndall::light_shafts {
/// In which all strata are taken: groups of so many that lie far apart in both numbers of stratum(), the groups at random.
static std::vector<std::uint32_t> order_of_groups(std::uint32_t count, std::uint32_t size, std::uint32_t seed,
                                                  std::uint32_t number) {
    const std::uint32_t groups = count % size == 0 ? count / size : count;
    std::vector<std::uint32_t> shuffled(groups);
    std::iota(shuffled.begin(), shuffled.end(), 0u);
    for (std::uint32_t end = groups; end > 1; --end)
        std::swap(shuffled[end - 1], shuffled[pcg4d({end, count, seed, number})[0] % end]);
    std::vector<std::uint32_t> order;
    for (const std::uint32_t group : shuffled)
        for (std::uint32_t member = 0; member < count / groups; ++member)
            order.push_back(member * groups + (group + member) % groups);
    return order;
}

std::vector<float> dealt_weights(std::uint32_t count, std::uint32_t least, const SeriesPart& part, std::uint32_t seed,
                                 std::uint32_t number) {
    std::vector<float> weights(count, 1.0f);
    const double rounds = std::ceil(std::min(least, count) * static_cast<double>(part.pictures) / count);
    if (part.is_whole() || rounds >= part.pictures)
        return weights;
    const double begin = rounds * part.first * count / part.samples, end = rounds * part.end * count / part.samples;
    const std::vector<std::uint32_t> order = order_of_groups(count, std::min(least, count), seed, number);
    std::ranges::fill(weights, 0.0f);
    for (double place = std::floor(begin); place < end; ++place) {
        const double share = std::min(place + 1.0, end) - std::max(place, begin);
        const auto stratum = static_cast<std::size_t>(std::fmod(place, count));
        weights[order[stratum]] += static_cast<float>(share * count / (end - begin));
    }
    return weights;
}
} // namespace tyndall::light_shafts
