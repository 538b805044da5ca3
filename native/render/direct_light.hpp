// SPDX-License-Identifier: GPL-3.0-or-later
// Light that reaches a diffuse surface straight from the scene's lights and world, through what lies between.
// Based on: next event estimation; the world's light by multiple importance sampling, Veach, dissertation, Stanford
//           1997, section 9.2 (power heuristic), between the cosine and the image.
// Differs:  every light is sampled at every point, not one picked at random: no noise from the choice.
// Bound:    one shadow ray per light that faces the point, two for an image of the world.
#pragma once
#include "render/pixel_samples.hpp"
#include "scene/media.hpp"
#include "scene/scene.hpp"

namespace tyndall::render {
/// A surface point that a view ray found.
struct SurfacePoint {
    Hit hit;
    ShadingPoint shading;
};

class DirectLight {
public:
    /// Reports to `statistics` what cannot light anything. Both references must outlive this.
    DirectLight(const Scene& scene, const Media& media, Statistics& statistics);

    struct Irradiance {
        Rgb from_lights{0.0f}; ///< With occluders and media between, W/m^2.
        Rgb unshadowed{0.0f};  ///< The same lights with nothing between.
        Rgb from_world{0.0f};  ///< With occluders and media between.
        [[nodiscard]] Rgb sum() const { return from_lights + from_world; }
    };
    /// On the viewer's side of the point, for a cosine around its shading normal. Takes its random numbers from samples.
    [[nodiscard]] Irradiance at(const SurfacePoint& point, PixelSamples& samples) const;

private:
    [[nodiscard]] Rgb passing_light(const Ray& ray, bool casts_shadow) const;
    [[nodiscard]] Rgb world_irradiance(const SurfacePoint& point, PixelSamples& samples) const;
    /// Towards the light, lifted off a smooth surface's terminator.
    [[nodiscard]] Ray shadow_ray(const SurfacePoint& point, const vec3& direction) const;

    const Scene& scene_;
    const Media& media_;
    std::vector<std::uint32_t> lights_; ///< Into Scene::lights: those that light surfaces.
    bool has_media_, has_world_light_;
};
} // namespace tyndall::render
