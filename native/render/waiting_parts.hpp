// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of view rays that lie in media and wait for their scattered light.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include <cstdint>
#include <vector>

namespace tyndall::render {
/// Of one pass, in the order of their pixels.
struct WaitingParts {
    std::vector<std::uint32_t> first{0}; ///< Pixel p owns the parts [first[p] .. first[p + 1]).
    std::vector<light_shafts::ViewRay> rays;
    std::vector<Rgb> weights;

    void clear() {
        first.assign(1, 0);
        rays.clear();
        weights.clear();
    }
};
} // namespace tyndall::render
