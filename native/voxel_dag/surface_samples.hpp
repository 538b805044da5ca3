// SPDX-License-Identifier: GPL-3.0-or-later
// Where the voxels that a triangle sets sample it, and how much of it each has.
// Based on: Ericson, Real-Time Collision Detection, 2005, section 5.1.5: the point of a triangle nearest to another.
// Differs:  a sample lies at the point of the triangle nearest to the voxel's centre. Its weight is the area of the plane
//           within the voxel (a trapezoid over the distance, exact for planes along an axis and for the space diagonal
//           through the centre) times what each edge leaves of it (as if edges were independent: between the bounds of
//           Frechet), at most the triangle's area. Nothing is clipped, and a piece however small counts.
// Bound:    30 vector operations of four lanes per voxel and triangle, one division; as many again where the nearest point
//           lies on an edge. Plain multiplications and additions, in the order x, y, z: every CPU finds the same bits,
//           whatever the axes of the scan.
#pragma once
#include "voxel_dag/tile_bricks.hpp"
#include "voxel_dag/tile_lines.hpp"
#include "voxel_dag/tile_scan.hpp"

namespace tyndall::voxel_dag {
using Four = std::array<float, 4>;

/// A linear function of the voxel's index in its tile, in each lane.
struct alignas(16) LinearFour {
    Four at_first;                ///< At the centre of the tile's first voxel.
    std::array<Four, 3> per_step; ///< From voxel to voxel along x, y, z.
};
struct SampledTriangle {
    LinearFour shares;               ///< Of the three corners, below 0 outside; and the distance to the plane.
    LinearFour along;                ///< Each edge, opposite to the corner of that number: 0 and 1 at its ends.
    alignas(16) Four edge_lengths;   ///< In voxels, as all that follows.
    Four cover_scale, cover_offset;  ///< From shares to what is left within an edge, or near the plane, before 0 and 1.
    float weight_scale, most_weight; ///< In units of whole_weight.
    vec3 normal; ///< Of length 1, in the world's axes; 0 for a triangle that is no more than a line.
};
inline constexpr float whole_weight = 4096; ///< Of a square voxel's area.
[[nodiscard]] SampledTriangle sampled(const SnappedTriangle& triangle, const TileFrame& frame);

/// The numbers of a tile's voxels in Morton order.
struct TileSlots {
    std::array<std::uint64_t, tile_bricks> masks{};
    std::array<std::uint32_t, tile_bricks> first{}; ///< Number of a brick's first voxel.
};

struct SurfaceSamples {
    static constexpr std::size_t room = 512;
    std::size_t count = 0;
    std::array<std::uint32_t, room> slots;
    std::array<float, room> weights;           ///< Whole numbers of 1 or more.
    alignas(16) std::array<Four, room> shares; ///< Of the three corners; they add up to 1. The last is nothing.
};
/// Samples of the runs from `run` on, as many as there is room for; returns the first run that is left. Voxels that are
/// not in `slots` are left out.
[[nodiscard]] std::size_t take_samples(const SampledTriangle& triangle, const TriangleRuns& runs, std::size_t run,
                                       const ScanAxes& axes, const TileSlots& slots, SurfaceSamples& samples);

/// Sums of weight * value, exact whatever the order they are added in: up to 2^31 samples in a voxel.
using FourSums = std::array<std::int64_t, 4>;
using FourMeans = std::array<std::int32_t, 4>;
/// Adds the values of the three corners; sums[slot * stride] is a voxel's. Values stay within 2^16.
void add_samples(const SurfaceSamples& samples, const std::array<Four, 3>& values, std::size_t stride, FourSums* sums);
/// Of `count` voxels: sums[slot * stride] divided by the last of weights[slot * stride], rounded.
void take_means(const FourSums* sums, const FourSums* weights, std::size_t stride, std::size_t count, FourMeans* means);
} // namespace tyndall::voxel_dag
