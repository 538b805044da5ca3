// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/light.hpp"
#include "scene/light_texture.hpp"
#include <algorithm>
#include <ranges>
#include <tuple>

namespace tyndall {
/// Those are the edits that surfaces see.
static bool is_seen_by_surfaces(const OccluderEdit& edit) {
    return edit.kind == EditKind::Holes && edit.affects_surfaces;
}
static bool make_holes_alike(const OccluderEdit& a, const OccluderEdit& b) {
    const bool have_same_mask = a.mask == b.mask || (a.mask && b.mask && *a.mask == *b.mask);
    return a.distance_m == b.distance_m && a.noise == b.noise && a.affects_all == b.affects_all &&
           a.objects == b.objects && have_same_mask;
}
bool lights_surfaces_alike(const Light& a, const Light& b) {
    const auto all = [](const Light& light) {
        return std::tie(light.kind, light.strength, light.position, light.towards_light, light.spot_axis,
                        light.half_angle_rad, light.radius_m, light.spot_half_angle_rad, light.spot_blend,
                        light.spot_falloff, light.body, light.light_from_world_directions, light.casts_shadow,
                        light.lights_surfaces);
    };
    const bool have_same_texture = a.texture == b.texture || (a.texture && b.texture && *a.texture == *b.texture);
    const auto seen = std::views::filter(is_seen_by_surfaces);
    return all(a) == all(b) && have_same_texture &&
           std::ranges::equal(a.occluder_edits | seen, b.occluder_edits | seen, make_holes_alike);
}
} // namespace tyndall
