// SPDX-License-Identifier: GPL-3.0-or-later
// Which faces of cells glow: those that mesh_emitters.hpp aims at beside the triangles of meshes.
// Differs:  no cell is asked by itself. Some looks of cells are asked at a few places, by each kind of ray: where these all
//           see the same, what a cell emits follows from its look, and other looks are asked once; those that glow are all
//           asked so. Where what they see differs, faces of all cells may glow.
// Bound:    8 bytes a face; what CellShape::open_faces() takes, twice at most.
#pragma once
#include "scene/scene.hpp"
#include <vector>

namespace tyndall::render {
struct GlowingFaces {
    std::vector<std::uint64_t> cells; ///< With the face, as a Hit has them; rising.
    bool follow_looks = true;         ///< Each emits the same all over, to all sides, and for all rays.
};
/// `instances`: placed shapes, as a Hit has them, of one shape of cells with one material. Nothing where there are more
/// faces than `most`. Throws Cancelled.
[[nodiscard]] std::optional<GlowingFaces> glowing_faces(const Scene& scene, std::span<const std::uint32_t> instances,
                                                        std::size_t most, const Progress& progress);
} // namespace tyndall::render
