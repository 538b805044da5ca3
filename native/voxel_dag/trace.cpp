// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/trace.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/trace_through.hpp"
#include "voxel_dag/tracer.hpp"

namespace tyndall::voxel_dag {
VoxelHit trace(const Dag& dag, const VoxelRay& ray) { return trace_through(dag, ray); }
VoxelHit trace(const PackedDag& dag, const VoxelRay& ray) { return trace_through(dag, ray); }
/// A tracer takes as long to make as one ray per 16 shared records of 8^3 takes to follow without.
static bool are_worth_tracer(const PackedDag& dag, std::size_t ray_count) {
    return dag.levels.empty() || ray_count >= directory_step(leaf_level + 1) * dag.levels[0].directory.size() / 16;
}
void trace(const PackedDag& dag, std::span<const VoxelRay> rays, std::span<VoxelHit> hits, const Progress& progress) {
    if (are_worth_tracer(dag, rays.size()))
        return Tracer(dag).trace(rays, hits, progress);
    require(rays.size() == hits.size(), "voxel DAG: ", rays.size(), " rays, but ", hits.size(), " hits");
    parallel_for(rays.size(), progress, [&](std::size_t i) { hits[i] = trace(dag, rays[i]); });
}
void find_occluded(const PackedDag& dag, std::span<const VoxelRay> rays, std::span<bool> are_occluded,
                   const Progress& progress) {
    if (are_worth_tracer(dag, rays.size()))
        return Tracer(dag).find_occluded(rays, are_occluded, progress);
    require(rays.size() == are_occluded.size(), "voxel DAG: ", rays.size(), " rays, but ", are_occluded.size(),
            " answers");
    parallel_for(rays.size(), progress, [&](std::size_t i) { are_occluded[i] = trace(dag, rays[i]).is_hit(); });
}
} // namespace tyndall::voxel_dag
