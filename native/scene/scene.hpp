// SPDX-License-Identifier: GPL-3.0-or-later
// An immutable scene: shared meshes, instances, materials, lights, world and media, with one committed Embree BVH.
// Space: all positions are relative to origin_in_world (double), so that a scene 60 km out keeps its millimetres.
#pragma once
#include "core/progress.hpp"
#include "core/statistics.hpp"
#include "scene/camera.hpp"
#include "scene/instance_masks.hpp"
#include "scene/instance_trees.hpp"
#include "scene/light.hpp"
#include "scene/lit_kinds.hpp"
#include "scene/placed_shapes.hpp"
#include "scene/shape_geometry.hpp"
#include "scene/spawn_offset.hpp"
#include "scene/triangle_mesh.hpp"
#include "scene/volume_instance.hpp"
#include "scene/world.hpp"
#include "shading/program_point.hpp"
#include "volume/medium.hpp"
#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tyndall {
struct Lobe; // shading/lobes/lobe.hpp
struct Instance {
    std::uint32_t mesh_index = 0;
    mat4 world_from_object{1.0f}; ///< Affine; may mirror. In the scene's space (relative to its origin).
    std::uint32_t name_index = 0; ///< Into SceneDescription::object_names.
    /// First entry in SceneDescription::slot_materials: slot s of the mesh has material slot_materials[first + s].
    std::uint32_t first_slot_material = 0;
    std::uint16_t slot_count = 1;
    bool is_camera_visible : 1 = true; ///< Bits, for there may be millions of instances.
    bool casts_shadow : 1 = true;
    bool is_bounce_visible : 1 = true; ///< Its light falls on other surfaces by a bounce.
    bool is_mirror_visible : 1 = true;
    bool is_glass_visible : 1 = true; ///< Through what bends rays.
    bool lights_media : 1 = true;     ///< Its light falls on media.
    bool is_held_out : 1 = false;     ///< What of it cameras see is cut out of the picture.
    /// Of it cameras see only the shadows that others cast on it.
    bool is_shadow_catcher : 1 = false;
    float random = 0.0f; ///< Its own, [0, 1): what Object Info calls so.
    /// Where it glows: shaders whose rays see it.
    [[nodiscard]] LitKinds lights_surfaces() const { return {is_bounce_visible, is_mirror_visible, is_glass_visible}; }
};

struct TransparentOperations;

struct SceneDescription {
    dvec3 origin_in_world{0.0}; ///< What was subtracted from every position; the scene itself never reads it.
    std::vector<std::shared_ptr<const TriangleMesh>> meshes;
    std::vector<Instance> instances;
    std::vector<std::shared_ptr<const ShapeGeometry>> shapes;
    std::vector<PlacedShape> placed_shapes;
    std::vector<std::string> object_names;
    std::vector<ObjectInfo> object_infos;      ///< As many as names, or none: then all are as ObjectInfo begins.
    std::vector<std::uint32_t> slot_materials; ///< Into materials.
    std::vector<Material> materials;
    std::vector<Medium> media;
    std::vector<VolumeInstance> volumes;
    std::vector<Light> lights;
    World world;
    std::int32_t world_medium_index = -1; ///< Into media: fills all space; -1: none.
    std::vector<ParticleState> particles; ///< Of instances, where a material asks for it.
    /// Into particles, or no_particle; as many as instances, or none: then none is one.
    std::vector<std::uint32_t> instance_particles;
    static constexpr std::uint32_t no_particle = ~0u;
    /// What instancers give to instances whose material asks: of each of these as many colours with alpha, in a row.
    std::vector<vec4> instancer_values;
    std::uint32_t instancer_value_count = 0; ///< Per row.
    /// Which row each instance has, or no_row; as many as instances, or none: then none has one.
    std::vector<std::uint32_t> instancer_rows;
    static constexpr std::uint32_t no_row = ~0u;

