// SPDX-License-Identifier: GPL-3.0-or-later
// Which rays see which instances of Scene::trees().
#pragma once
#include "shading/program_point.hpp"
#include <cstdint>

namespace tyndall {
inline constexpr unsigned int camera_mask = 1u; ///< Camera rays.
inline constexpr unsigned int shadow_mask = 2u; ///< Rays towards a light.
inline constexpr unsigned int bounce_mask = 4u; ///< Rays that gather the light of other surfaces.
inline constexpr unsigned int mirror_mask = 8u; ///< What mirrors show, and rays by gloss.
inline constexpr unsigned int glass_mask = 16u; ///< What is seen through what bends rays.

/// Of what stands in the way of light that a ray of this kind gathers.
[[nodiscard]] constexpr unsigned int blocking_mask(RayKind kind) {
    switch (kind) {
    case RayKind::Diffuse:
        return bounce_mask;
    case RayKind::Glossy:
        return mirror_mask;
    default:
        return shadow_mask;
    }
}

/// Of what a ray that is followed from the camera meets.
[[nodiscard]] constexpr unsigned int seen_mask(RayKind kind) {
    switch (kind) {
    case RayKind::Camera:
        return camera_mask;
    case RayKind::Transmission:
        return glass_mask;
    default:
        return mirror_mask;
    }
}

/// Of masks: of what stops some of the rays that gather light, and not all.
[[nodiscard]] constexpr bool tells_rays_apart(unsigned int mask) {
    const unsigned int of_light = mask & (shadow_mask | bounce_mask | mirror_mask);
    return of_light != 0 && of_light != (shadow_mask | bounce_mask | mirror_mask);
}

/// What else there is for a ray: the light on a shadow catcher is compared with what it would be without all but catchers.
enum class Among : std::uint8_t { All = 0, Catchers = 1 };
/// The mask of the same rays there.
[[nodiscard]] constexpr unsigned int mask_among(Among among, unsigned int mask) {
    return among == Among::Catchers ? mask << 8u : mask;
}

/// Of an instance or a placed shape.
[[nodiscard]] unsigned int mask_of(const auto& placed) {
    const unsigned int mask = (placed.is_camera_visible ? camera_mask : 0u) | (placed.casts_shadow ? shadow_mask : 0u) |
                              (placed.is_bounce_visible ? bounce_mask : 0u) |
                              (placed.is_mirror_visible ? mirror_mask : 0u) |
                              (placed.is_glass_visible ? glass_mask : 0u);
    return mask | (placed.is_shadow_catcher ? mask_among(Among::Catchers, mask) : 0u);
}
} // namespace tyndall
