// SPDX-License-Identifier: GPL-3.0-or-later
// A triangle mesh in its object's space: immutable, shared by instances and by frames, with its own Embree BVH.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include "core/shared_array.hpp"
#include <embree3/rtcore.h>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace tyndall {
class TriangleBvh; // scene/triangle_bvh.hpp: for cuts with planes

/// To make a mesh of.
struct MeshArrays {
    std::string name;
    std::vector<vec3> positions = {};
    std::vector<uvec3> triangles = {};
    std::vector<std::uint16_t> material_slots = {};
    std::vector<vec3> corner_normals = {};
    struct UvMap {
        std::string name;
        std::vector<vec2> corner_uvs;
    };
    std::vector<UvMap> uv_maps = {};
};

/// What a mesh is: read by many, such as who made it, and changed by none.
struct SharedMeshArrays {
    SharedMeshArrays() = default;
    SharedMeshArrays(MeshArrays arrays); // NOLINT(google-explicit-constructor): nothing is lost

    std::string name;
    SharedArray<vec3> positions; ///< With position_slack_bytes behind the last one.
    SharedArray<uvec3> triangles;
    SharedArray<std::uint16_t> material_slots; ///< Per triangle; empty: all 0.
    SharedArray<vec3> corner_normals;          ///< 3 per triangle; empty: flat. Zero vectors: flat at that corner.
    struct UvMap {
        std::string name;
        SharedArray<vec2> corner_uvs; ///< 3 per triangle.
    };
    /// And pairs of attributes (attribute_pairs.hpp). The first of either is the active one for rendering.
    std::vector<UvMap> uv_maps;

    /// Embree reads positions in place, 16 bytes at a time.
    static constexpr std::size_t position_slack_bytes = 4;

    [[nodiscard]] std::uint16_t slot_of(std::size_t triangle) const {
        return material_slots.empty() ? std::uint16_t{0} : material_slots[triangle];
    }
    /// The UV map or pair of this name, the active one for an empty name; nothing where the mesh lacks it.
    [[nodiscard]] const UvMap* uv_map(const std::string& map_name) const;
};

/// Of a mesh's tree. Rays meet the same triangles in both; but where two share the nearest point, another may answer.
enum class TreeQuality : std::uint8_t {
    Best,
    Hasty, ///< Built in 0.3 of the time, by Morton codes; rays then take some 1.5 times as long.
};

class TriangleMesh {
public:
    /// A mesh of fewer triangles has the best tree at once.
    static constexpr std::size_t fewest_for_haste = 1 << 15;

    /// Drops triangles with a non-finite vertex or zero area and counts them; commits an Embree BVH in object space.
    /// Throws InvalidInput, naming the mesh, for an index out of range or arrays of wrong length; Cancelled.
    TriangleMesh(SharedMeshArrays arrays, const Progress& progress, TreeQuality quality = TreeQuality::Best);
    TriangleMesh(const TriangleMesh&) = delete;
    TriangleMesh& operator=(const TriangleMesh&) = delete;
    ~TriangleMesh();

    [[nodiscard]] const SharedMeshArrays& arrays() const { return arrays_; }
    [[nodiscard]] const Bounds3& bounds() const { return bounds_; }
    [[nodiscard]] std::size_t triangle_count() const { return arrays_.triangles.size(); }
    /// With a vertex that is not finite or beyond largest_coordinate_m.
    [[nodiscard]] std::size_t non_finite_triangle_count() const { return non_finite_triangle_count_; }
    [[nodiscard]] std::size_t degenerate_triangle_count() const { return degenerate_triangle_count_; }
    [[nodiscard]] RTCScene embree_scene() const { return embree_scene_; } ///< Its triangles are geometry 0.
    [[nodiscard]] bool has_hasty_tree() const { return quality_ == TreeQuality::Hasty; }
    /// Builds the best tree in the place of a hasty one; scenes of the mesh have it at once, so no ray may be under way in
    /// any of them. Throws Cancelled, after which the tree is a hasty one again.
    void finish_tree(const Progress& progress) const;
    /// Built when first asked for; safe from any thread.
    [[nodiscard]] const TriangleBvh& cut_bvh(const Progress& progress) const;
    /// See closed_mesh.hpp. Found when first asked for; safe from any thread.
    [[nodiscard]] bool is_closed() const;

private:
    void drop_unusable_triangles();
    void build(const Progress& progress);
    void commit_tree(TreeQuality quality, const Progress& progress) const;

    SharedMeshArrays arrays_;
    Bounds3 bounds_;
    std::size_t non_finite_triangle_count_ = 0, degenerate_triangle_count_ = 0;
    RTCScene embree_scene_ = nullptr;
    mutable TreeQuality quality_;
    mutable std::mutex found_mutex_;
    mutable std::shared_ptr<const TriangleBvh> cut_bvh_; ///< Shared, not unique: deleted where the type is unknown.
    mutable std::optional<bool> is_closed_;
};
} // namespace tyndall
