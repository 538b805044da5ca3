// SPDX-License-Identifier: GPL-3.0-or-later
// Lights of which each point asks a few, drawn from a tree: lamps beyond a number, and what glows.
// Based on: next event estimation; light_tree.hpp chooses, scene/light.hpp and mesh_emitters.hpp place.
#pragma once
#include "render/kept_light_trees.hpp"
#include "render/lamp_boxes.hpp"
#include "render/lamp_hits.hpp"
#include "render/mesh_emitters.hpp"
#include "render/surface_point.hpp"
#include <memory>
#include <optional>

namespace tyndall::render {
/// What a lamp with a place is to a light tree.
[[nodiscard]] LightBounds bounds_of(const Light& lamp);

class ManyLights {
public:
    /// Up to so many lamps are asked one by one: that has no noise, and takes no longer than a few draws.
    static constexpr std::size_t most_asked_each = 32;

    /// `lamps`: into Scene::lights; `emitters`: those of the scene, which must outlive this.
    ManyLights(const Scene& scene, std::vector<std::uint32_t> lamps, std::shared_ptr<const MeshEmitters> emitters,
               KeptLightTrees* kept = nullptr);
    [[nodiscard]] bool is_empty() const { return tree_->is_empty() && !has_glow_; }
    [[nodiscard]] std::span<const std::uint32_t> lamps() const { return lamps_; }
    /// Something among them that rays by chance may meet.
    [[nodiscard]] bool has_glow() const { return has_glow_; }
    /// Whether what glows there is one of these lights.
    [[nodiscard]] bool has(const Hit& hit) const {
        return emitters_->triangle_of(hit) != nullptr || emitters_->is_met_alone(hit);
    }

    struct Aimed {
        Ray ray;      ///< Up to the light.
        Rgb arriving; ///< Irradiance over the probability of the choice; of a lamp without a spot's cone.
        const Light* lamp = nullptr;  ///< Nothing: something that glows.
        std::uint32_t instance = ~0u; ///< Of that, as of a Hit.
        /// With the choice, of what rays meet by chance, too; of a lamp where it is asked for. 0: it is never aimed at.
        float pdf_per_sr = 0.0f;
        std::uint8_t light_group = no_light_group;
        const LightLinks* links = nullptr; ///< Of what glows, where they leave something out; lamps here light all.
        LitKinds kinds = {};               ///< The same.
    };
    /// By numbers in [0, 1). Nothing: no light comes from there. `tells_density`: of lamps, too.
    [[nodiscard]] std::optional<Aimed> aim(const SurfacePoint& point, float u_choice, vec2 u_place,
                                           bool tells_density = false) const;
    /// See MeshEmitters::may_meet.
    [[nodiscard]] bool may_meet_glow(const Ray& ray) const { return emitters_->may_meet(ray); }
    /// Some lamp has a size, for rays to meet.
    [[nodiscard]] bool has_wide_lamps() const { return !boxes_.is_empty(); }
    struct LampMet {
        std::uint32_t number; ///< Into lamps().
        LampHit hit;
    };
    /// Lamps with a size that the ray meets before its end, whatever stands before them.
    void meet_lamps(const Ray& ray, std::vector<LampMet>& met) const;
    /// With which aim() takes the direction from the point in which a lamp was met.
    [[nodiscard]] float pdf_per_sr(const SurfacePoint& point, const LampMet& met) const {
        return met.hit.pdf_per_sr *
               tree_->probability(met.number, point.shading.position, point.shading.shading_normal);
    }
    /// A ray from the point that met what glows: what it brings, and with which density aim() takes it; else nothing.
    [[nodiscard]] std::optional<Aimed> met(const SurfacePoint& point, const Ray& ray, const Hit& hit) const;

private:
    [[nodiscard]] std::optional<Aimed> aim_at_lamp(const SurfacePoint& point, std::uint32_t number, vec2 u,
                                                   bool tells_density) const;
    [[nodiscard]] std::optional<Aimed> aim_at_triangle(const SurfacePoint& point, const EmissiveTriangle& triangle,
                                                       vec2 u) const;
    [[nodiscard]] const LightLinks* links_of(std::uint32_t instance) const {
        const LightLinks& links = scene_.object_info(instance).links;
        return links == LightLinks{} ? nullptr : &links;
    }
    /// From where rays leave the point to just before a hit.
    [[nodiscard]] Ray ray_to(const SurfacePoint& point, const Hit& hit, const vec3& direction) const;

    const Scene& scene_;
    std::vector<std::uint32_t> lamps_;
    std::shared_ptr<const MeshEmitters> emitters_; ///< Those among them that light surfaces are in the tree.
    std::shared_ptr<const LightTree> tree_;        ///< Lamps first.
    struct WideLamp {
        std::uint32_t number; ///< Into lamps_.
        LightAim aim;
    };
    std::vector<WideLamp> wide_lamps_;        ///< Those with a size.
    std::vector<std::uint32_t> wide_of_lamp_; ///< Into these; LightTree::none: it has no size.
    LampBoxes boxes_;                         ///< Of wide_lamps_.
    bool has_glow_ = false;                   ///< Some of it lights surfaces.
};
} // namespace tyndall::render
