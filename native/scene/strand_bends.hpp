// SPDX-License-Identifier: GPL-3.0-or-later
// The points of a strand between which it is straight and as wide as between its ends: few of a hair that hardly bends,
// however many it was made of.
// Error:    the middle is off by a fifth of the radius at most, up to either side of a bend, and the radius by 2 %.
// Bound:    a spline's points, and the logarithm of their number times as many again to compare.
#pragma once
#include "scene/strands.hpp"

namespace tyndall {
/// Of splines: ribbons and round strands. The strands must outlive it. Not for two threads at once.
class StrandBends {
public:
    explicit StrandBends(const Strands& strands);
    /// From the strand's first point to its last, with tangents; there until the next call.
    [[nodiscard]] std::span<const StrandPoint> of(std::uint32_t strand);

private:
    const Strands& strands_;
    std::vector<std::uint32_t> first_segment_; ///< Of each strand.
    std::vector<StrandPoint> dense_, bends_;
};
} // namespace tyndall
