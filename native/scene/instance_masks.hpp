// SPDX-License-Identifier: GPL-3.0-or-later
// Which rays see which instances of Scene::embree_scene().
#pragma once

namespace tyndall {
inline constexpr unsigned int camera_mask = 1u; ///< Camera rays.
inline constexpr unsigned int shadow_mask = 2u; ///< Rays towards a light.
inline constexpr unsigned int bounce_mask = 4u; ///< Rays that gather the light of other surfaces.
inline constexpr unsigned int mirror_mask = 8u; ///< What mirrors show.
} // namespace tyndall
