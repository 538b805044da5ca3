// SPDX-License-Identifier: GPL-3.0-or-later
// How a ray goes on through a surface that lets a part of its light pass.
#pragma once
#include "scene/scene.hpp"
#include <cmath>

namespace tyndall::render {
/// The same ray meets the same triangle at the same distance, bit for bit: one step further is behind it.
inline void go_on_behind(Ray& ray, const Hit& hit) {
    ray.near_m = std::nextafter(hit.distance_m * (1.0f + 4e-7f), ray.far_m);
    ++ray.passed_count;
}
} // namespace tyndall::render
