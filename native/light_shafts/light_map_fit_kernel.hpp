// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loops of the light map's matrix, dispatched at run time to the best SIMD target of the machine.
#pragma once
#include "light_shafts/light_map_fit_matrix.hpp"

namespace tyndall::light_shafts::light_map_kernel {
struct Weights {
    const std::uint16_t* first;      ///< Of all readers.
    bool is_coloured;                ///< Four per line, not one.
    std::uint32_t resolution, pitch; ///< Texels per row, and from row to row.
};
/// What each reader of a line gets of the map.
void read(const Weights& weights, const MapLine& line, std::span<const LineReader> readers, const vec4* texels,
          vec4* of_reader);
/// Adds the values of the readers' rays times their weights, or their squares, to what the line reads.
void add(const Weights& weights, const MapLine& line, std::span<const LineReader> readers, const vec4* ray_values,
         bool squares, vec4* texels);
/// amount[i] *= exp(-depth[i]).
void attenuate(std::span<const float> depth, std::span<float> amount);
} // namespace tyndall::light_shafts::light_map_kernel
