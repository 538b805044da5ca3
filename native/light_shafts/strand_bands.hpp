// SPDX-License-Identifier: GPL-3.0-or-later
// Strands as bands that face a light, written anew for each light sample: how maps and rows draw hair.
// Based on: the outline of a tube lies on its middle, a radius to either side: what a band through the middle that faces the
//           light shades outside of the tube, the tube does. A ribbon is such a band.
// Differs:  rings stand where a strand bends or swells, not at its points or at equal steps: a straight hair is one piece.
// Bound:    16 bytes per ring, kept; per light sample and piece some 60 operations and two triangles of 36 bytes, which stay
//           in the cache, and place_triangles, which drops most: hairs are thinner than samples are wide.
#pragma once
#include "light_shafts/occluders.hpp"
#include <array>

namespace tyndall::light_shafts {
/// Segments of strands, times how often they stand in the scene, up to which bands are drawn; more are traced.
inline constexpr std::uint64_t most_segments_with_bands = std::uint64_t{1} << 24;

/// Where light comes from: from `at`, or along parallel lines from the direction `at`, of any length.
struct LightPlace {
    vec3 at{0, 0, 1};
    bool is_directional = true;
    [[nodiscard]] LightPlace in_object(const mat4& scene_from_object) const;
};

class StrandBands {
public:
    static constexpr std::size_t pieces_per_block = OccluderBlock::capacity / 2;
    /// Of splines: spheres and cones are traced. Keeps nothing of them.
    explicit StrandBands(const Strands& strands);

    [[nodiscard]] std::size_t block_count() const { return (piece_count() + pieces_per_block - 1) / pieces_per_block; }
    /// Without columns: each light sample asks for them.
    [[nodiscard]] OccluderBlock block(std::size_t index) const;
    /// Where a block is written.
    using Columns = std::array<float, 9 * OccluderBlock::capacity>;
    /// The block with its triangles; `light` in the space of the strands.
    [[nodiscard]] OccluderBlock written(const OccluderBlock& block, std::size_t index, const LightPlace& light,
                                        Columns& columns) const;

private:
    enum Column : std::uint8_t { X, Y, Z, Radius, ColumnCount };

    /// One from each ring to the next; that between two strands is none.
    [[nodiscard]] std::size_t piece_count() const { return ring_count_ == 0 ? 0 : ring_count_ - 1; }

    std::size_t ring_count_ = 0;
    /// Of all strands, those that are near each other in sequence; a ring before the first and a block behind the last. A
    /// strand's first ring has a negative radius.
    std::array<std::vector<float>, ColumnCount> rings_;
};
/// Its blocks are written for each light.
[[nodiscard]] std::unique_ptr<const OccluderMesh> make_band_mesh(const Strands& strands);
} // namespace tyndall::light_shafts
