// SPDX-License-Identifier: GPL-3.0-or-later
// Where occluders get holes: Perlin noise below a threshold, in the light's own metres.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.1, eq. 5.4 and 5.5; Perlin 2002, "Improving noise", the quintic
//           fade; Perlin and Neyret 2001, "Flow noise", for what turns.
// Differs:  5.5 as printed has no frequency in it: this is the sum of p^i P(2^i q) over the sum of p^i, octaves turned and
//           shifted against one another. The threshold is a quantile of the noise as measured, so that `probability` is
//           the share of holes. Over time not the point of the first lookup turns, which would fly the faster the
//           farther it is from the middle, but the gradients: the noise neither drifts away nor changes its statistics.
//           The first lookup reads a noise of its own, so that moving the second one leaves the share of holes alone,
//           and no more than 2 octaves of it: finer ones move edges by less than they are rough already.
// Bound:    71 operations per octave and lookup in the plane, 180 in space; fine octaves are left out where all points
//           of a vector are farther from the threshold than these reach, which spares a moving lookup in the plane one
//           octave in ten at 50 points per cell. SIMD targets round differently, by 1e-6 of the
//           noise's range and more where floats know less of a coordinate, which decides about a point in 1e5. Beyond
//           2^20 cells floats keep too little for the noise to be smooth.
#pragma once
#include "light_shafts/hole_noise_kernel.hpp"
#include "scene/occluder_edit.hpp"
#include <cstdint>
#include <span>

namespace tyndall::light_shafts {
class HoleNoiseField {
public:
    /// Measures the noise to find its threshold, about a millisecond. Throws InvalidInput, which names the culprit.
    explicit HoleNoiseField(const HoleNoise& noise);

    /// 1 where there is a hole, 0 elsewhere. Suns: metres across the light. Spans are of one length.
    void holes(std::span<const float> x_m, std::span<const float> y_m, std::span<std::uint8_t> is_hole) const;
    /// Lamps: the direction from the light times a distance in metres, which makes a map without seams.
    void holes(std::span<const float> x_m, std::span<const float> y_m, std::span<const float> z_m,
               std::span<std::uint8_t> is_hole) const;
    /// The noise itself, mostly within [-1, 1]: holes are where it is below the threshold.
    void values(std::span<const float> x_m, std::span<const float> y_m, std::span<float> noise) const;
    void values(std::span<const float> x_m, std::span<const float> y_m, std::span<const float> z_m,
                std::span<float> noise) const;

private:
    hole_noise::Lookup in_plane_, in_space_;
};
} // namespace tyndall::light_shafts
