// SPDX-License-Identifier: GPL-3.0-or-later
// Which strata of a light are asked in which of several passes over the same pixels.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include <algorithm>
#include <numeric>

namespace tyndall::light_shafts {
/// The beams of a light that are this turn's: beams[permuted(i)] for i in [first, last), each `weight` times.
struct Deal {
    std::size_t first, last;
    float weight;
};
[[nodiscard]] inline Deal deal(std::size_t beam_count, const Turn& turn) {
    if (beam_count >= turn.count)
        return {.first = turn.index * beam_count / turn.count,
                .last = (turn.index + 1) * beam_count / turn.count,
                .weight = static_cast<float>(turn.count)};
    const std::size_t beam = turn.index % beam_count;
    const std::size_t use_count = turn.count / beam_count + (beam < turn.count % beam_count ? 1 : 0);
    return {.first = beam, .last = beam + 1, .weight = static_cast<float>(turn.count) / static_cast<float>(use_count)};
}
/// A permutation that spreads consecutive indices over all beams, by steps near the golden section.
[[nodiscard]] inline std::size_t spread(std::size_t index, std::size_t count) {
    std::size_t step = std::max<std::size_t>(1, count * 618 / 1000);
    while (std::gcd(step, count) != 1)
        ++step;
    return index * step % count;
}
} // namespace tyndall::light_shafts
