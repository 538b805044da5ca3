// SPDX-License-Identifier: GPL-3.0-or-later
// Where one ray of many stops among cubes that are partly filled, so that as many stop as voxels would stop.
// Based on: Heitz and Neyret, Representing Appearance and Pre-filtering Subpixel Data in Sparse Voxel Octrees, 2012: cubes
//           that follow each other are parts of one surface, and what they cover must not be multiplied as if they had
//           nothing to do with each other.
// Differs:  no beams: a ray has a number, even in [0, 1) among all that take its way, and stops where the share that is
//           covered so far exceeds it. Shares add up while cubes touch: then they are parts of one thing, which covers a
//           place once. Behind a gap what is left of the number begins anew, so that things apart are independent.
//           A cube adds, per axis, the share of its width that the ray goes along it, times the share of its side that is
//           covered: for any plane across an axis that is 1 in all, whatever cubes the ray meets there.
//           Of a plane askew it is 1 on average only, and a tenth of the rays would pass. So a ray stops in sheets where
//           they have covered all; where it gets through cubes that touch and are such sheets, its voxels there are asked.
// Bound:    exact on average for surfaces across axes, and nothing passes others; wires and sieves are as dense as they
//           are, but those that lie in cubes that touch, one behind the other, are too dense: as if none hid another.
#pragma once
#include "voxel_dag/axis_shares.hpp"
#include <hwy/base.h>
#include <limits>

namespace tyndall::voxel_dag {
class CoverRun {
public:
    static constexpr std::uint32_t no_axis = 3;

    /// `number` in [0, 1). `asks_voxels`: in sheets the ray never stops by what cubes cover.
    HWY_INLINE void start(double number, bool asks_voxels) {
        all_of_sheet_ =
            asks_voxels ? std::numeric_limits<double>::infinity() : 0.99; // below 1 by what rounding may leave
        number_ = left_ = number;
        covered_ = sheet_ = 0.0;
        until_ = -std::numeric_limits<double>::infinity();
        axis_ = no_axis;
    }
    /// Whether it got through a sheet, beyond which it is now: `from` is where it goes on.
    [[nodiscard]] HWY_INLINE bool is_unsure(double from) const { return sheet_ > 0.0 && from > until_; }
    [[nodiscard]] HWY_INLINE double unsure_from() const { return from_; }
    [[nodiscard]] HWY_INLINE double unsure_until() const { return until_; }
    [[nodiscard]] HWY_INLINE bool asks_voxels() const {
        return all_of_sheet_ == std::numeric_limits<double>::infinity();
    }
    /// Its voxels do not stop it there.
    HWY_INLINE void pass() {
        sheet_ = 0.0;
        from_ = until_;
    }

    /// At the next cube on the way, which the ray passes from..until, going so many of its widths along each axis.
    HWY_INLINE bool stops(double from, double until, const std::array<double, 3>& widths, AxisShares shares) {
        if (from > until_) { // a gap
            left_ /= 1.0 - covered_;
            covered_ = 0.0;
            from_ = from;
        }
        until_ = until;
        distance_ = from;
        if (covers_all(shares) && !asks_voxels())
            return true;
        std::array<double, 3> more;
        for (std::uint32_t axis = 0; axis < 3; ++axis)
            more[axis] = widths[axis] * share_along(shares, axis);
        const double sum = more[0] + more[1] + more[2];
        if ((shares & is_sheet) != 0) {
            sheet_ += sum;
            if (sheet_ >= all_of_sheet_)
                stop(from, until, more, number_ * sum);
            return sheet_ >= all_of_sheet_;
        }
        if (left_ < sum) {
            stop(from, until, more, left_);
            return true;
        }
        left_ -= sum;
        covered_ += sum;
        return false;
    }
    /// Where it stopped, and across which axis; no_axis: a full cube, where it enters it.
    [[nodiscard]] HWY_INLINE double distance() const { return distance_; }
    [[nodiscard]] HWY_INLINE std::uint32_t axis() const { return axis_; }

private:
    /// Where that much of the cube is covered, and by the side that does it.
    HWY_INLINE void stop(double from, double until, const std::array<double, 3>& more, double left) {
        for (axis_ = 0; axis_ < 2 && left >= more[axis_]; ++axis_)
            left -= more[axis_];
        distance_ = more[axis_] > 0.0 ? from + (until - from) * std::min(left / more[axis_], 1.0) : from;
    }

    double all_of_sheet_ = 0.0;
    double number_ = 0.0, left_ = 0.0; ///< left_: of the number.
    double covered_ = 0.0;             ///< By cubes that touch, one after the other, but those of sheets.
    double sheet_ = 0.0;               ///< By those.
    double from_ = 0.0, until_ = 0.0;  ///< Of cubes that touch.
    double distance_ = 0.0;
    std::uint32_t axis_ = no_axis;
};
} // namespace tyndall::voxel_dag
