// SPDX-License-Identifier: GPL-3.0-or-later
// Few view rays that reach as far as all rays of a picture: what the rows of dozens of light samples are laid out for.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// All view rays between two that differ in their direction (perspective) or origin (orthographic); near_m and far_m of
/// both are the least and the largest of them all.
struct RaySpan {
    ViewRay first, last;
};
/// Neighbours in a line of the picture are one span, a pixel longer than they need; rays in any other order are spans of
/// their own. `rays` are finite. Throws Cancelled.
[[nodiscard]] std::vector<RaySpan> outline(bool is_orthographic, std::span<const ViewRay> rays,
                                           const Progress& progress);
} // namespace tyndall::light_shafts
