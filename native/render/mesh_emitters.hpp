// SPDX-License-Identifier: GPL-3.0-or-later
// What glows, as lights: triangles of meshes and halves of cells' faces, how bright they are, and places on them for one
// point; and shapes that rays meet by chance alone.
// Based on: Arvo, Stratified Sampling of Spherical Triangles, SIGGRAPH 1995, for those that are wide as seen from the point.
// Differs:  others are sampled by area. How bright a triangle is that a program colours is asked at a few of its places;
//           those that seem dark there are drawn seldom, not never.
//           Of hair, points, and more faces of cells than most_of_cells no place is aimed at.
// Bound:    120 bytes a triangle.
#pragma once
#include "render/cell_emitters.hpp"
#include "render/light_tree.hpp"
#include "scene/scene.hpp"
#include <algorithm>
#include <memory>
#include <unordered_map>
#include <vector>

namespace tyndall::render {
struct EmissiveTriangle {
    std::uint32_t instance, triangle;
    std::uint64_t cell = 0; ///< And face, as a Hit has them; of meshes 0.
    bool is_upper = false;  ///< Of that face the half that ends where both of its edges do.
    std::array<vec3, 3> corners;
    vec3 normal; ///< Unit, as a Hit has it.
    float area_m2;
    float radiance;     ///< Mean of its channels, without their signs, about.
    bool is_constant;   ///< It emits the same everywhere, to all sides.
    float back;         ///< How likely its back is seen: less of a closed mesh.
    Rgb emission{0.0f}; ///< If it is constant.
};

/// A place on a triangle, seen from a point.
struct TrianglePoint {
    vec3 position{0.0f};
    vec2 barycentrics{0.0f};
    float pdf_per_sr = 0.0f; ///< 0: there is none.
};

/// As a ray would meet that place, at this distance.
[[nodiscard]] inline Hit hit_at(const EmissiveTriangle& triangle, vec2 barycentrics, float distance_m) {
    Hit hit;
    hit.distance_m = distance_m;
    hit.instance = triangle.instance;
    hit.triangle = triangle.triangle;
    hit.cell = triangle.cell;
    hit.barycentrics = triangle.is_upper ? 1.0f - barycentrics : barycentrics;
    hit.geometric_normal = triangle.normal;
    return hit;
}

/// Of the instances that light surfaces, or media.
class MeshEmitters {
public:
    static constexpr std::size_t most_of_cells = std::size_t{1} << 17; ///< Triangles.

    MeshEmitters() = default;
    /// Throws Cancelled.
    explicit MeshEmitters(const Scene& scene, const Progress& progress = Progress{});

    [[nodiscard]] std::span<const EmissiveTriangle> triangles() const { return triangles_; }
    [[nodiscard]] static LightBounds bounds_of(const EmissiveTriangle& triangle);
    /// One of these; nullptr: the hit is of none.
    [[nodiscard]] const EmissiveTriangle* triangle_of(const Hit& hit) const {
        const std::uint32_t index = index_of(hit);
        return index != LightTree::none ? &triangles_[index] : nullptr;
    }
    /// Placed shapes that glow, as a Hit has them: none of their places is aimed at.
    [[nodiscard]] std::span<const std::uint32_t> met_alone() const { return met_alone_; }
    [[nodiscard]] bool is_met_alone(const Hit& hit) const {
        return std::ranges::binary_search(met_alone_, hit.instance);
    }
    [[nodiscard]] bool is_empty() const { return triangles_.empty() && met_alone_.empty(); }
    /// Of all that glows, each once.
    [[nodiscard]] std::vector<std::uint32_t> instances() const;
    /// False: the ray misses all that glows, whatever stands before it.
    [[nodiscard]] bool may_meet(const Ray& ray) const;
    /// Radiance that leaves a hit, which may be of a triangle, towards where the ray comes from.
    [[nodiscard]] static Rgb radiance(const Scene& scene, const EmissiveTriangle* triangle, const Ray& ray,
                                      const Hit& hit, RayKind kind = RayKind::Diffuse);

private:
    [[nodiscard]] std::uint32_t index_of(const Hit& hit) const; ///< LightTree::none: of no triangle.
    void add_mesh(const Scene& scene, std::uint32_t instance, std::span<const std::uint8_t> glows);
    void add_shapes(const Scene& scene, std::span<const std::uint8_t> glows, const Progress& progress);
    void add_faces(const Scene& scene, std::uint32_t instance, const std::shared_ptr<const GlowingFaces>& faces);
    void find_radiances(const Scene& scene, const Progress& progress);
    void find_boxes(const SceneDescription& scene);

    std::vector<EmissiveTriangle> triangles_;
    std::vector<std::uint32_t> first_of_instance_; ///< Into index_of_triangle_; none: it does not glow.
    std::vector<std::uint32_t> index_of_triangle_;
    struct CellFaces {
        std::uint32_t first = 0; ///< Two triangles a face.
        std::shared_ptr<const GlowingFaces> faces;
    };
    std::unordered_map<std::uint32_t, CellFaces> faces_of_shape_; ///< By the instance of a Hit.
    std::vector<std::uint32_t> met_alone_;                        ///< Ascending.
    std::vector<Bounds3> boxes_; ///< Around all that glows: one for each object, or one for many.
};
/// Uniform in the solid angle where that is wide, else in the area.
[[nodiscard]] TrianglePoint triangle_point(const std::array<vec3, 3>& corners, const vec3& from, vec2 u);
/// Per steradian, with which triangle_point() takes the direction in which a place on it lies.
[[nodiscard]] float triangle_pdf_per_sr(const std::array<vec3, 3>& corners, const vec3& from, const vec3& place);
} // namespace tyndall::render
