// SPDX-License-Identifier: GPL-3.0-or-later
// Integrals of what a local light scatters towards the camera, over smooth pieces of many view rays at once: a piece per
// SIMD lane, in floats.
// Based on: Gauss's 6 points in the angle under which the light sees the ray (Kulla and Fajardo, EGSR 2012), halved where
//           the Legendre coefficients of degree 4 and 5 say that degree 12 still counts.
// Differs:  a point is not found by the tangent of its angle but as a weighted mean of the piece's ends (sine rule), whose
//           terms are all positive: floats stay exact to 1e-6 next to the light and a million times farther away. All
//           else that is linear along the ray is the same mean: optical depth, cosine lobe, ways to the media's bounds.
// Bound:    6 points per piece: two roots and two reciprocals each, an exponential or three; 1e-5 of the piece. Next to an
//           area light 12 to 20 roots and two arctangents more, for its edges; 1e-3 where these fade within a hair.
#pragma once
#include "light_shafts/local_support.hpp"
#include <array>
#include <cstdint>
#include <vector>

namespace tyndall::light_shafts {
/// A boundary between ray and light, met at the share n / d of the way from the point to the light. Both are linear along
/// the piece; d > 0.
struct PieceCrossing {
    std::array<float, 2> n, d;           ///< At the piece's begin and end.
    std::array<float, 3> signed_sigma_t; ///< Positive where the way to the light leaves the medium.
};

/// Smooth pieces in columns, x measured along the ray from the light's foot; none lies on both sides of the foot and
/// reaches farther than the light is away.
struct LocalPieces {
    static constexpr std::size_t capacity = 256;
    static constexpr double nothing = 1e-6; ///< A share of what a ray sends that is left out.
    template <class Value>
    using Column = std::array<Value, capacity>;
    alignas(64) Column<float> x0, x1, length_m;
    alignas(64) std::array<Column<float>, 3> depth0, depth_gain; ///< Between camera and point: at x0, and on to x1.
    alignas(64) Column<float> lobe0, lobe1;                      ///< normal . (point - light) at both ends.
    /// Plus the logarithm of a part's angle over SoftenedY, less its optical depth: the most that it may be of all that the
    /// ray sends.
    alignas(64) Column<float> log_share;
    alignas(64) Column<std::int32_t> ray, set, is_grey;   ///< Ray: into LocalSupport. Grey: all depths are.
    Column<std::uint32_t> first_crossing, crossing_count; ///< Into `crossings`.
    std::vector<PieceCrossing> crossings;
    std::size_t count = 0;

    alignas(64) std::array<Column<float>, 3> sum; ///< Out: for a strength of 1, W/(m^2 sr).
    void clear() { crossings.clear(), count = 0; }
};

/// Fills `pieces.sum`. A piece's bits do not depend on the other pieces.
void integrate(const LocalShape& shape, const std::array<float, 3>& sigma_t_at_light, const LocalSupport& support,
               std::span<const SetOfMedia> sets, LocalPieces& pieces);
} // namespace tyndall::light_shafts
