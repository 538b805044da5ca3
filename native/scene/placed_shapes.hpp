// SPDX-License-Identifier: GPL-3.0-or-later
// Shapes, of cells or strands, that stand in a scene, and those of them that cast shadows, traced by themselves: what
// depth maps and slope rows draw where meshes give them triangles.
#pragma once
#include "core/progress.hpp"
#include "scene/cell_geometry.hpp"
#include "scene/lit_kinds.hpp"
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tyndall {
struct PlacedShape {
    std::uint32_t shape_index = 0; ///< Into SceneDescription::shapes.
    mat4 world_from_object{1.0f};  ///< Affine; may mirror. In the scene's space.
    std::uint32_t name_index = 0, material_index = 0;
    bool is_camera_visible = true;
    bool casts_shadow = true;
    bool is_bounce_visible = true; ///< Its light falls on other surfaces by a bounce.
    bool is_mirror_visible = true;
    bool is_glass_visible = true;   ///< Through what bends rays.
    bool lights_media = true;       ///< Its light falls on media.
    bool is_held_out = false;       ///< What of it cameras see is cut out of the picture.
    bool is_shadow_catcher = false; ///< Of it cameras see only the shadows that others cast on it.
    std::int32_t shade_index = -1;  ///< Which shape shades the air in its place, set by the scene; -1: it does itself.
    float random = 0.0f;            ///< As Instance's.
    /// The same.
    [[nodiscard]] LitKinds lights_surfaces() const { return {is_bounce_visible, is_mirror_visible, is_glass_visible}; }
    bool operator==(const PlacedShape&) const = default;
};

struct SceneDescription; // scene/scene.hpp

/// In the scene's space.
[[nodiscard]] Bounds3 bounds_of(const SceneDescription& scene, const PlacedShape& placed);
/// Whether light is stopped by it, or a part of it: voxels are opaque, unless all of it is to pass.
[[nodiscard]] bool stops_light(const SceneDescription& scene, const PlacedShape& placed);
/// What of it shades the air, index into SceneDescription::shapes; nothing: no part of it.
[[nodiscard]] std::optional<std::uint32_t> shade_of(const SceneDescription& scene, const PlacedShape& placed);

/// Some placed shapes with an Embree scene of their own.
class ShapeTracer {
public:
    /// `placed`: into SceneDescription::placed_shapes. The scene must outlive this. Throws Cancelled.
    ShapeTracer(const SceneDescription& scene, std::vector<std::uint32_t> placed, const Progress& progress);
    ShapeTracer(const ShapeTracer&) = delete;
    ShapeTracer& operator=(const ShapeTracer&) = delete;
    ~ShapeTracer();

    [[nodiscard]] std::span<const std::uint32_t> placed() const { return placed_; }
    [[nodiscard]] const Bounds3& bounds() const { return bounds_; } ///< In the scene's space.
    /// How far the ray gets, in lengths of its direction; infinite where it meets nothing, or
    /// starts farther out than Embree can reckon with in each shape's space.
    [[nodiscard]] float distance_to_nearest(const Ray& ray) const;

private:
    std::vector<std::uint32_t> placed_;
    Bounds3 bounds_;
    float reach_m_; ///< How far from the origin rays may start.
    RTCScene embree_scene_ = nullptr;
};
} // namespace tyndall
