// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/tracer.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/beam_start.hpp"
#include "voxel_dag/node_shares.hpp"
#include "voxel_dag/trace_kernel.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
constexpr std::size_t rays_per_block = 2048; ///< At a block's end fewer and fewer rays take turns.

Tracer::Tracer(const PackedDag& dag, const Config& config)
    : tables_(make_trace_tables(dag, config.most_bytes / sizeof(TopNode))) {}

VoxelHit Tracer::trace(const VoxelRay& ray) const {
    return tables_.dag->is_empty() ? VoxelHit{} : trace_by_vectors(tables_, ray);
}
void Tracer::trace(std::span<const VoxelRay> rays, std::span<VoxelHit> hits) const {
    if (tables_.dag->is_empty())
        return static_cast<void>(std::ranges::fill(hits, VoxelHit{}));
    trace_by_vectors(tables_, rays, hits.data());
}
bool Tracer::is_occluded(const VoxelRay& ray) const {
    return !tables_.dag->is_empty() && is_hit_by_vectors(tables_, ray);
}

void Tracer::trace(std::span<const VoxelRay> rays, std::span<VoxelHit> hits, const Progress& progress) const {
    require(rays.size() == hits.size(), "voxel DAG: ", rays.size(), " rays, but ", hits.size(), " hits");
    if (tables_.dag->is_empty())
        return static_cast<void>(std::ranges::fill(hits, VoxelHit{}));
    parallel_blocks(rays.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        trace_by_vectors(tables_, rays.subspan(begin, end - begin), hits.data() + begin);
    });
}
void Tracer::find_occluded(std::span<const VoxelRay> rays, std::span<bool> are_occluded,
                           const Progress& progress) const {
    require(rays.size() == are_occluded.size(), "voxel DAG: ", rays.size(), " rays, but ", are_occluded.size(),
            " answers");
    if (tables_.dag->is_empty())
        return static_cast<void>(std::ranges::fill(are_occluded, false));
    parallel_blocks(rays.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        is_hit_by_vectors(tables_, rays.subspan(begin, end - begin), are_occluded.data() + begin);
    });
}

std::vector<double> Tracer::block_starts(std::span<const VoxelRay> rays, std::size_t width_px,
                                         const Progress& progress) const {
    require(width_px > 0 && rays.size() % width_px == 0, "voxel DAG: ", rays.size(), " rays in rows of ", width_px);
    const std::size_t height_px = rays.size() / width_px, across = (width_px + block_px - 1) / block_px;
    std::vector<double> starts(across * ((height_px + block_px - 1) / block_px),
                               std::numeric_limits<double>::infinity());
    if (tables_.dag->is_empty())
        return starts;
    parallel_for(
        starts.size(), progress,
        [&](std::size_t i) {
            const std::size_t left = i % across * block_px, top = i / across * block_px;
            std::array<VoxelRay, block_px * block_px> block;
            std::size_t count = 0;
            for (std::size_t y = top; y < std::min(top + block_px, height_px); ++y)
                for (std::size_t x = left; x < std::min(left + block_px, width_px); ++x)
                    block[count++] = rays[y * width_px + x];
            starts[i] = beam_start(tables_, std::span(block).first(count));
        },
        32);
    return starts;
}

NodeShares Tracer::node_shares(const Progress& progress) const { return NodeShares(tables_, progress); }

std::uint64_t Tracer::byte_count() const { return voxel_dag::byte_count(tables_); }
} // namespace tyndall::voxel_dag
