// SPDX-License-Identifier: GPL-3.0-or-later
// Which rays see which instances of Scene::trees().
#pragma once

namespace tyndall {
inline constexpr unsigned int camera_mask = 1u; ///< Camera rays.
inline constexpr unsigned int shadow_mask = 2u; ///< Rays towards a light.
inline constexpr unsigned int bounce_mask = 4u; ///< Rays that gather the light of other surfaces.
inline constexpr unsigned int mirror_mask = 8u; ///< What mirrors show.

/// Of an instance or a placed shape.
[[nodiscard]] unsigned int mask_of(const auto& placed) {
    return (placed.is_camera_visible ? camera_mask : 0u) | (placed.casts_shadow ? shadow_mask : 0u) |
           (placed.is_bounce_visible ? bounce_mask : 0u) | (placed.is_mirror_visible ? mirror_mask : 0u);
}
} // namespace tyndall
