// SPDX-License-Identifier: GPL-3.0-or-later
// Which faces of cells glow: those that mesh_emitters.hpp aims at beside the triangles of meshes.
// Differs:  no cell is asked by itself. Some looks of cells are asked at a few places, by each kind of ray: where these all
//           see the same, what a cell emits follows from its look, and all looks are asked once. Where they do not, faces of
//           all cells may glow.
// Bound:    8 bytes a face; what CellShape::open_faces() takes, twice at most.
#pragma once
#include "scene/scene.hpp"
#include <vector>

namespace tyndall::render {
/// `instances`: placed shapes, as a Hit has them, of one shape of cells with one material. Faces of its cells, rising;
/// nothing where there are more than `most`.
[[nodiscard]] std::optional<std::vector<std::uint64_t>>
glowing_faces(const Scene& scene, std::span<const std::uint32_t> instances, std::size_t most);
} // namespace tyndall::render
