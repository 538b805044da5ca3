// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of one point: what a scene sends from there into a camera that looks straight down.
#pragma once
#include "render/frame.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <numbers>

namespace tyndall::support {
inline Material diffuse(const Rgb& albedo, const Rgb& emission = Rgb(0.0f)) {
    Material material{.name = "diffuse"};
    material.constant = {.diffuse_albedo = albedo, .transparent = Rgb(0.0f), .emission = emission};
    return material;
}
inline Material pane(const Rgb& transparent) {
    Material material{.name = "pane"};
    material.constant = {.diffuse_albedo = Rgb(0.0f), .transparent = transparent, .emission = Rgb(0.0f)};
    return material;
}
inline Light sun_from(const vec3& towards, const Rgb& irradiance) {
    Light light;
    light.name = "Sun";
    light.strength = irradiance;
    light.towards_light = glm::normalize(towards);
    return light;
}
/// A square of that half side around a place, facing +Z.
inline Part floor_at(const vec3& centre, float half_side, const Material& material) {
    return {.mesh = square(),
            .world_from_object = glm::scale(translation(centre), vec3(half_side, half_side, 1.0f)),
            .material = material};
}
/// A disc around the z axis at that height, as a polygon of 1,000 corners: of its area to 7e-6.
inline std::shared_ptr<const TriangleMesh> disc(float radius) {
    constexpr std::uint32_t corner_count = 1000;
    MeshArrays arrays;
    arrays.name = "disc";
    arrays.positions.emplace_back(0.0f);
    for (std::uint32_t corner = 0; corner < corner_count; ++corner) {
        const float angle = 2.0f * std::numbers::pi_v<float> * static_cast<float>(corner) / corner_count;
        arrays.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0f);
        arrays.triangles.emplace_back(0, 1 + corner, 1 + (corner + 1) % corner_count);
    }
    return mesh_of(std::move(arrays));
}
inline std::unique_ptr<Scene> in_world(const std::vector<Part>& parts, const Rgb& world_radiance,
                                       std::vector<Light> lights = {}, std::vector<Medium> media = {}) {
    SceneDescription description = description_of(*make_scene(parts, std::move(media), std::move(lights)));
    description.world = World("World", world_radiance);
    return std::make_unique<Scene>(std::move(description), Progress());
}
/// From that height above a place, in one pixel a micrometre wide.
inline Camera camera_on(const vec3& place, float height_m) {
    Camera camera;
    camera.kind = CameraKind::Orthographic;
    camera.world_from_camera = translation(place + vec3(0, 0, height_m));
    camera.window_left = camera.window_bottom = -5e-7f;
    camera.window_right = camera.window_top = 5e-7f;
    camera.clip_near_m = 1e-4f;
    camera.width_px = camera.height_px = 1;
    return camera;
}
inline render::Film film_of(const Scene& scene, const Camera& camera, const render::FrameConfig& config) {
    Progress progress;
    return render::render(scene, camera, config, progress);
}
inline Rgb pixel(const render::Film& film, render::Pass pass = render::Pass::Combined) {
    const std::vector<float>& values = film.find(pass)->values;
    return {values[0], values[1], values[2]};
}
inline double relative_error(const Rgb& value, const Rgb& truth) {
    return glm::length(glm::dvec3(value) - glm::dvec3(truth)) / glm::length(glm::dvec3(truth));
}
} // namespace tyndall::support
