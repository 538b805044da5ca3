// SPDX-License-Identifier: GPL-3.0-or-later
// Light that reaches a diffuse surface straight from the scene's lights and world, through what lies between.
// Based on: next event estimation; the world's light by multiple importance sampling, Veach, dissertation, Stanford
//           1997, section 9.2, between the cosine, the image and lobes.
// Differs:  up to 32 lights are asked at every point, not one picked at random: no noise from the choice. In packets a
//           shadow ray costs less than to learn what its light contributes. Where lamps are more, and of meshes that glow,
//           a few are drawn (many_lights.hpp), which together count as one light.
//           Light on lobes by one more strategy, their own directions, beside the shadow rays of Lambert's share.
//           The world has one ray, drawn from one of its strategies by chance (Veach, 9.2.4: one-sample model, balance
//           heuristic), not one from each: the pilot asks for more where they are worth it.
// Bound:    a shadow ray per light that may reach the point, in packets of 16 points; one of its own for the world, one more
//           where a lamp's mirror image meets lobes; times a light's ray count.
#pragma once
#include "light_shafts/occluders.hpp"
#include "light_shafts/surface_holes.hpp"
#include "light_shafts/surface_shadows.hpp"
#include "render/indirect_config.hpp"
#include "render/light_aim.hpp"
#include "render/many_lights.hpp"
#include "render/pixel_samples.hpp"
#include "render/surface_point.hpp"
#include "scene/media.hpp"
#include "scene/moved_instances.hpp"
#include "scene/scene.hpp"
#include "shading/lobes/lobe_set.hpp"
#include <array>
#include <span>

namespace tyndall::render {
/// What a light asks of up to lane_count points.
[[nodiscard]] LitPoints lanes_of(std::span<const SurfacePoint> points);

class DirectLight {
public:
    /// Points that are lit at once.
    static constexpr std::size_t most_points = lane_count;

    /// Reports to `statistics` what cannot light anything. Both references must outlive this. The world's
    /// light is stopped within the reach of `indirect`. Throws Cancelled.
    DirectLight(const Scene& scene, const Media& media, Statistics& statistics, const IndirectConfig& indirect = {},
                KeptLightTrees* kept = nullptr, const Progress& progress = Progress{});

    /// For those lights that `is_asked`: what the edits of their occluders put before surfaces. Once per light; without
    /// it, at() and add_one() know nothing of such edits. Throws Cancelled.
    void prepare_edits(std::span<const std::uint8_t> is_asked, const Camera& camera, const light_shafts::Config& shafts,
                       Statistics& statistics, const Progress& progress);

    /// Lobes of each point; most have none.
    using PointLobes = std::array<LobeSet, most_points>;

    struct Irradiance {
        Rgb from_lights{0.0f}; ///< With occluders and media between, W/m^2.
        Rgb unshadowed{0.0f};  ///< The same lights with nothing between.
        Rgb from_world{0.0f};  ///< With occluders and media between.
        Rgb reflected{0.0f};   ///< Of all of these, towards the viewer by the point's lobes: radiance.
        [[nodiscard]] Rgb sum() const { return from_lights + from_world; }
        Irradiance& operator+=(const Irradiance& other) {
            from_lights += other.from_lights;
            unshadowed += other.unshadowed;
            from_world += other.from_world;
            reflected += other.reflected;
            return *this;
        }
    };
    /// Of those lights that `is_asked`, on the viewer's side of up to most_points points, for a cosine around their
    /// shading normals: irradiance[light * points.size() + point]. Takes random numbers from `first_pair` on. Faster where
    /// the points are neighbours; the results depend neither on it nor on the other lights. `lobes`: null where no point
    /// has any. Adds that of the many lights to many_by_group[group * points.size() + point], for as many groups as it has.
    /// Among catchers alone no medium and no edit of occluders counts, and of what glows only catchers.
    void at(std::span<const SurfacePoint> points, const PairIndex& first_pair, std::span<const std::uint8_t> is_asked,
            std::span<Irradiance> irradiance, const PointLobes* lobes = nullptr,
            std::span<Irradiance> many_by_group = {}, Among among = Among::All) const;

