// SPDX-License-Identifier: GPL-3.0-or-later
// The inner loop of the exact strip: one view ray, one light, one mesh.
// Based on: the ray query of shaft-kernels, section 2: cut every triangle that stands between ray and light with their
//           plane, and unite the intervals that the cuts shadow.
// Differs:  16 boxes and 16 triangles per step instead of one (x86-64-v2, AVX2, AVX-512; the same results); a light at a
//           point as well as at infinity; no parameter.
// Bound:    18 multiply-adds per 16 boxes (24 for a local light), 27 and two divisions per 16 triangles.
//           Error: a shadow's edge is where the float positions, turned by the float plane, put it: sideways within
//           8 eps of the largest coordinate and distance involved, eps = 6e-8; along the ray that divided by the sine
//           of the angle between ray and light. No shadow is missed or invented at the ray's ends: y = 0, the ray
//           itself, is told from y > 0 before anything is divided.
#pragma once
#include "light_shafts/shadow_union.hpp"
#include "light_shafts/transparency_lookup.hpp"
#include "scene/cell_shape.hpp"
#include "scene/plane_cut.hpp"
#include "scene/triangle_bvh.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// One view ray and one light in the coordinates of their plane: x along the ray, y towards the light.
struct StripRay {
    PlaneCoordinates<double> coordinates;
    bool is_local = false;
    float cotangent = 0.0f;               ///< Directional: of the angle between the ray and the light.
    float light_x = 0.0f, light_y = 0.0f; ///< Local: the light.
    float near_m = 0.0f, far_m = 0.0f;
};

struct StripMesh {
    const TriangleBvh* bvh = nullptr;
    mat4 world_from_object{1.0f};
    /// Occlusion of each material slot; empty: all opaque.
    std::vector<Occlusion> occlusion_of_slot;
    std::span<const std::uint16_t> slot_of_triangle = {};
    std::uint32_t instance = 0; ///< Into SceneDescription::instances.
};
struct StripShape {
    const CellShape* shape = nullptr;
    mat4 world_from_object{1.0f};
};
/// A cut triangle that may let light pass: it shadows [near_m, far_m] partly.
struct PartialCut {
    std::uint32_t mesh; ///< Into StripScene::meshes.
    std::uint32_t triangle;
    float near_m, far_m;
};
struct StripScene {
    std::vector<StripMesh> meshes;
    std::vector<StripShape> shapes;
    std::vector<std::unique_ptr<const TransparencyLookup>> lookups; ///< Per material of the scene; null: none needed.
    WideBvh top;          ///< Over boxes in the scene's space, the meshes' and then the shapes'; a leaf holds one.
    vec3 top_reach{0.0f}; ///< Largest absolute coordinate of those boxes, per axis.
    [[nodiscard]] std::size_t object_count() const { return meshes.size() + shapes.size(); }
};
struct StripCounters {
    std::uint64_t nodes = 0, blocks = 0;
};
/// What one ray's traversal fills; kept per thread, so that nothing is allocated per ray.
struct StripShadows {
    ShadowUnion opaque;
    std::vector<PartialCut> partial;
    StripCounters counters;
};

/// Finds all shadows on [ray.near_m, ray.far_m]. `shadows` is reset first.
void find_shadows(const StripScene& scene, const StripRay& ray, StripShadows& shadows);
} // namespace tyndall::light_shafts
