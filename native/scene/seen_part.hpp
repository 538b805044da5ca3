// SPDX-License-Identifier: GPL-3.0-or-later
// Of a view ray what lies before the surface that it meets.
#pragma once
#include "scene/media.hpp"
#include <algorithm>

namespace tyndall {
/// Where the ray meets nothing within the camera's clipping, an endless medium goes on, as in Cycles, until nothing comes
/// through it: what clips surfaces opens no window in fog.
[[nodiscard]] inline Ray seen_part(const Media& media, Ray ray, const Hit& hit) {
    if (hit.is_hit())
        ray.far_m = hit.distance_m;
    else if (media.fills_world()) {
        const auto index = static_cast<std::size_t>(media.world_medium_index());
        ray.far_m = std::max(ray.far_m, opaque_within_m(media.scene().description().media[index].sigma_t_per_m()));
    }
    return ray;
}
} // namespace tyndall
