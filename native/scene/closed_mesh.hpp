// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a mesh encloses what is within it.
#pragma once
#include "scene/triangle_mesh.hpp"

namespace tyndall {
/// Each edge is there as often in one direction as in the other. Corners at one position are one corner: meshes come
/// with vertices split along seams.
[[nodiscard]] bool is_closed(const SharedMeshArrays& arrays);
} // namespace tyndall
