// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loops of hole noise, dispatched at run time to the best SIMD target of the machine.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tyndall::light_shafts::hole_noise {
/// Gradients at the corners of a lattice, faded into one another.
struct Octave {
    std::array<std::array<float, 3>, 3> cell_per_m; ///< Rows: the lattice's axes.
    std::array<float, 3> offset;                    ///< In cells.
    float amplitude; ///< Of gradients with components within 2^31; all octaves together have gradients of length 1.
    std::uint32_t seed;
    float reach;       ///< Its values lie within -reach and reach.
    float finer_reach; ///< The same of all finer octaves together.
};
struct Lookup {
    std::vector<Octave> mover; ///< Moves the lookup; empty: it stays.
    std::vector<Octave> octaves;
    float cos_turn = 1.0f, sin_turn = 0.0f; ///< Of the mover's gradients.
    std::array<float, 3> move_m{};          ///< Per unit of the mover.
    float threshold = 0.0f;                 ///< Holes are below.
};
/// Coordinates of `count` points: columns of metres, 2 or 3 of them.
struct Points {
    std::array<const float*, 3> columns{};
    std::size_t dimensions = 2, count = 0;
};
void values_at(const Lookup& lookup, const Points& points, float* values);
void holes_at(const Lookup& lookup, const Points& points, std::uint8_t* is_hole);
} // namespace tyndall::light_shafts::hole_noise
