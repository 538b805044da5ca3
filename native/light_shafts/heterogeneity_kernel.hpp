// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loop that weighs steps along a ray by the light of a sun, dispatched at run time to the best SIMD target.
#pragma once
#include "light_shafts/scatter_pieces.hpp"
#include <cstddef>

namespace tyndall::light_shafts::air_steps {
struct StepSpan {
    const float* at_m;
    const float* shares; ///< Of each step that are lit.
    float* weights;
    std::size_t count;
};
/// Adds to the weight of each step `weight` times its share times what the piece scatters at its point, mean over the
/// channels.
void add_piece(const ScatterPiece& piece, float weight, const StepSpan& steps);
} // namespace tyndall::light_shafts::air_steps
