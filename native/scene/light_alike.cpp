// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/light.hpp"
#include "scene/light_texture.hpp"
#include <algorithm>
#include <ranges>
#include <tuple>

namespace tyndall {
static bool is_seen_by_surfaces(const OccluderEdit& edit) { return edit.affects_surfaces; }
/// Names do not count, nor does what an edit of its kind does not read.
static bool do_the_same(const OccluderEdit& a, const OccluderEdit& b) {
    const bool have_same_mask = a.mask == b.mask || (a.mask && b.mask && *a.mask == *b.mask);
    if (a.kind != b.kind || a.distance_m != b.distance_m || a.affects_all != b.affects_all || a.objects != b.objects ||
        !have_same_mask)
        return false;
    return a.kind == EditKind::Holes ? a.noise == b.noise : a.size_m == b.size_m && a.shape == b.shape;
}
bool lights_surfaces_alike(const Light& a, const Light& b) {
    const auto all = [](const Light& light) {
        return std::tie(light.kind, light.strength, light.position, light.towards_light, light.spot_axis,
                        light.half_angle_rad, light.radius_m, light.spot_half_angle_rad, light.spot_blend,
                        light.spot_falloff, light.body, light.light_from_world_directions, light.casts_shadow,
                        light.lights_surfaces, light.lights_catchers, light.half_size_m, light.is_ellipse,
                        light.links.receiver_sets, light.links.blocker_sets);
    };
    const bool have_same_texture = a.texture == b.texture || (a.texture && b.texture && *a.texture == *b.texture);
    const auto seen = std::views::filter(is_seen_by_surfaces);
    return all(a) == all(b) && have_same_texture &&
           std::ranges::equal(a.occluder_edits | seen, b.occluder_edits | seen, do_the_same);
}
} // namespace tyndall
