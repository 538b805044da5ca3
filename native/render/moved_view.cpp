// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/moved_view.hpp"
#include <algorithm>

namespace tyndall::render {
/// Rounding of rays and of their places in the picture.
static constexpr double rounding_px = 0.1;

Region pixels_that_may_see(const Bounds3& box, const Camera& camera, float reach_px) {
    // What turns around the camera, or is blurred, may show anywhere.
    if (camera.is_panoramic() || !camera.lens.is_pinhole())
        return box.is_empty() ? Region{0, 0, 0, 0} : Region{0, 0, camera.width_px, camera.height_px};
    const glm::dmat4 camera_from_scene = glm::inverse(glm::dmat4(camera.world_from_camera));
    const bool is_perspective = camera.kind == CameraKind::Perspective;
    const dvec2 size_px(camera.width_px, camera.height_px);
    const dvec2 window_min(camera.window_left, camera.window_bottom),
        window_max(camera.window_right, camera.window_top);
    dvec2 least_px(std::numeric_limits<double>::infinity()), most_px(-std::numeric_limits<double>::infinity());
    int before_count = 0;
    for (std::size_t corner = 0; corner < 8 && !box.is_empty(); ++corner) {
        const glm::dvec4 place = camera_from_scene * glm::dvec4(box.corner(corner), 1.0);
        if (is_perspective && !(place.z < 0.0))
            continue;
        ++before_count;
        const dvec2 at_px =
            (dvec2(place) / (is_perspective ? -place.z : 1.0) - window_min) / (window_max - window_min) * size_px;
        least_px = glm::min(least_px, at_px);
        most_px = glm::max(most_px, at_px);
    }
    if (before_count == 0)
        return {0, 0, 0, 0};
    if (before_count < 8) // the box reaches through the camera's plane
        return {0, 0, camera.width_px, camera.height_px};
    // Pixel x has its centre at x + 0.5.
    const double reach = static_cast<double>(reach_px) + 0.5 + rounding_px;
    const dvec2 first = glm::clamp(glm::floor(least_px - 0.5 - reach), dvec2(0.0), size_px);
    const dvec2 end = glm::clamp(glm::ceil(most_px + 0.5 + reach), dvec2(0.0), size_px);
    return {static_cast<std::uint32_t>(first.x), static_cast<std::uint32_t>(first.y), static_cast<std::uint32_t>(end.x),
            static_cast<std::uint32_t>(end.y)};
}

MovedView::MovedView(MovedBoxes boxes, const Camera& camera, float reach_px) : boxes_(std::move(boxes)) {
    for (const Bounds3& box : boxes_.boxes())
        shown_.push_back(pixels_that_may_see(box, camera, reach_px));
}

bool MovedView::may_show_in(const Region& pixels) const {
    return std::ranges::any_of(shown_, [&](const Region& shown) {
        return shown.x0 < pixels.x1 && pixels.x0 < shown.x1 && shown.y0 < pixels.y1 && pixels.y0 < shown.y1;
    });
}
} // namespace tyndall::render
