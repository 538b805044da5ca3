// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of one placed DAG under a sun, and a weaker one from the camera without shadows, to compare what is lost of colours
// and normals: no light is sampled, so that there is no noise.
#pragma once
#include "image/srgb.hpp"
#include "image/structural_similarity.hpp"
#include "render/frame.hpp"
#include "voxel_dag/voxel_shape.hpp"
#include <cstdlib>
#include <fstream>
#include <string>

namespace tyndall::bench {
/// In the DAG's cube of 1 m.
struct View {
    vec3 eye, target, up, towards_sun;
    float half_width; ///< Of the picture, 1 m before the camera; it is 4 : 3.
};
struct Picture {
    render::Film film;
    GreyPicture luma;
};

/// 640 x 480 pixels, 4 samples each. With TYNDALL_PICTURES, a folder, also there, as name.ppm.
inline Picture picture_of(const voxel_dag::PlacedDag& placed, const View& view, const std::string& name) {
    SceneDescription description;
    description.object_names = {name};
    description.materials = {Material{
        .name = "white",
        .constant = {.diffuse_albedo = Rgb(1.0f), .transparent = Rgb(0.0f), .emission = Rgb(0.0f)},
    }};
    description.shapes = {std::make_shared<const CellGeometry>(
        voxel_dag::make_voxel_shape(std::make_shared<const voxel_dag::PlacedDag>(placed), name))};
    description.placed_shapes = {PlacedShape{}};
    Light sun;
    sun.name = "Sun";
    sun.towards_light = glm::normalize(view.towards_sun);
    sun.strength = Rgb(2.0f);
    Light fill = sun;
    fill.towards_light = glm::normalize(view.eye - view.target);
    fill.strength = Rgb(0.8f), fill.casts_shadow = false;
    description.lights = {sun, fill};
    Camera camera;
    camera.world_from_camera = glm::inverse(glm::lookAt(view.eye, view.target, view.up));
    camera.width_px = 640, camera.height_px = 480;
    camera.window_left = -view.half_width, camera.window_right = view.half_width;
    camera.window_bottom = -0.75f * view.half_width, camera.window_top = 0.75f * view.half_width;
    camera.clip_near_m = 1e-3f;
    render::FrameConfig config;
    config.pixel_samples = 4;
    Progress progress;
    Picture picture{.film = render::render(Scene(std::move(description), progress), camera, config, progress),
                    .luma = {}};
    const std::vector<float>& values = picture.film.find(render::Pass::Combined)->values;
    picture.luma = luma_of(values, 4, camera.width_px);
    if (const char* const folder = std::getenv("TYNDALL_PICTURES")) {
        std::ofstream file(std::string(folder) + "/" + name + ".ppm", std::ios::binary);
        file << "P6\n" << camera.width_px << ' ' << camera.height_px << "\n255\n";
        for (std::size_t row = camera.height_px; row-- > 0;)
            for (std::size_t pixel = row * camera.width_px; pixel < (row + 1) * camera.width_px; ++pixel)
                for (std::size_t channel = 0; channel < 3; ++channel)
                    file.put(static_cast<char>(
                        std::lround(255.0f * srgb_from_linear(std::clamp(values[4 * pixel + channel], 0.0f, 1.0f)))));
    }
    return picture;
}
} // namespace tyndall::bench
