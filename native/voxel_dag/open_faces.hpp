// SPDX-License-Identifier: GPL-3.0-or-later
// Where voxels end: the faces between one that is set and one that is not, a brick at a time, and the voxels that have any.
// Bound:    per brick six neighbours, looked for from the brick outwards: 3 to 5 steps each on a surface.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/leaf_masks.hpp"

namespace tyndall::voxel_dag {
/// [2 * axis]: the brick's voxels that have none below along that axis; [2 * axis + 1]: none above. The cube's outside
/// has none.
using OpenFaces = std::array<std::uint64_t, 6>;
/// leaves is usable: see require_usable(). brick is a position in codes.
[[nodiscard]] OpenFaces open_faces(const LeafMasks& leaves, std::size_t brick);

/// Voxels with an open face. What is left of a solid stops every path by faces from outside to what was taken out
/// (6-separating). Throws Cancelled.
[[nodiscard]] LeafMasks shell_of(const LeafMasks& leaves, const Progress& progress);
} // namespace tyndall::voxel_dag
