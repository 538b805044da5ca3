// SPDX-License-Identifier: GPL-3.0-or-later
// Strata of a light for one of several pictures whose mean is shown, such as the moments of a shutter: each has few of
// them, and all pictures together have every one, equally often.
// Differs:  the pictures take them one after another from a circle, as many times around it as each needs for a few; in
//           an order at random, so that a light's places do not follow the time.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include <vector>

namespace tyndall::light_shafts {
/// What each of `count` strata weighs in the picture, 1 in the mean; 0: it is another's. A picture has about `least` of
/// them, or all. `number` tells lights apart.
[[nodiscard]] std::vector<float> dealt_weights(std::uint32_t count, std::uint32_t least, const SeriesPart& part,
                                               std::uint32_t seed, std::uint32_t number);
} // namespace tyndall::light_shafts
