// SPDX-License-Identifier: GPL-3.0-or-later
// Rays through packed bits by the widest vectors of this CPU (core/simd.hpp): eight that go nearly the same way together
// (trace_packet-inl.hpp), others one by one, taking turns (trace_walk-inl.hpp).
#pragma once
#include "voxel_dag/trace.hpp"
#include "voxel_dag/trace_tables.hpp"

namespace tyndall::voxel_dag {
[[nodiscard]] VoxelHit trace_by_vectors(const TraceTables& tables, const VoxelRay& ray);
void trace_by_vectors(const TraceTables& tables, std::span<const VoxelRay> rays, VoxelHit* hits);
/// Whether a ray hits anything.
[[nodiscard]] bool is_hit_by_vectors(const TraceTables& tables, const VoxelRay& ray);
void is_hit_by_vectors(const TraceTables& tables, std::span<const VoxelRay> rays, bool* are_hits);
} // namespace tyndall::voxel_dag
