// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of a scene that stop light, as slope rows and depth maps read them: blocks of up to 256 that lie close
// together, in columns, once per mesh however many instances and light samples there are.
// Bound:    36 bytes per triangle of a mesh, read at the width of a vector; no gather, no index. What was sorted for another
//           scene of the same meshes is not sorted again.
#pragma once
#include "core/progress.hpp"
#include "light_shafts/transparency_lookup.hpp"
#include "scene/scene.hpp"
#include <map>
#include <memory>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// Triangles of a mesh that lie close together.
struct OccluderBlock {
    static constexpr std::size_t capacity = 256;
    const float* columns = nullptr; ///< Nine: x, y, z of corner 0, then of 1 and 2; each `stride` floats long.
    std::uint32_t stride = 0;       ///< A multiple of 16; what is beyond `count` repeats the last triangle.
    std::uint32_t count = 0;
    Bounds3 bounds; ///< In the object's space.
    [[nodiscard]] vec3 corner(std::size_t triangle, std::size_t index) const {
        const float* x = columns + 3 * index * stride + triangle;
        return {x[0], x[stride], x[2 * stride]};
    }
};
class StrandBands; // strand_bands.hpp

struct OccluderMesh {
    std::vector<float> columns;
    std::vector<OccluderBlock> blocks;
    std::vector<std::uint32_t> order; ///< Of the triangles it was made of: block b begins with order[capacity * b].
    Bounds3 bounds;
    std::shared_ptr<const StrandBands>
        bands; ///< Writes the blocks, which have no columns, for each light; nothing: a mesh.
};
struct OccluderInstance {
    const OccluderMesh* mesh = nullptr;
    const mat4* scene_from_object = nullptr;
    std::uint32_t index = 0; ///< Into SceneDescription::instances, or from their number on, into its placed_shapes.
};

/// The triangles of a mesh that let a part of the light pass.
struct PartialOccluderMesh {
    /// How a triangle's material slot is looked up.
    struct Slot {
        const TransparencyLookup* lookup = nullptr; ///< Nothing: its triangles are not among these.
        std::vector<const vec2*> corner_uvs;        ///< Per UV map of the material; nothing where the mesh lacks it.
    };
    std::shared_ptr<const OccluderMesh> geometry;
    std::vector<std::uint32_t> triangles; ///< Of the scene's mesh, in the order of the blocks.
    const SharedMeshArrays* arrays = nullptr;
    std::vector<Slot> slots;
    bool is_coloured = false;
};
struct PartialOccluderInstance {
    const PartialOccluderMesh* mesh = nullptr;
    const mat4* scene_from_object = nullptr;
    std::uint32_t index = 0; ///< Into SceneDescription::instances.
    // What programs read of the object.
    mat4 object_from_scene{1.0f};
    const ObjectInfo* info = nullptr;
    float random = 0.0f;
    const ParticleState* particle = nullptr;
    vec3 origin_in_world{0.0f};
};

class KeptCasts; // map_cache.hpp

struct Occluders {
    /// Of which triangles of what a mesh is.
    struct Source {
        std::shared_ptr<const void> geometry; ///< A TriangleMesh, or a ShapeGeometry.
        std::vector<bool> has_slot;           ///< Empty: it has all.
        auto operator<=>(const Source&) const = default;
    };
    std::multimap<Source, std::shared_ptr<const OccluderMesh>> meshes; ///< Of equal ones any will do.
    std::vector<OccluderInstance> instances;
    std::size_t triangle_count = 0; ///< Of all opaque instances.
    /// Shapes of too many cells or pieces of strands to be instances, and spheres and cones; nothing: there are none.
    std::shared_ptr<const ShapeTracer> traced;
    std::vector<std::unique_ptr<const TransparencyLookup>> lookups;
    std::vector<std::unique_ptr<const PartialOccluderMesh>> partial_meshes;
    std::vector<PartialOccluderInstance> partial_instances;
    /// Rays of the scene they were gathered of meet, on their way to a light, nothing else, and no light passes what they meet.
    bool are_whole = false;
    std::shared_ptr<const KeptCasts> kept; ///< What they cast in other frames; nothing: nothing is kept.

    [[nodiscard]] bool is_empty() const { return triangle_count == 0 && partial_instances.empty() && !traced; }
    [[nodiscard]] std::shared_ptr<const OccluderMesh> mesh_of(const Source& source) const; ///< Nothing: there is none.
    /// `scene_from_object` must outlive this.
    void add(const OccluderMesh* mesh, const mat4* scene_from_object, std::uint32_t index = 0);
    /// One that is no mesh of a scene.
    void add(std::unique_ptr<const OccluderMesh> mesh, const mat4* scene_from_object);
};
/// Sorts the triangles into blocks; keeps nothing of its arguments.
[[nodiscard]] std::unique_ptr<const OccluderMesh> make_occluder_mesh(std::span<const vec3> positions,
                                                                     std::span<const uvec3> triangles);
/// The triangles in the order of the cells of a coarse grid, along Morton's curve, so that blocks are small.
[[nodiscard]] std::vector<std::uint32_t> order_in_space(std::span<const vec3> positions,
                                                        std::span<const uvec3> triangles, const Bounds3& bounds);
/// Whether maps and rows draw a shape that stands so often in the scene; else they trace it.
[[nodiscard]] bool is_drawn(const ShapeGeometry& shape, std::size_t place_count);
/// The scene must outlive the result, which takes over the meshes that another one has. Throws Cancelled.
[[nodiscard]] Occluders gather_occluders(const SceneDescription& scene, const Progress& progress,
                                         const Occluders* another = nullptr);
/// Those that block an emitter. `occluders`, whose meshes it shares, and the scene must outlive the result. Throws Cancelled.
[[nodiscard]] std::unique_ptr<const Occluders> blocking(const Scene& scene, const Occluders& occluders,
                                                        const LightLinks& links, const Progress& progress);
} // namespace tyndall::light_shafts
