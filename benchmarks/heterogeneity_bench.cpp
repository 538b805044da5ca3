// SPDX-License-Identifier: GPL-3.0-or-later
// The texture of the air at full HD, under a sun whose slope rows are there already, in scenes S (0, Sponza-LowPoly) and F
// (1, the forest); noise of five octaves, largest features an eighth of the fog's shorter side.
//   make_noise       256^3 texels with their levels (argument: resolution)
//   march            every lit ray asks (scene, steps); march_whole: the paper's mean over whole rays, lit or not
//   march_painted    inside a box that is painted everywhere, 64^3 voxels of each of three volumes
//   upsample         one ray per square of pixels (scene, side), 64 steps, the others by their depth
// Counters: error_percent, relative RMSE of the textured light over 3,000 random rays against 2,048 steps of these rays'
// own; bias_percent; asked_percent, rays that were asked.
#include "light_shafts/light_shafts.hpp"
#include "render/frame_air.hpp"
#include "support/machine.hpp"
#include "support/scenes.hpp"
#include "support/shaft_scenes.hpp"
#include <benchmark/benchmark.h>
#include <map>
#include <random>

namespace tyndall::bench {
namespace {
constexpr std::uint32_t width = 1920, height = 1080;

struct AirScene {
    ShaftScene& source;
    Bounds3 fog;
    std::unique_ptr<Scene> scene;
    std::unique_ptr<Media> media;
    std::unique_ptr<light_shafts::Shafts> shafts;
    render::WaitingParts waiting; ///< A part per pixel.
    std::vector<Rgb> radiance;
    std::vector<std::uint32_t> truth_rays;
    std::vector<float> truth; ///< Heterogeneity of those.
    std::shared_ptr<AirNoiseCache> noise = std::make_shared<AirNoiseCache>();

