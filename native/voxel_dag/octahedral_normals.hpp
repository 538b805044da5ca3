// SPDX-License-Identifier: GPL-3.0-or-later
// Directions in 8 to 32 bits: the octahedron |x| + |y| + |z| = 1, unfolded to a square, with a lattice on it.
// Based on: Meyer et al., On Floating-Point Normal Vectors, EGSR 2010; Cigolle et al., A Survey of Efficient
//           Representations for Independent Unit Vectors, JCGT 3(2), 2014: the best of the four lattice points around.
// Differs:  each coordinate has an odd number of steps, so that the six axes are exact: walls stay walls.
// Bound:    on a face the lattice is one of triangles (a, b, 60 degrees between), whose circumradius r bounds the distance
//           to its nearest point; a face is 1 / sqrt(3) from the centre, where r is seen as at most 2 atan(r sqrt(3) / 2).
//           Brute force reaches 91 to 100 % of that: most_error_degrees().
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::voxel_dag::octahedral {
inline constexpr std::uint32_t least_bits = 8, most_bits = 32;

/// Between a direction and what is decoded of it, degrees: 11.5 at 8 bits, 2.61 at 12, 0.64 at 16, 0.0025 at 32.
[[nodiscard]] double most_error_degrees(std::uint32_t bits);
/// direction is finite and not 0, of any length; bits is in [least_bits, most_bits]. Codes lie below 2^bits.
[[nodiscard]] std::uint32_t encode(const dvec3& direction, std::uint32_t bits);
/// In most_bits, both coordinates rounded: up to 1.5 times as far off as the best of the lattice points around, which
/// encode() looks for.
[[nodiscard]] std::uint32_t encode_rounded(const dvec3& direction);
/// Of length 1, for any code.
[[nodiscard]] dvec3 decode(std::uint32_t code, std::uint32_t bits);
/// Codes of many. Throws InvalidInput, which names the first normal that has no direction, and Cancelled.
[[nodiscard]] std::vector<std::uint32_t> encode_all(std::span<const vec3> normals, std::uint32_t bits,
                                                    const Progress& progress);
} // namespace tyndall::voxel_dag::octahedral