    /// Null: of no particle, or none that a material asks for.
    [[nodiscard]] const ParticleState* particle_of(std::uint32_t instance) const {
        const bool is_one = instance < instance_particles.size() && instance_particles[instance] != no_particle;
        return is_one ? &particles[instance_particles[instance]] : nullptr;
    }
    /// Empty: of no instance, or none whose material asks.
    [[nodiscard]] std::span<const vec4> instancer_values_of(std::uint32_t instance) const {
        if (instance >= instancer_rows.size() || instancer_rows[instance] == no_row)
            return {};
        return std::span(instancer_values)
            .subspan(std::size_t{instancer_rows[instance]} * instancer_value_count, instancer_value_count);
    }
    /// Whether a material of any of its slots has one.
    [[nodiscard]] bool has_surface(const Instance& instance) const {
        const auto slots = std::span(slot_materials).subspan(instance.first_slot_material, instance.slot_count);
        return std::ranges::any_of(slots, [&](std::uint32_t slot) { return materials[slot].has_surface; });
    }
    /// Of what a Hit's instance is.
    [[nodiscard]] std::uint32_t name_index_of(std::uint32_t instance) const {
        return instance < instances.size() ? instances[instance].name_index
                                           : placed_shapes[instance - instances.size()].name_index;
    }
};

/// Around the corners of a box, elsewhere.
[[nodiscard]] Bounds3 transformed(const Bounds3& bounds, const mat4& to_from);

struct Hit {
    float distance_m = 0.0f;
    /// Into SceneDescription::instances; from their number on, into its placed_shapes.
    std::uint32_t instance = ~0u;
    std::uint32_t triangle = ~0u; ///< Of the instance's mesh.
    std::uint64_t cell = 0;       ///< Of the placed shape: see CellHit; of strands, the segment.
    vec2 barycentrics{0.0f};      ///< Of a cell: along the two edges of its face; of strands: along and across.
    vec3 geometric_normal{
        0, 0, 1}; ///< Unit, scene space, as the triangle is wound (mirroring undone), out of a cell or strand.
    [[nodiscard]] bool is_hit() const { return instance != ~0u; }
};

/// Which random numbers a program's rays take.
struct ProgramRandom {
    std::uint32_t seed = 0;         ///< Of a pixel, or whatever else takes samples one after the other.
    std::uint32_t sample_index = 0; ///< Which of these asks.
};

/// A ray that asks what a surface is.
struct AskingRay {
    const Ray& ray;
    RayKind kind = RayKind::Camera;
    bool is_of_light = false;           ///< See ProgramPoint.
    float footprint_m = 0.0f;           ///< What a pixel covers at the hit; 0: not known.
    const Material* material = nullptr; ///< That is asked in place of the surface's own.
    /// Of rays that its program traces; nothing: it may trace none.
    std::optional<ProgramRandom> random = {};
};

/// Elsewhere than in another scene.
struct MovedInstance {
    std::uint32_t index = 0; ///< Into the instances that the other kept.
    mat4 world_from_object{1.0f};
};

/// Of the trees over instances, where some of these moved.
enum class TreeUpdate : std::uint8_t {
    Anew,   ///< Built again: what the scene shows is, bit for bit, what one shows that was made so.
    Beside, ///< One beside it, of what moved: of two surfaces in one place another one may answer than in such a scene.
};

class Scene {
public:
    /// Checks indices and commits Embree. Leaves out of the description, with one report per object: instances that cannot
    /// be drawn (a transform that is not finite or leaves only a line, an empty mesh), volumes likewise, and lights with
    /// broken numbers.
    /// Throws InvalidInput and Cancelled.
    Scene(SceneDescription description, const Progress& progress);
    /// The same geometry, materials and media under other lights and another world: shared, nothing is built again.
    Scene(const Scene& other, std::vector<Light> lights, World world);
    /// The same with some instances elsewhere, under the same lights: only the tree over all instances is built again, or
    /// where there are thousands of them, and it may be, one over those that moved. Throws InvalidInput for what
    /// cannot_move(), and Cancelled.
    Scene(const Scene& other, std::span<const MovedInstance> moved, TreeUpdate update, const Progress& progress);
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;
    ~Scene();

