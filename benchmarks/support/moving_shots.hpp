// SPDX-License-Identifier: GPL-3.0-or-later
// A second of film in the scenes of the light shaft benchmarks, the camera still: wind in the air's texture, holes that
// sway, or a louvre that swings. The light of the air alone, of pixels of full HD that are dealt over the frame.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "support/scenes.hpp"
#include "support/shaft_scenes.hpp"
#include "volume/air_texture.hpp"
#include <numbers>

namespace tyndall::bench {
inline constexpr int frames_per_s = 24;

enum class Motion : std::uint8_t { Wind = 0, Holes = 1, Louvre = 2 };

/// How finely a film is computed.
struct FilmSetting {
    light_shafts::Config shafts = {};
    std::uint32_t step_count = 64;   ///< Of the air's texture.
    std::uint32_t rays_per_side = 1; ///< Of a pixel.
};

class MovingShot {
public:
    MovingShot(ShaftScene& source, Motion motion, std::size_t pixel_count) : source_(source), motion_(motion) {
        std::vector<vec3> positions = source.soup.positions;
        positions.pop_back(); // which Embree wanted
        occluders_ = support::mesh_of(
            {.name = "occluders", .positions = std::move(positions), .triangles = source.soup.triangles});
        support::SceneRandom random(23);
        for (std::size_t pixel = 0; pixel < pixel_count; ++pixel)
            pixels_.emplace_back(std::floor(random.uniform(0.0f, 1920.0f)), std::floor(random.uniform(0.0f, 1080.0f)));
        if (motion != Motion::Louvre)
            scene_ = make_scene(0);
    }

    /// Mean radiance per pixel at a frame.
    [[nodiscard]] std::vector<float> picture(int frame, const FilmSetting& setting) {
        Progress progress;
        if (motion_ == Motion::Louvre)
            scene_ = make_scene(frame);
        const Scene lit(*scene_, {sun(frame)}, {});
        const Media media(lit, progress);
        const light_shafts::Shafts shafts(lit, media, source_.view, rays_of_frame(), setting.shafts, progress);
        const std::vector<ViewRay> rays = rays_of_pixels(setting.rays_per_side);
        std::vector<Rgb> radiance(rays.size());
        shafts.scatter(rays, radiance, {}, progress);
        if (motion_ == Motion::Wind)
            texture(frame, setting, shafts, rays, radiance);
        const std::size_t rays_per_pixel = rays.size() / pixels_.size();
        std::vector<float> picture(pixels_.size());
        for (std::size_t ray = 0; ray < rays.size(); ++ray)
            picture[ray / rays_per_pixel] += average(radiance[ray]) / static_cast<float>(rays_per_pixel);
        return picture;
    }

private:
    [[nodiscard]] const Bounds3& fog() const { return source_.camera.fog; }

