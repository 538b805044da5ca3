// SPDX-License-Identifier: GPL-3.0-or-later
// What of a kept picture an object that moved may have changed: pixels that may see one of the boxes around it, and
// shadow rays that may meet one. All others are what a scene rendered anew would give, bit for bit.
#pragma once
#include "render/surface_pass.hpp"
#include "scene/moved_instances.hpp"

namespace tyndall::render {
/// Pixels whose rays, up to `reach_px` beside their centres, may meet a box; none: an empty region.
[[nodiscard]] Region pixels_that_may_see(const Bounds3& box, const Camera& camera, float reach_px);

class MovedView {
public:
    MovedView(MovedBoxes boxes, const Camera& camera, float reach_px);
    [[nodiscard]] const MovedBoxes& boxes() const { return boxes_; }
    [[nodiscard]] bool may_show_in(const Region& pixels) const;

private:
    MovedBoxes boxes_;
    std::vector<Region> shown_; ///< Per box.
};
} // namespace tyndall::render