    /// Without lights and world, which lights() and world() tell.
    [[nodiscard]] const SceneDescription& description() const { return geometry_->description; }
    /// Why an instance cannot stand there without a scene of its own: it would be left out; nullptr where it can.
    [[nodiscard]] static const char* cannot_move(const MovedInstance& moved);
    [[nodiscard]] std::span<const Light> lights() const { return lights_; }
    [[nodiscard]] const World& world() const { return world_; }
    [[nodiscard]] const Bounds3& bounds() const { return geometry_->bounds; } ///< Of all kept instances.
    [[nodiscard]] const Bounds3& surface_bounds() const {
        return geometry_->surface_bounds;
    } ///< Of those with a surface.
    [[nodiscard]] const Statistics& statistics() const { return statistics_; }
    /// How far from its origin, along each axis, rays of this scene may start. From beyond they meet nothing, which is
    /// reported where something is there.
    [[nodiscard]] float reach_m() const { return geometry_->reach_m; }
    /// Instance i, as a Hit counts them, is geometry i of one of them, if it has a surface.
    [[nodiscard]] const InstanceTrees& trees() const { return geometry_->trees; }
    /// Everything but lights and world. Scenes that share it have the same; while it is held, no other takes its place.
    [[nodiscard]] std::shared_ptr<const void> geometry() const { return geometry_; }

    /// What a Hit's instance is, unless it is one of a mesh.
    [[nodiscard]] const PlacedShape* placed_shape(std::uint32_t instance) const {
        const std::size_t mesh_count = description().instances.size();
        return instance < mesh_count ? nullptr : &description().placed_shapes[instance - mesh_count];
    }
    /// As many as Hit::instance tells apart.
    [[nodiscard]] std::size_t instance_count() const {
        return description().instances.size() + description().placed_shapes.size();
    }
    /// Whether surfaces of the instance have normals of their own, so that shadow rays may have to be lifted.
    [[nodiscard]] bool is_smooth(std::uint32_t instance) const;
    /// Whether what cameras see of it is cut out of the picture.
    [[nodiscard]] bool is_held_out(std::uint32_t instance) const {
        const PlacedShape* const placed = placed_shape(instance);
        return placed != nullptr ? placed->is_held_out : description().instances[instance].is_held_out;
    }
    /// Whether cameras see only the shadows that others cast on it: what is held out too has none.
    [[nodiscard]] bool catches_shadows(std::uint32_t instance) const {
        return is_shadow_catcher(instance) && !is_held_out(instance);
    }
    [[nodiscard]] bool is_shadow_catcher(std::uint32_t instance) const {
        const PlacedShape* const placed = placed_shape(instance);
        return placed != nullptr ? placed->is_shadow_catcher : description().instances[instance].is_shadow_catcher;
    }
    [[nodiscard]] bool has_shadow_catchers() const { return geometry_->has_catchers; }
    /// Where it glows: shaders whose rays see it, and whether media do.
    [[nodiscard]] LitKinds lights_surfaces(std::uint32_t instance) const {
        const PlacedShape* const placed = placed_shape(instance);
        return placed != nullptr ? placed->lights_surfaces() : description().instances[instance].lights_surfaces();
    }
    [[nodiscard]] bool lights_media(std::uint32_t instance) const {
        const PlacedShape* const placed = placed_shape(instance);
        return placed != nullptr ? placed->lights_media : description().instances[instance].lights_media;
    }
    /// Whether some instance stands in the way of one kind of rays that gather light, and not of another.
    [[nodiscard]] bool tells_rays_apart() const { return geometry_->tells_rays_apart; }
    /// What the object of an instance is by itself.
    [[nodiscard]] const ObjectInfo& object_info(std::uint32_t instance) const {
        static const ObjectInfo plain;
        const std::vector<ObjectInfo>& infos = description().object_infos;
        return infos.empty() ? plain : infos[description().name_index_of(instance)];
    }
    /// Material of a hit triangle, or of a shape.
    [[nodiscard]] const Material& material(std::uint32_t instance, std::uint32_t triangle) const;
    /// Everything a surface program reads at a hit.
    [[nodiscard]] ShadingPoint shading_point(const Ray& ray, const Hit& hit) const;
    [[nodiscard]] SurfaceClosures closures(const Ray& ray, const Hit& hit) const;
    /// The same at the hit's own shading point.
    /// Appends lobes to `lobes`, where there is such a list; see evaluate().
    [[nodiscard]] SurfaceClosures closures(const AskingRay& asking, const ShadingPoint& point, const Hit& hit,
                                           std::vector<Lobe>* lobes = nullptr) const;
    /// What a cell of a placed shape that looks so would emit where the ray meets the hit, as a light.
    [[nodiscard]] Rgb emission_of(const CellLook& look, const Ray& ray, RayKind kind, const Hit& hit) const;
    /// closures().transparent alone, as rays of this kind see it, at less cost.
    [[nodiscard]] Rgb transparency(const Ray& ray, const Hit& hit, RayKind kind = RayKind::Shadow) const;
    /// What is left of a ray that passes a hit on its way to light, see StrandArrays::layers. The hit's normal is as Embree
    /// tells it, in object space and of any length.
    [[nodiscard]] Rgb passing_share(const Ray& ray, const Hit& hit, RayKind kind = RayKind::Shadow) const;
    /// Wherever, and by whichever ray of light, such a hit is met, it lets nothing pass.
    [[nodiscard]] bool is_opaque(const Hit& hit) const;

