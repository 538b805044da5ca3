// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/placed_edit.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
bool edit_does_something(const OccluderEdit& edit) {
    if (!edit.affects_all && edit.objects.empty())
        return false;
    return edit.kind == EditKind::Holes ? edit.noise.probability > 0.0f : edit.size_m > 0.0f;
}

bool edit_means(const OccluderEdit& edit, std::uint32_t name_index) {
    return edit.affects_all || std::ranges::binary_search(edit.objects, name_index);
}

Bounds3 bounds_of_occluders(const SceneDescription& scene, const OccluderEdit* edit) {
    Bounds3 bounds;
    for (const Instance& instance : scene.instances) {
        if (!instance.casts_shadow || (edit != nullptr && !edit_means(*edit, instance.name_index)))
            continue;
        bounds.grow(transformed(scene.meshes[instance.mesh_index]->bounds(), instance.world_from_object));
    }
    for (const PlacedShape& placed : scene.placed_shapes)
        if (placed.casts_shadow && (edit == nullptr || edit_means(*edit, placed.name_index)))
            bounds.grow(bounds_of(scene, placed));
    return bounds;
}

/// The middle of what an edit means: there, the strata of a sun agree about holes.
static vec3 middle_of(const Bounds3& bounds) { return bounds.is_empty() ? vec3(0.0f) : bounds.centre(); }

PlacedEdit::PlacedEdit(const OccluderEdit& edit, const Light& light, const Bounds3& bounds)
    : what(&edit), noise(edit.kind == EditKind::Holes ? std::make_shared<const HoleNoiseField>(edit.noise) : nullptr),
      space(light, middle_of(bounds), edit.distance_m) {}

void PlacedEdit::find_holes(std::span<const float> x, std::span<const float> y, std::span<const float> z,
                            std::span<std::uint8_t> is_hole) const {
    if (space.is_flat())
        noise->holes(x, y, is_hole);
    else
        noise->holes(x, y, z, is_hole);
}

bool PlacedEdit::is_masked_out(const vec3& place) const {
    return what->mask && space.look_up(*what->mask, place) < 0.5f;
}
} // namespace tyndall::light_shafts