    AirScene(ShaftScene& shaft_scene, const Bounds3& box) : source(shaft_scene), fog(box) {
        Light sun{.name = "Sun", .kind = LightKind::Sun, .towards_light = source.sun.towards_light};
        std::vector<vec3> positions = source.soup.positions;
        positions.pop_back(); // which Embree wanted
        scene = support::make_scene(
            {{.mesh = support::mesh_of(
                  {.name = "occluders", .positions = std::move(positions), .triangles = source.soup.triangles})},
             {.mesh = support::cube(),
              .world_from_object = glm::scale(support::translation(fog.centre()), 0.5f * (fog.max - fog.min)),
              .material = {.name = "fog", .medium_index = 0, .has_surface = false}}},
            {{.name = "fog", .lobes = {{Rgb(source.sigma_t_per_m), 0.0f}}}}, {sun});
        Progress progress;
        media = std::make_unique<Media>(*scene, progress);
        waiting.rays = source.rays;
        waiting.weights.assign(waiting.rays.size(), Rgb(1.0f));
        for (std::uint32_t pixel = 0; pixel < width * height; ++pixel)
            waiting.first.push_back(pixel + 1);
        shafts = std::make_unique<light_shafts::Shafts>(*scene, *media, source.view, waiting.rays,
                                                        light_shafts::Config{}, progress);
        radiance.resize(waiting.rays.size());
        shafts->scatter(waiting.rays, radiance, {}, progress);
        std::mt19937 random(5);
        for (int ray = 0; ray < 3000; ++ray)
            truth_rays.push_back(static_cast<std::uint32_t>(random() % (width * height)));
        truth = shafts->find_heterogeneity(rays_of_truth(), AirTexture(air(2048), progress), progress);
    }
    [[nodiscard]] Heterogeneity air(std::uint32_t step_count) const {
        const vec3 size = fog.max - fog.min;
        Heterogeneity heterogeneity{.step_count = step_count};
        heterogeneity.noise.scale_m = std::min({size.x, size.y, size.z}) / 8.0f;
        heterogeneity.kept_noise = noise;
        return heterogeneity;
    }
    [[nodiscard]] std::vector<ViewRay> rays_of_truth() const {
        std::vector<ViewRay> rays;
        for (const std::uint32_t ray : truth_rays)
            rays.push_back(waiting.rays[ray]);
        return rays;
    }
    [[nodiscard]] render::Region region() const { return {0, 0, width, height}; }
    [[nodiscard]] Camera camera() const {
        Camera camera;
        camera.width_px = width;
        camera.height_px = height;
        const auto corner = [&](std::uint32_t x, std::uint32_t y) {
            return source.rays[std::size_t{y} * width + x].direction;
        };
        const vec3 right = glm::normalize(corner(width - 1, 0) - corner(0, 0)),
                   up = glm::normalize(corner(0, height - 1) - corner(0, 0)), back = glm::cross(right, up);
        camera.world_from_camera =
            mat4(vec4(right, 0), vec4(up, 0), vec4(back, 0), vec4(source.rays.front().origin, 1));
        const vec3 last = corner(width - 1, height - 1);
        const float half_px =
            glm::dot(last, right) / -glm::dot(last, back) / (width - 1); // the corner is half a pixel in
        camera.window_right = half_px * width;
        camera.window_top = half_px * height;
        camera.window_left = -camera.window_right;
        camera.window_bottom = -camera.window_top;
        return camera;
    }
    /// Of what each pixel is multiplied by.
    void report(benchmark::State& state, std::span<const float> heterogeneity) const {
        double error2 = 0.0, away = 0.0, sum = 0.0;
        for (std::size_t i = 0; i < truth_rays.size(); ++i) {
            const double light = double{average(radiance[truth_rays[i]])};
            if (light == 0.0 || truth[i] == light_shafts::dark_air)
                continue;
            const double difference = light * (double{heterogeneity[truth_rays[i]]} - double{truth[i]});
            error2 += difference * difference;
            away += difference;
            sum += light * double{truth[i]};
        }
        const auto count = static_cast<double>(truth_rays.size());
        state.counters["error_percent"] = 100.0 * std::sqrt(error2 / count) / (sum / count);
        state.counters["bias_percent"] = 100.0 * away / sum;
    }
};

AirScene* air_scene(benchmark::State& state) {
    static const bool has_machine = (add_machine_to_context(), true);
    if (state.range(0) == 1 && has_machine) {
        static AirScene forest(forest_scene(), support::forest_fog_box);
        return &forest;
    }
    static const std::unique_ptr<AirScene> atrium =
        sponza_scene() ? std::make_unique<AirScene>(*sponza_scene(), Bounds3{.min = vec3(-15.5f, -9.5f, -1.1f),
                                                                             .max = vec3(14.5f, 9.5f, 11.5f)})
                       : nullptr;
    if (!atrium)
        state.SkipWithError("Sponza-LowPoly is not there: set TYNDALL_SHARED_DATA");
    return atrium.get();
}

/// As FrameAir is asked in a frame of one sample.
void ask_frame(benchmark::State& state, const AirScene& scene, const Heterogeneity& heterogeneity) {
    const Progress progress;
    const Camera camera = scene.camera();
    Statistics statistics;
    const render::DirectLight light(*scene.scene, *scene.media, statistics);
    const render::ViewPath path(*scene.scene, *scene.media, light, camera, {});
    const render::FilterSampler filter(render::PixelFilter::Box, 1.0f);
    std::vector<float> found(scene.waiting.rays.size());
    render::FrameAir air(heterogeneity, camera, scene.region(), false, progress);
    std::size_t passes = 0;
    for (auto _ : state) {
        air.begin_pass(path, filter, {}, 0, scene.waiting, progress);
        air.ask_squares(*scene.shafts, {}, progress);
        air.find(*scene.shafts, {}, scene.waiting, 0, width * height, scene.radiance, found, progress);
        ++passes;
    }
    Statistics asked;
    air.report(asked);
    state.counters["asked_percent"] = 100.0 * asked.counts.front().value / static_cast<double>(passes * found.size());
    scene.report(state, found);
}
} // namespace

static void make_noise(benchmark::State& state) {
    const Progress progress;
    for (auto _ : state)
        benchmark::DoNotOptimize(AirNoiseVolume({.resolution = static_cast<std::uint32_t>(state.range(0))}, progress));
}

static void march(benchmark::State& state) {
    if (const AirScene* scene = air_scene(state))
        ask_frame(state, *scene, scene->air(static_cast<std::uint32_t>(state.range(1))));
}

static void march_whole(benchmark::State& state) {
    const AirScene* scene = air_scene(state);
    if (!scene)
        return;
    Heterogeneity heterogeneity = scene->air(64);
    heterogeneity.weighting = Heterogeneity::Weighting::WholeRay;
    ask_frame(state, *scene, heterogeneity);
    state.counters.erase("error_percent");
    state.counters.erase("bias_percent");
}

static void march_painted(benchmark::State& state) {
    const AirScene* scene = air_scene(state);
    if (!scene)
        return;
    const auto even = [](float value) {
        return PaintedVolume{.size = {64, 64, 64}, .values = std::vector<float>(64 * 64 * 64, value)};
    };
    Heterogeneity heterogeneity = scene->air(64);
    heterogeneity.unit_from_scene = glm::inverse(glm::translate(mat4(1.0f), scene->fog.min) *
                                                 glm::scale(mat4(1.0f), scene->fog.max - scene->fog.min));
    heterogeneity.amount = 0.5f;
    heterogeneity.painted = std::make_shared<const PaintedAir>(even(0.5f), even(1e-6f), even(1.0001f));
    ask_frame(state, *scene, heterogeneity);
}

static void upsample(benchmark::State& state) {
    const AirScene* scene = air_scene(state);
    if (!scene)
        return;
    Heterogeneity heterogeneity = scene->air(64);
    heterogeneity.upsampling = static_cast<std::uint32_t>(state.range(1));
    ask_frame(state, *scene, heterogeneity);
}

#define TYNDALL_AIR_BENCHMARK(name)                                                                                    \
    BENCHMARK(name)->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond)
TYNDALL_AIR_BENCHMARK(make_noise)->ArgName("resolution")->Arg(128)->Arg(256);
TYNDALL_AIR_BENCHMARK(march)
    ->ArgNames({"scene", "steps"})
    ->ArgsProduct({{0, 1}, {4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048}});
TYNDALL_AIR_BENCHMARK(march_whole)->ArgName("scene")->Arg(0)->Arg(1);
TYNDALL_AIR_BENCHMARK(march_painted)->ArgName("scene")->Arg(0)->Arg(1);
TYNDALL_AIR_BENCHMARK(upsample)->ArgNames({"scene", "side"})->ArgsProduct({{0, 1}, {1, 2, 4, 8, 16}});
} // namespace tyndall::bench