    /// Those that light surfaces: those that are asked each, the many as one, the world's light last. index_of: into
    /// Scene::lights, of the first of these.
    [[nodiscard]] std::size_t light_count() const {
        return lights_.size() + (many_ ? 1 : 0) + (has_world_light_ ? 1 : 0);
    }
    [[nodiscard]] bool is_many(std::size_t light) const { return many_ && light == lights_.size(); }
    [[nodiscard]] bool has_many() const { return many_ != nullptr; }
    /// All that glows.
    [[nodiscard]] const MeshEmitters& emitters() const { return *emitters_; }
    /// The light group of one that is not the many.
    [[nodiscard]] std::uint8_t group_of(std::size_t light) const {
        return is_world(light) ? scene_.world().light_group() : scene_.lights()[lights_[light].index].light_group;
    }
    /// Into Scene::lights: the lamps among the many.
    [[nodiscard]] std::span<const std::uint32_t> many_lamps() const { return many_->lamps(); }
    /// Of the lamps among the many, those with a size that the ray meets before its end: numbers into many_lamps().
    void meet_many_lamps(const Ray& ray, std::vector<ManyLights::LampMet>& met) const { many_->meet_lamps(ray, met); }
    /// What glows there is one of the lights: who meets it by chance must not count it again.
    [[nodiscard]] bool is_light(const Hit& hit) const { return many_ && many_->has(hit); }
    [[nodiscard]] std::uint32_t index_of(std::size_t light) const { return lights_[light].index; }
    [[nodiscard]] std::uint32_t ray_count(std::size_t light) const { return ray_counts_[light]; }
    /// False: one shadow ray of a point tells all that there is to know.
    [[nodiscard]] bool has_strata(std::size_t light) const;
    /// Shadow rays per point, to as many strata of a light; 1 before. Powers of two keep them well spread.
    void set_ray_counts(std::vector<std::uint32_t> per_light) { ray_counts_ = std::move(per_light); }
    /// A light is asked at every so many-th sample of a point's pixel, for all of them; 1 before.
    void set_turns(std::vector<std::uint32_t> per_light) { turns_ = std::move(per_light); }
    [[nodiscard]] std::uint32_t turn(std::size_t light) const { return turns_[light]; }
    [[nodiscard]] bool is_world(std::size_t light) const { return light >= lights_.size() + (many_ ? 1 : 0); }
    /// Of all lights, with one shadow ray each: what a point that few will see is worth. Adds what comes from each group to
    /// by_group, as at() does for the many.
    void add_all_once(std::span<const SurfacePoint> points, const PairIndex& first_pair,
                      std::span<Irradiance> irradiance, const PointLobes* lobes, std::span<Irradiance> by_group = {},
                      Among among = Among::All) const;
    /// The world is the last light.
    [[nodiscard]] bool has_world() const { return has_world_light_; }
    /// There is a world of one radiance.
    [[nodiscard]] bool has_even_world() const { return has_world_light_ && !scene_.world().has_image(); }
    /// What at() adds for one of the lights.
    void add_one(std::size_t light, std::span<const SurfacePoint> points, const PairIndex& first_pair,
                 std::span<Irradiance> irradiance, const PointLobes* lobes = nullptr) const;
    /// Those of up to most_points points of which one of at()'s shadow rays to the light may meet the boxes.
    [[nodiscard]] LaneSet may_meet(std::size_t light, std::span<const SurfacePoint> points, const PairIndex& first_pair,
                                   const MovedBoxes& boxes, const PointLobes* lobes = nullptr) const;
    /// How many lamps are asked each: the first of the lights.
    [[nodiscard]] std::size_t lamp_count() const { return lights_.size(); }
    [[nodiscard]] const LightAim& aim_of(std::size_t lamp) const { return lights_[lamp].aim; }
    /// Its shadow rays alone tell what reaches a point. False: edits of its occluders show on surfaces, too.
    [[nodiscard]] bool is_told_by_rays(std::size_t light) const;

private:
    struct AimedLight {
        std::uint32_t index; ///< Into Scene::lights.
        LightAim aim;
        std::unique_ptr<const light_shafts::SurfaceHoles> holes;     ///< Nothing: it meets its occluders as they are.
        std::unique_ptr<const light_shafts::Occluders> blockers;     ///< Of `shadows`, where it has only some.
        std::unique_ptr<const light_shafts::SurfaceShadows> shadows; ///< Of edits; nothing before prepare_edits.
    };
    struct ShadowRays;
    /// most_pdf_per_sr of each point's lobes, once a lamp has asked for it: negative before.
    using MostPdfs = std::array<float, most_points>;
    /// Up to most_points points that are lit together.
    struct LitSurface {
        std::span<const SurfacePoint> points;
        const LitPoints& lanes;
        const PointLobes* lobes; ///< Nothing: no point has any.
        Among among = Among::All;
        MostPdfs* most_pdfs = nullptr; ///< Of lobes; null where there are none.
    };
    /// Shadow rays of a point in one sample.
    struct RayCount {
        std::uint32_t rays = 1;
        std::uint32_t turn = 1; ///< Samples that they stand for.
    };
    [[nodiscard]] RayCount count_of(std::size_t light) const { return {ray_counts_[light], turns_[light]}; }
    void add(std::size_t light, const RayCount& count, const LitSurface& surface, const PairIndex& first_pair,
             std::span<Irradiance> irradiance, std::span<Irradiance> many_by_group = {}) const;
    void add_rays(std::size_t light, const RayCount& count, const LitSurface& surface, const PairIndex& first_pair,
                  std::span<Irradiance> irradiance, std::span<Irradiance> many_by_group) const;
    /// Of a lamp, or the world, that lights some kinds of shaders alone.
    void add_by_kinds(std::size_t light, const LitKinds& kinds, const RayCount& count, const LitSurface& surface,
                      const PairIndex& first_pair, std::span<Irradiance> irradiance) const;
    /// One stratum, which stands for `share` of the light.
    void add_light(const AimedLight& aimed, const LitSurface& surface, const PairIndex& pair, float share,
                   std::span<Irradiance> irradiance) const;
    void aim(const AimedLight& aimed, std::span<const SurfacePoint> points, const LitPoints& lanes,
             const PairIndex& pair, float share, ShadowRays& shadow) const;
    /// What the lanes leave out: a spot's cone, a texture, the lift off a smooth surface's terminator.
    void finish(const Light& light, const SurfacePoint& point, Ray& ray, Rgb& arriving) const;
    /// From the point itself, which a ray may leave from above.
    [[nodiscard]] static vec3 towards_lamp(const Light& light, const SurfacePoint& point, const Ray& ray);
    /// Off a smooth surface's terminator: a ray that ends at its far_m.
    void lift(const SurfacePoint& point, Ray& ray) const;
    void aim_at_many(const LitSurface& surface, const PairIndex& pair, float share, ShadowRays& shadow) const;
    void add_many(const LitSurface& surface, const PairIndex& pair, float share, std::span<Irradiance> irradiance,
                  std::span<Irradiance> by_group) const;
    /// For what is among the many, with the cosine by which it counts.
    struct DrawnDirection {
        vec3 direction;
        float cosine, pdf_per_sr;
    };
    /// Nothing: none that counts.
    [[nodiscard]] static std::optional<DrawnDirection> draw_by_lobes(const SurfacePoint& point, const LobeSet& lobes,
                                                                     const PairIndex& pair);
    /// Towards a lamp among the many that the lobes' direction meets.
    struct RayToLamp {
        Ray ray;
        Rgb reflected; ///< With nothing between; the share of that strategy.
        const Light* lamp;
    };
    /// From a point whose lobes are sharp: see finds_lamps.
    void aim_at_lamps_met(const SurfacePoint& point, const LobeSet& lobes, const DrawnDirection& drawn, float share,
                          Among among, std::vector<RayToLamp>& rays) const;
    /// Whether directions of lobes, too, look for lamps among the many.
    [[nodiscard]] bool finds_lamps(const LobeSet& lobes) const;
    /// Irradiance from what glows that a ray in a drawn direction meets, or what lobes send back of it; the share of that
    /// strategy. by_group: of each group that is asked for, or empty.
    [[nodiscard]] Rgb of_glow(const SurfacePoint& point, const DrawnDirection& drawn, const LobeSet* lobes, Among among,
                              std::span<Rgb> by_group) const;
    void report_glow(Statistics& statistics) const;
    /// Whether directions of a point's lobes are worth drawing beside rays that are aimed at a lamp with a size.
    [[nodiscard]] static bool may_find(const AimedLight& aimed, const LitSurface& surface, std::size_t point);
    /// What a lamp with a size adds to lobes, in their own directions.
    void aim_by_lobes(const AimedLight& aimed, const LitSurface& surface, const PairIndex& pair, float share,
                      ShadowRays& shadow) const;
    /// By its links.
    [[nodiscard]] bool may_light(const LightLinks& links, const SurfacePoint& point) const {
        return links.lights_all() || links.lights(scene_.object_info(point.hit.instance).receiver_set);
    }
    /// What stands between the points and the light.
    void let_pass(const AimedLight& aimed, const LitSurface& surface, ShadowRays& shadow) const;
    void add_world(const LitSurface& surface, const PairIndex& pair, float share,
                   std::span<Irradiance> irradiance) const;
    void aim_at_world(const LitSurface& surface, const PairIndex& pair, float share, ShadowRays& shadow) const;
    /// What counts of the world's light from a direction that leads below the surface, where shading normals see it, too:
    /// nothing, and of an image what its own share in Cycles' power heuristic is. 1 above.
    [[nodiscard]] float share_below_surface(const SurfacePoint& point, const vec3& direction, float image_pdf_per_sr,
                                            float own_pdf_per_sr) const;
    /// One ray of a point in a direction that one of several strategies draws.
    void aim_by_strategies(const SurfacePoint& point, const LobeSet& lobes, vec2 u, float share, std::size_t index,
                           ShadowRays& shadow) const;
    [[nodiscard]] static PairIndex pair_of(std::size_t light, std::uint32_t ray, const RayCount& count,
                                           const PairIndex& first_pair);
    /// Lights that stand for as many samples take turns, by their numbers.
    [[nodiscard]] static bool is_on_turn(std::size_t light, const RayCount& count, const PairIndex& first_pair) {
        return (first_pair.sample_index + light) % count.turn == 0;
    }
    void add_from_world(ShadowRays& shadow, Among among, std::span<Irradiance> irradiance) const;
    /// Towards the light, lifted off a smooth surface's terminator.
    [[nodiscard]] Ray shadow_ray(const SurfacePoint& point, const vec3& direction) const;

    const Scene& scene_;
    const Media& media_;
    std::shared_ptr<const MeshEmitters> emitters_;
    std::vector<AimedLight> lights_;                ///< Those that light surfaces.
    std::unique_ptr<const ManyLights> many_;        ///< Nothing: all are asked each.
    std::vector<std::uint32_t> ray_counts_, turns_; ///< Per light_count.
    bool has_media_, has_world_light_;
    float world_reach_m_;
};
} // namespace tyndall::render
