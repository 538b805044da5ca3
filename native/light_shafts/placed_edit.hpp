// SPDX-License-Identifier: GPL-3.0-or-later
// An edit of occluders in its light's space: where it makes holes, and where a mask lets it work.
#pragma once
#include "light_shafts/hole_noise.hpp"
#include "light_shafts/light_space.hpp"
#include <memory>

namespace tyndall::light_shafts {
/// False: it leaves everything as it is.
[[nodiscard]] bool edit_does_something(const OccluderEdit& edit);
[[nodiscard]] bool edit_means(const OccluderEdit& edit, std::uint32_t name_index); ///< Of an object.
/// Around those that cast shadows; nothing: all of them, else those that the edit means.
[[nodiscard]] Bounds3 bounds_of_occluders(const SceneDescription& scene, const OccluderEdit* edit = nullptr);

struct PlacedEdit {
    const OccluderEdit* what;
    std::shared_ptr<const HoleNoiseField> noise; ///< Of holes.
    LightSpace space;

    /// `edit` must outlive this. `bounds`: of the occluders that it means.
    PlacedEdit(const OccluderEdit& edit, const Light& light, const Bounds3& bounds);
    /// Of places in the light's space, as LightSpace has them: z is not read of a sun.
    void find_holes(std::span<const float> x, std::span<const float> y, std::span<const float> z,
                    std::span<std::uint8_t> is_hole) const;
    /// There is a mask, and the edit does not work there.
    [[nodiscard]] bool is_masked_out(const vec3& place) const;
};
} // namespace tyndall::light_shafts
