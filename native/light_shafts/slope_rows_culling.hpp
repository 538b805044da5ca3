// SPDX-License-Identifier: GPL-3.0-or-later
// Which boxes of occluders slope rows need: what lies outside the slices, outside their lines, or wholly below every
// view ray, as seen from the light, is dropped before a triangle of it is read.
#pragma once
#include "light_shafts/slope_rows_kernels.hpp"

namespace tyndall::light_shafts::slope_rows {
/// Per group of slices of a layout what their rows need, so that any range of slices is answered quickly.
class Culling {
public:
    explicit Culling(const Layout& layout);

    /// What the slices [first, end) need of the triangles in a box with this centre and these half extents along (u, v,
    /// axis); empty: nothing.
    [[nodiscard]] SliceNeeds needs_of_box(const vec3& centre, const vec3& half_extent, std::int32_t first,
                                          std::int32_t end) const;

private:
    [[nodiscard]] SliceNeeds needs_between(std::int32_t first, std::int32_t end) const;

    const Layout& layout_;
    std::vector<SliceNeeds> groups_;
};
} // namespace tyndall::light_shafts::slope_rows