    /// Where rays leave a hit from.
    [[nodiscard]] SpawnPoint spawn_point(const Hit& hit) const;
    /// Where a ray in a unit direction that is to reach a hit ends, just before what it ends on.
    [[nodiscard]] vec3 arrival_point(const Hit& hit, const vec3& direction) const;
    /// spawn_point() of a view ray's hit. Of a cube of cells: beyond its corners on the shading normal's side, so that a surface
    /// of cells that runs through it and its neighbours does not shadow what its normal says is lit.
    [[nodiscard]] SpawnPoint spawn_point(const Ray& ray, const Hit& hit, const ShadingPoint& shading) const;
    /// Whether the hit is of a cube of cells of a placed shape.
    [[nodiscard]] bool is_cube(const Hit& hit) const;
    /// The ray that leaves a hit towards a unit direction: its origin is moved off the surface, to the direction's side,
    /// by just more than the error of its position, so that it never meets the triangle it leaves, nor skips another.
    [[nodiscard]] Ray leaving_ray(const Hit& hit, const vec3& direction,
                                  float far_m = std::numeric_limits<float>::infinity()) const;

    /// Nearest surface that shows to rays of a mask, cameras'. Instances without a surface shader (fog boxes) never answer.
    [[nodiscard]] Hit closest_hit(const Ray& ray, unsigned int mask = camera_mask, const RayDetail& detail = {}) const;
    /// The same for rays that go much the same way, as those of neighbouring pixels: at a third of the time. Where two
    /// triangles share the nearest point, which of them answers may depend on the other rays of the 16.
    /// `details` are as many as rays, or none: then rays meet every cell.
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits, unsigned int mask = camera_mask,
                      std::span<const RayDetail> details = {}) const;
    /// Once before rays ask for less than every cell; without it, they meet them all. Throws Cancelled.
    void prepare_detail(const Progress& progress) const;
    /// Light that passes along the ray through transparent surfaces, per channel; 0 behind an opaque one. Media are
    /// not included. Only instances that cast shadows count; for rays of another kind, those that show to it.
    [[nodiscard]] Rgb shadow_transmittance(const Ray& ray, Among among = Among::All,
                                           RayKind kind = RayKind::Shadow) const;
    /// The same without the instances of which bits_of_instance, one per instance, shares a bit with `ignored`.
    [[nodiscard]] Rgb shadow_transmittance(const Ray& ray, std::span<const std::uint64_t> bits_of_instance,
                                           std::uint64_t ignored, Among among = Among::All) const;
    /// The same for rays of neighbouring points towards one light: at less than half of the time.
    void shadow_transmittances(std::span<const Ray> rays, std::span<Rgb> passing,
                               std::span<const std::uint64_t> bits_of_instance = {}, std::uint64_t ignored = 0,
                               Among among = Among::All) const;
    /// Whether an instance may cast an emitter's shadows.
    [[nodiscard]] bool blocks(std::uint32_t instance, const LightLinks& links) const {
        return links.is_blocked_by_all() || links.is_blocked_by(object_info(instance).blocker_set);
    }
    /// The same as shadow_transmittances, of those that may.
    void shadow_transmittances(std::span<const Ray> rays, std::span<Rgb> passing, const LightLinks& links,
                               Among among = Among::All) const;
    /// How many of the rays meet no surface that casts shadows, whatever it lets pass.
    [[nodiscard]] std::size_t open_count(std::span<const Ray> rays) const;
    /// How many meet nothing of one instance.
    [[nodiscard]] std::size_t open_count(std::span<const Ray> rays, std::uint32_t instance) const;
    /// What the ray meets first of one instance, from either side; nothing of one that has no mesh.
    [[nodiscard]] Hit closest_hit_of(std::uint32_t instance, const Ray& ray) const;
    /// Appends all that a ray meets of one instance, from either side, in any order; nothing of one that has no mesh.
    void append_hits(const Ray& ray, std::uint32_t instance, std::vector<Hit>& hits) const;
    /// Per instance the bit of its object's blocker set; empty where all are in set 0.
    [[nodiscard]] std::span<const std::uint64_t> blocker_bits() const { return geometry_->blocker_bits; }
    /// Of an instance, to be normalized.
    [[nodiscard]] vec3 normal_in_scene(std::uint32_t instance, const vec3& normal) const {
        return normal_matrix(geometry_->objects_from_scene[instance]) * normal;
    }

