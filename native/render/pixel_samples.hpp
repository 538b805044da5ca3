// SPDX-License-Identifier: GPL-3.0-or-later
// The random numbers of one sample of one pixel: well spread over the pixel's samples, unrelated between pixels.
#pragma once
#include "core/sobol.hpp"

namespace tyndall::render {
/// A padded sequence: each pair is a two-dimensional Sobol sequence over the pixel's samples, shuffled and scrambled by
/// its own hash (Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020).
class PixelSamples {
public:
    PixelSamples(std::uint32_t pixel_seed, std::uint32_t sample_index)
        : pixel_seed_(pixel_seed), sample_index_(sample_index) {}
    /// In [0, 1)^2.
    [[nodiscard]] vec2 next_pair() { return sobol_point(sample_index_, hash(pixel_seed_, pair_index_++)); }
    /// Goes on at a pair far behind: what follows does not depend on how many were taken before.
    void jump_to(std::uint32_t pair_index) { pair_index_ = pair_index; }

private:
    std::uint32_t pixel_seed_, sample_index_, pair_index_ = 0;
};
} // namespace tyndall::render
