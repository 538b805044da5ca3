// SPDX-License-Identifier: GPL-3.0-or-later
// The row of the light map's matrix that a view ray has: what it scatters, dealt out to the lines of texels it crosses.
// Based on: eq. 5.1 of Kol 2018 in closed form per piece (scatter_pieces.hpp); Joseph 1982 (light_map_fit_matrix.hpp).
// Differs:  no marching: between two lines, in each lit part of a piece, the integral is exact and goes to both lines by the
//           part's middle, so that the row's sum is what the ray scatters without a map, however coarse the map is.
// Bound:    an exponential per line and per end of a lit part.
#pragma once
#include "light_shafts/light_map_fit_matrix.hpp"
#include "light_shafts/light_map_fit_place.hpp"
#include "light_shafts/visibility.hpp"

namespace tyndall::light_shafts {
/// What one view ray sees of the light.
struct SeenRay {
    ViewRay ray; ///< Clipped to the media.
    std::span<const ScatterPiece> pieces;
    std::span<const LitInterval> lit;
};
/// Grows the focus by where the ray is lit, up to where a thousandth of the light of its first lit point would be left.
void grow_focus(const SeenRay& seen, const LightMapAxes& axes, Focus& focus);
/// Whether the channels of all the ray scatters stand in one proportion, so that one weight does for three.
[[nodiscard]] bool is_grey(const SeenRay& seen);

/// Deals `channels` amounts, 1 or 3, at each position out to the lines before and behind it. Overwrites line_weights, 1
/// or 4 for each line from the returned one on.
float deal_out(std::span<const float> positions, std::span<const float> amounts, std::size_t channels,
               std::vector<float>& line_weights);

/// Makes rows. One per thread.
class RowMaker {
public:
    RowMaker(const LightMapAxes& axes, const LightMapPlace& place, bool is_coloured)
        : axes_(axes), place_(place), is_coloured_(is_coloured) {}
    /// What lies beyond the map counts for the texels where the ray leaves it.
    void add_row(const SeenRay& seen, LightMapMatrix::Part& part);

private:
    void add_part(const ScatterPiece& piece, float near_m, float far_m, const Rgb& transmittance);
    /// Side by side, of one length each.
    void add_cells(const ScatterPiece& piece, float near_m, float cell_m, std::size_t count, const Rgb& transmittance);

    LightMapAxes axes_;
    LightMapPlace place_;
    bool is_coloured_;
    // Of the ray at work: its position along the longer axis in texels, and where it is in the map.
    float along_at_zero_ = 0.0f, along_per_m_ = 0.0f, enters_m_ = 0.0f, leaves_m_ = 0.0f;
    std::vector<float> depth_, amount_; ///< Per cell and channel: optical depth, and radiance before that loss.
    std::vector<float> position_;       ///< Per cell, along the longer axis.
    std::vector<float> line_weights_;
};
} // namespace tyndall::light_shafts