private:
    [[nodiscard]] static mat3 normal_matrix(const mat4& object_from_scene);
    [[nodiscard]] ProgramPoint program_point(const AskingRay& asking, const ShadingPoint& point, const Hit& hit,
                                             const Material& surface) const;
    [[nodiscard]] const SharedMeshArrays& mesh_of(std::uint32_t instance) const; ///< Of one that has a mesh.
    [[nodiscard]] std::optional<Rgb> even_transparency(const Hit& hit) const; ///< Nothing: it differs between points.
    [[nodiscard]] ShadingPoint shading_point(const PlacedShape& placed, const Ray& ray, const Hit& hit) const;
    /// Appends the values of the material's UV maps and attributes.
    void look_up_uvs(const AskingRay& asking, const ProgramPoint& at, const Hit& hit, const Material& surface,
                     std::vector<vec2>& uvs) const;
    [[nodiscard]] const ShapeGeometry& shape_of(const PlacedShape& placed) const;
    struct Geometry {
        SceneDescription description; ///< Its lights and world are moved out.
        Bounds3 bounds, surface_bounds;
        Statistics statistics;
        InstanceTrees trees;
        std::vector<mat4> objects_from_scene;                      ///< Per instance, then per placed shape.
        float reach_m = std::numeric_limits<float>::max();         ///< See there.
        std::uint32_t name_of_least_reach = 0;                     ///< Of the object that limits it.
        std::vector<float> shape_lengths;                          ///< Per placed shape: see CellQuery.
        std::vector<TransparentOperations> transparent_operations; ///< Per material.
        bool lets_light_pass = false;            ///< Some instance in light's way is transparent, or has holes.
        std::vector<std::uint64_t> blocker_bits; ///< Per instance, then per placed shape; see blocker_bits().
        bool has_holes = false;                  ///< Some instance that is seen has slots without a surface.
        bool has_catchers = false;               ///< Some instance catches shadows.
        bool tells_rays_apart = false;           ///< See there.
        bool counts_passed = false;              ///< Of what lets light pass, some asks how much did so before.

        Geometry(SceneDescription scene, const Progress& progress);
        Geometry(const Geometry& other, std::span<const MovedInstance> moved, TreeUpdate update,
                 const Progress& progress);
        Geometry(const Geometry&) = delete;
        Geometry& operator=(const Geometry&) = delete;
        ~Geometry();
        [[nodiscard]] const TransparentOperations& transparent_operations_of(const Material& material) const;
        void validate() const;
        void drop_unusable_instances();
        void set_blocker_bits();
        /// Finds what shades the air in place of strands that let a part of the light pass; `scene` has this geometry.
        void narrow_strands(const Scene& scene, const Progress& progress);
        void report_unusable_strands(const Strands& strands);
        void drop_unusable_volumes();
        void attach_instances(const Progress& progress);
        void find_bounds();
        /// Of one more instance that stands where it does.
        void limit_reach(std::size_t instance, std::uint32_t name_index);
        void report_reach();
        void take(std::uint32_t index); ///< One of the instances, into the trees.
        void share_trees(const Geometry& other, std::span<const std::uint32_t> but);
        [[nodiscard]] const Material& slot_material(const Instance& instance, std::size_t slot) const;
    };
    void drop_unusable_lights();
    [[nodiscard]] Hit in_scene(const Ray& ray, Hit hit) const;

    std::vector<Light> lights_;
    World world_;
    std::shared_ptr<const Geometry> geometry_;
    Statistics statistics_;
};
} // namespace tyndall
