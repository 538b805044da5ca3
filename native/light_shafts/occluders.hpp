// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of a scene that stop light, as slope rows and depth maps read them.
#pragma once
#include "scene/scene.hpp"
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// Consecutive triangles of one instance, all opaque.
struct OccluderPiece {
    std::uint32_t instance = 0;
    std::span<const vec3> positions;  ///< In the object's space.
    std::span<const uvec3> triangles; ///< At most Occluders::piece_triangles.
    const mat4* scene_from_object = nullptr;
};

struct Occluders {
    static constexpr std::size_t piece_triangles = 4096;
    std::vector<OccluderPiece> pieces;
    std::size_t triangle_count = 0;
    /// A material that lets a part of the light pass, or whose program decides where: a yes or no per light line
    /// cannot hold it, and the caller falls back to a method that follows the light through surfaces.
    std::optional<std::string> transmitting_material;
    /// Triangles of meshes where only some materials are opaque.
    std::vector<std::unique_ptr<std::vector<uvec3>>> selected;
};
[[nodiscard]] Occluders gather_occluders(const SceneDescription& scene);
} // namespace tyndall::light_shafts
