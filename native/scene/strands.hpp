// SPDX-License-Identifier: GPL-3.0-or-later
// Hair and points: strands with a radius at each of their points, or spheres, as Embree's curves and points.
// Based on: Embree 3's flat and round Catmull-Rom curves, round linear ones and sphere points; Catmull and Rom 1974.
// Differs:  the ends of a strand are doubled, and a ribbon's normals are those of a round hair, as in Cycles.
// Bound:    16 bytes per point and 32 per strand, 4 per segment, and Embree's BVH; a hit costs one look at its segment.
#pragma once
#include "core/progress.hpp"
#include "scene/camera.hpp"
#include "scene/shape_geometry.hpp"
#include "scene/triangle_mesh.hpp"
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tyndall {
enum class StrandForm : std::uint8_t {
    Ribbon = 0,      ///< A band that faces each ray, shaded as if it were round.
    Round = 1,       ///< A tube around the spline.
    RoundLinear = 2, ///< Cones between the points.
    Spheres = 3      ///< No strands: each point by itself.
};

struct StrandArrays {
    std::string name;
    StrandForm form = StrandForm::Ribbon;
    std::vector<vec4> points = {}; ///< In object space, and the radius.
    /// Of each strand its first point, ascending from 0. Of spheres nothing.
    std::vector<std::uint32_t> first_points = {};
    std::uint32_t ribbon_pieces = 4; ///< Straight pieces that Embree makes of a ribbon's segment, [1, 16].
    /// How often a ray on its way to light is dimmed by a strand that it passes, {1, 2}: also where it leaves a tube, as in
    /// Cycles from 4.0 on. Camera rays see the near side alone there, too.
    std::uint32_t layers = 1;
    struct Map {
        std::string name;         ///< As those of a mesh: see SharedMeshArrays::uv_maps.
        std::vector<vec2> values; ///< One per strand, or sphere; or one per point, straight between them.
    };
    std::vector<Map> maps = {};
    std::vector<float> randoms = {}; ///< Likewise, [0, 1); empty: all 0.
};

/// Where a ray has met a strand or sphere, in its object's space.
struct StrandPoint {
    vec3 centre{0.0f}; ///< On the spline, or of the sphere.
    float radius_m = 0.0f;
    vec3 tangent{0.0f}; ///< Not of unit length; 0: a sphere.
    vec3 normal{0, 0, 1};
};

/// Immutable, safe from any thread.
class Strands final : public ShapeGeometry {
public:
    /// Leaves out, and counts, what is not finite, and strands without a length or a width. Throws InvalidInput for
    /// indices out of range and arrays of wrong length; Cancelled.
    Strands(StrandArrays arrays, const Progress& progress);
    ~Strands() override;

    [[nodiscard]] const std::string& name() const override { return arrays_.name; }
    [[nodiscard]] const Bounds3& bounds() const override { return bounds_; }
    [[nodiscard]] RTCScene embree_scene() const override { return embree_scene_; }
    [[nodiscard]] const Strands* strands() const override { return this; }

    [[nodiscard]] StrandForm form() const { return arrays_.form; }
    [[nodiscard]] std::uint32_t ribbon_pieces() const { return arrays_.ribbon_pieces; }
    [[nodiscard]] std::uint32_t layers() const { return arrays_.layers; }
    [[nodiscard]] bool are_splines() const { return form() == StrandForm::Ribbon || form() == StrandForm::Round; }
    [[nodiscard]] std::size_t strand_count() const; ///< Or spheres.
    [[nodiscard]] std::size_t segment_count() const;
    [[nodiscard]] std::span<const vec4> points_of(std::uint32_t strand) const; ///< With both ends doubled.
    [[nodiscard]] std::size_t non_finite_count() const { return non_finite_count_; }
    [[nodiscard]] std::size_t degenerate_count() const { return degenerate_count_; }

    /// `segment`, `on` and `normal`, of any length, are what Embree's hit says; `direction` is the ray's, in object space.
    [[nodiscard]] StrandPoint point(std::uint32_t segment, vec2 on, const vec3& direction, const vec3& normal) const;
    /// Without a normal.
    [[nodiscard]] StrandPoint on_spline(std::uint32_t segment, float along) const;
    [[nodiscard]] Bounds3 segment_bounds(std::uint32_t segment) const;
    /// What a program reads there under a name of uv_map_names; (0, 0) where there is no such thing.
    /// normal, along: of the strand, as strand_maps tells them; place: in object space.
    [[nodiscard]] vec2 look_up(std::string_view name, std::uint32_t segment, vec2 on, const vec3& normal,
                               const vec3& along = vec3(0.0f), const vec3& place = vec3(0.0f)) const;
    /// What the name "" stands for; nothing: there is no such map.
    [[nodiscard]] std::optional<vec2> active_uv(std::uint32_t segment, vec2 on) const;
    /// Of triangles, as wide on average over all sides; built when first asked for.
    [[nodiscard]] const TriangleBvh& tubes(const Progress& progress) const;

private:
    [[nodiscard]] const StrandArrays::Map* find_map(std::string_view name) const;
    void drop_unusable();
    void build(const Progress& progress);
    [[nodiscard]] std::uint32_t strand_of(std::uint32_t segment) const;
    [[nodiscard]] float linear_radius(std::uint32_t segment, float along) const;
    [[nodiscard]] vec2 value_of(const StrandArrays::Map& map, std::uint32_t segment, float along) const;

    StrandArrays arrays_; ///< Ends doubled.
    Bounds3 bounds_;
    std::size_t non_finite_count_ = 0, degenerate_count_ = 0;
    RTCScene embree_scene_ = nullptr;
    mutable std::mutex tubes_mutex_;
    mutable std::shared_ptr<const TriangleBvh> tubes_; ///< Shared, not unique: deleted where the type is unknown.
};

/// What programs read of any surface's texture space; strands and points without one have their places, as in Cycles.
inline constexpr std::string_view generated_xy = "\x1fxy generated", generated_zw = "\x1fzw generated";

/// Names under which programs read of strands what Cycles' Hair Info node tells. Meshes and cells have none of it: 0.
namespace strand_maps {
inline constexpr std::string_view is_strand = "\x1f"
                                              "hair is",                        // 1, 0
    intercept_and_length = "\x1fhair il", random_and_thickness = "\x1fhair rt", // each in metres or [0, 1]
    normal_xy = "\x1fhair xy", normal_z = "\x1fhair z",                         // of the strand, facing the ray
    along_xy = "\x1fhair axy",
                                  along_z =
                                      "\x1fhair az"; // from root to tip, of any length; behind it two corners' numbers
/// Meshes have this one: along their triangle's edge from one of those corners to the other, 0 to 2. 0 for other names.
[[nodiscard]] vec2 of_edge(std::string_view name, const SharedMeshArrays& mesh, std::uint32_t triangle,
                           const mat4& world_from_object);
} // namespace strand_maps
} // namespace tyndall
