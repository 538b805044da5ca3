// SPDX-License-Identifier: GPL-3.0-or-later
// Rays through packed bits, many at once, or one by one with what is prepared for all.
// Differs:  from trace() of one ray in no bit of any result, whatever the order of the rays, the vectors of the CPU and the
//           number of threads.
// Bound:    beside the packed DAG no more than Config says; see byte_count(). The dragon at 8K^3, one thread, beside trace()
//           in the same run (voxel_trace_bench): with AVX-512 primary rays 2.0 times as fast, random ones 2.5, bounced ones
//           2.0; with AVX2 2.0, 2.2 and 1.8. Larger topmost levels gain nothing.
#pragma once
#include "voxel_dag/trace.hpp"
#include "voxel_dag/trace_tables.hpp"

namespace tyndall::voxel_dag {
/// Immutable; for any number of threads.
class Tracer {
public:
    static constexpr std::size_t block_px = 8;
    struct Config {
        /// Of the topmost levels' nodes, which are kept decoded, the root at least. The rest of byte_count() follows from
        /// the DAG: at 8K^3 of a scan 0.4 MB.
        std::uint64_t most_bytes = std::uint64_t{2} << 20;
    };
    /// The DAG, which is usable (require_usable()), must outlive it.
    explicit Tracer(const PackedDag& dag, const Config& config);
    explicit Tracer(const PackedDag& dag) : Tracer(dag, Config{}) {}

    /// Allocates nothing.
    [[nodiscard]] VoxelHit trace(const VoxelRay& ray) const;
    /// Of some rays at once, by this thread alone.
    void trace(std::span<const VoxelRay> rays, std::span<VoxelHit> hits) const;
    /// Whether a ray hits anything before its end.
    [[nodiscard]] bool is_occluded(const VoxelRay& ray) const;
    /// As many hits as rays. Rays that begin side by side and go the same way are faster one after the other than mixed.
    /// Throws InvalidInput and Cancelled.
    void trace(std::span<const VoxelRay> rays, std::span<VoxelHit> hits, const Progress& progress) const;
    void find_occluded(std::span<const VoxelRay> rays, std::span<bool> are_occluded, const Progress& progress) const;

    /// For blocks of 8 x 8 pixels of a picture, row by row, where their rays may begin: see beam_start.hpp. Of rays that are
    /// given row by row, too; their number is a multiple of the width. Throws InvalidInput and Cancelled.
    [[nodiscard]] std::vector<double> block_starts(std::span<const VoxelRay> rays, std::size_t width_px,
                                                   const Progress& progress) const;

    /// For rays that stop at cubes (VoxelRay::shares). Must not outlive this. Throws Cancelled.
    [[nodiscard]] NodeShares node_shares(const Progress& progress) const;

    /// Of what it keeps beside the DAG.
    [[nodiscard]] std::uint64_t byte_count() const;

private:
    TraceTables tables_; ///< Of an empty DAG without nodes.
};
} // namespace tyndall::voxel_dag
