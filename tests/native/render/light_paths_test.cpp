// SPDX-License-Identifier: GPL-3.0-or-later
// Light by what sends it to the camera: all of it together is the picture, whoever renders it.
#include "render/light_paths.hpp"
#include "shading/lobes/lobe_models.hpp"
#include "support/whole_and_part.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace light_paths_test {
using namespace tyndall;
using namespace tyndall::support;
using render::Film;
using render::FrameConfig;
using render::Pass;

namespace {
LobeSource source(LobeModel model, std::vector<Rgb> constants) {
    const std::size_t count = constants.size();
    return {.model = model,
            .constants = std::move(constants),
            .registers = std::vector<std::uint16_t>(count, LobeSource::no_register)};
}
/// Dull, and under that rough gloss.
Material glazed() {
    return {.name = "glazed",
            .constant = {.diffuse_albedo = Rgb(0.3f, 0.2f, 0.1f)},
            .lobe_sources = {source(LobeModel::Glossy, {Rgb(1.0f), Rgb(0.2f, 0.3f, 0.4f), Rgb(0.5f)})}};
}
Material mirror() {
    Material material = diffuse(Rgb(0.0f));
    material.gloss = GlossLayers{.constant = {.facing = Rgb(0.9f, 0.8f, 0.7f), .edge = Rgb(1.0f)}};
    return material;
}
FrameConfig with_all() {
    FrameConfig config;
    config.pixel_samples = 4;
    config.indirect.mirror_depth = 2;
    config.indirect.has_bounce = true;
    for (const Pass pass :
         {Pass::Emission, Pass::DiffuseDirect, Pass::DiffuseIndirect, Pass::GlossyDirect, Pass::GlossyIndirect,
          Pass::TransmissionDirect, Pass::TransmissionIndirect, Pass::Environment, Pass::GlossyColour})
        config.passes.add(pass);
    return config;
}
Rgb of_pixel(const Film& film, Pass pass, std::size_t pixel) {
    const float* values = &film.find(pass)->values[pixel * layout(pass).channel_count];
    return {values[0], values[1], values[2]};
}
Rgb mean_of(const Film& film, Pass pass) {
    const std::size_t count = std::size_t{film.width_px} * film.height_px;
    Rgb sum(0.0f);
    for (std::size_t pixel = 0; pixel < count; ++pixel)
        sum += of_pixel(film, pass, pixel);
    return sum / static_cast<float>(count);
}
} // namespace

// Seen to fail without what lobes send.
TEST_CASE("light by what sends it, what glows and the world make the picture, by any number of threads and in parts") {
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.strength = Rgb(9.0f, 5.0f, 3.0f);
    lamp.position = {0.5f, -0.4f, 4.0f};
    lamp.radius_m = 0.2f;
    const auto placed = [](const vec3& at, float angle) {
        return glm::scale(glm::rotate(translation(at), angle, vec3(1, 2, 3)), vec3(0.4f));
    };
    const auto scene =
        in_world({floor_at(vec3(0.0f), 1.2f, glazed()),
                  {.mesh = cube(), .world_from_object = placed({-0.5f, 0.3f, 0.9f}, 0.7f), .material = mirror()},
                  {.mesh = cube(),
                   .world_from_object = placed({0.7f, -0.4f, 0.6f}, 0.2f),
                   .material = diffuse(Rgb(0.1f, 0.5f, 0.9f), Rgb(0.05f))}},
                 Rgb(0.1f, 0.2f, 0.3f), {lamp});
    Camera camera;
    camera.world_from_camera = translation({0, 0, 5});
    camera.window_left = camera.window_bottom = -0.3f;
    camera.window_right = camera.window_top = 0.3f;
    camera.width_px = camera.height_px = 24;
    const Film film = check_whole_and_part(*scene, camera, with_all());
    for (std::size_t pixel = 0; pixel < 24 * 24; ++pixel) {
        Rgb sum(0.0f);
        for (const Pass pass : {Pass::Emission, Pass::Environment, Pass::DiffuseDirect, Pass::DiffuseIndirect,
                                Pass::GlossyDirect, Pass::GlossyIndirect})
            sum += of_pixel(film, pass, pixel);
        CHECK(relative_error(sum, of_pixel(film, Pass::Combined, pixel)) < 1e-5);
    }
    for (const Pass pass : {Pass::Emission, Pass::Environment, Pass::DiffuseDirect, Pass::DiffuseIndirect,
                            Pass::GlossyDirect, Pass::GlossyIndirect, Pass::GlossyColour}) {
        CAPTURE(layout(pass).name);
        CHECK(mean_of(film, pass).y > 1e-4f);
    }
    CHECK(mean_of(film, Pass::TransmissionDirect) == Rgb(0.0f));
}

// Seen to fail with lobes that are told as what Lambert's share sends.
TEST_CASE("of a sun, Lambert's share sends its albedo, and no gloss") {
    Light lamp;
    lamp.kind = LightKind::Sun;
    lamp.strength = Rgb(3.0f);
    const auto scene = in_world({floor_at(vec3(0.0f), 1.0f, glazed())}, Rgb(0.0f), {lamp});
    FrameConfig config = with_all();
    config.pixel_samples = 1;
    const Film film = film_of(*scene, camera_on(vec3(0.0f), 1.0f), config);
    const Rgb expected = Rgb(0.3f, 0.2f, 0.1f) * 3.0f * std::numbers::inv_pi_v<float>;
    CHECK(relative_error(of_pixel(film, Pass::DiffuseDirect, 0), expected) < 1e-5);
    CHECK(relative_error(of_pixel(film, Pass::DiffuseDirect, 0) + of_pixel(film, Pass::GlossyDirect, 0),
                         of_pixel(film, Pass::Combined, 0)) < 1e-5);
}
} // namespace light_paths_test
