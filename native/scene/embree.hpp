// SPDX-License-Identifier: GPL-3.0-or-later
// The process's one Embree device, its errors as exceptions, and commits that can be cancelled.
#pragma once
#include "core/progress.hpp"
#include "scene/camera.hpp"
#include <embree3/rtcore.h>
#include <string_view>

namespace tyndall {
/// Coordinates beyond this are squared into infinity by Embree's kernels; what reaches it is dropped and counted.
constexpr float largest_coordinate_m = 1e18f;

/// Watertight: without it light leaks through the edges between triangles. Context filters: transparent shadows.
constexpr RTCSceneFlags traced_scene_flags =
    static_cast<RTCSceneFlags>(int{RTC_SCENE_FLAG_ROBUST} | int{RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION});

/// Made when first asked for. Throws Error where Embree does not start.
[[nodiscard]] RTCDevice embree_device();
/// The most memory that the device has held at one time.
[[nodiscard]] std::size_t most_embree_bytes();
/// Throws Error with Embree's own message, or Cancelled, after a call of this thread that failed.
void check_embree(std::string_view what);
/// Builds the BVH of `scene`; `what` names it in errors. Throws Cancelled within a few milliseconds of a cancel.
void commit(RTCScene scene, std::string_view what, const Progress& progress);
/// A scene within another, as its geometry `id`.
void attach_instance(RTCScene scene, RTCScene instanced, const mat4& scene_from_object, unsigned int id,
                     unsigned int mask);
[[nodiscard]] RTCRay embree_ray(const Ray& ray, unsigned int mask);
} // namespace tyndall