    /// A gate of twelve boards, 4 m high, that swings by 10 degrees to either side every two seconds, between the camera and
    /// the middle of the fog.
    [[nodiscard]] mat4 board_in_scene(int board, int frame) const {
        const float time_s = static_cast<float>(frame) / frames_per_s;
        const vec3 place = source_.camera.position + 6.0f * source_.camera.forward + vec3(0.0f, 0.0f, 2.0f);
        const mat4 gate = glm::translate(mat4(1.0f), place) *
                          glm::rotate(mat4(1.0f), 0.3f + pi / 18.0f * std::sin(pi * time_s), vec3(0.2f, 0.3f, 1.0f));
        return gate * glm::scale(support::translation({0.36f * static_cast<float>(board) - 2.0f, 0.0f, 0.0f}),
                                 vec3(0.12f, 0.03f, 2.0f));
    }
    [[nodiscard]] std::unique_ptr<Scene> make_scene(int frame) const {
        std::vector<support::Part> parts{
            {.mesh = occluders_},
            {.mesh = support::cube(),
             .world_from_object = glm::scale(support::translation(fog().centre()), 0.5f * (fog().max - fog().min)),
             .material = {.name = "fog", .medium_index = 0, .has_surface = false}}};
        for (int board = 0; motion_ == Motion::Louvre && board < 12; ++board)
            parts.push_back({.mesh = support::cube(), .world_from_object = board_in_scene(board, frame)});
        return support::make_scene(parts, {{.name = "fog", .lobes = {{Rgb(source_.sigma_t_per_m), 0.0f}}}});
    }
    [[nodiscard]] Light sun(int frame) const {
        Light light{.name = "Sun", .kind = LightKind::Sun, .towards_light = source_.sun.towards_light};
        if (motion_ == Motion::Holes) {
            OccluderEdit& edit = light.occluder_edits.emplace_back();
            edit.name = "holes";
            edit.kind = EditKind::Holes;
            edit.noise = {.scale_m = 1.0f,
                          .octaves = 3,
                          .probability = 0.3f,
                          .sway = 0.5f,
                          .turn_rad =
                              2.0f * std::numbers::pi_v<float> * static_cast<float>(frame) / (10.0f * frames_per_s)};
        }
        return light;
    }
    [[nodiscard]] ViewRay ray_through(float x_px, float y_px) const {
        const vec3 direction = source_.camera.direction_at(x_px, y_px);
        return {source_.view.position, direction, 0.0f, far_in_box(fog(), source_.view.position, direction)};
    }
    /// Ends them at surfaces.
    void trace(std::vector<ViewRay>& rays) const {
        const Progress progress;
        parallel_blocks(rays.size(), 256, progress, [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> traced;
            std::vector<Hit> hits(end - begin);
            for (std::size_t ray = begin; ray < end; ++ray)
                traced.push_back(
                    {.origin = rays[ray].origin, .direction = rays[ray].direction, .far_m = rays[ray].far_m});
            scene_->closest_hits(traced, hits);
            for (std::size_t ray = begin; ray < end; ++ray)
                if (hits[ray - begin].is_hit())
                    rays[ray].far_m = hits[ray - begin].distance_m;
        });
    }
    /// Of all pixels: what the shafts are prepared for.
    [[nodiscard]] std::vector<ViewRay> rays_of_frame() const {
        if (motion_ != Motion::Louvre)
            return source_.rays;
        std::vector<ViewRay> rays;
        for (int y = 0; y < 1080; ++y)
            for (int x = 0; x < 1920; ++x)
                rays.push_back(ray_through(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f));
        trace(rays);
        return rays;
    }
    [[nodiscard]] std::vector<ViewRay> rays_of_pixels(std::uint32_t per_side) const {
        std::vector<ViewRay> rays;
        const auto side = static_cast<float>(per_side);
        for (const vec2& pixel : pixels_)
            for (std::uint32_t y = 0; y < per_side; ++y)
                for (std::uint32_t x = 0; x < per_side; ++x)
                    rays.push_back(ray_through(pixel.x + (static_cast<float>(x) + 0.5f) / side,
                                               pixel.y + (static_cast<float>(y) + 0.5f) / side));
        trace(rays);
        return rays;
    }
    /// A breeze of 1 m/s through noise whose largest features are an eighth of the fog's shortest side.
    void texture(int frame, const FilmSetting& setting, const light_shafts::Shafts& shafts,
                 std::span<const ViewRay> rays, std::span<Rgb> radiance) const {
        const Progress progress;
        const vec3 size = fog().max - fog().min;
        Heterogeneity air{.step_count = setting.step_count, .kept_noise = noise_};
        air.noise.scale_m = std::min({size.x, size.y, size.z}) / 8.0f;
        air.moved_m = dvec3(0.8, 0.6, 0.0) * (static_cast<double>(frame) / frames_per_s);
        const std::vector<float> found = shafts.find_heterogeneity(rays, AirTexture(air, progress), progress);
        for (std::size_t ray = 0; ray < rays.size(); ++ray)
            if (found[ray] != light_shafts::dark_air)
                radiance[ray] *= found[ray];
    }

    ShaftScene& source_;
    Motion motion_;
    std::shared_ptr<const TriangleMesh> occluders_;
    std::unique_ptr<Scene> scene_;
    std::vector<vec2> pixels_; ///< Lower left corners.
    std::shared_ptr<AirNoiseCache> noise_ = std::make_shared<AirNoiseCache>();
};
} // namespace tyndall::bench
