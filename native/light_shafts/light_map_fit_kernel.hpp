// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loops of the light map's matrix, dispatched at run time to the best SIMD target of the machine.
#pragma once
#include "light_shafts/light_map_fit_matrix.hpp"

namespace tyndall::light_shafts::light_map_kernel {
struct Weights {
    const float* first;              ///< Of all stretches.
    bool is_coloured;                ///< Four per line, not one.
    std::uint32_t resolution, pitch; ///< Texels per row, and from row to row.
};
/// What a stretch reads from the map.
[[nodiscard]] vec4 read(const Weights& weights, const RowStretch& stretch, const vec4* texels);
/// Adds value times the stretch's weights, or their squares, to what it reads.
void add(const Weights& weights, const RowStretch& stretch, const vec4& value, bool squares, vec4* texels);
/// amount[i] *= exp(-depth[i]).
void attenuate(std::span<const float> depth, std::span<float> amount);
} // namespace tyndall::light_shafts::light_map_kernel
