// SPDX-License-Identifier: GPL-3.0-or-later
// The light map fit at the size of Kol 2018, section 5.5: 41,240 stroke pixels of three views, a map of 512^2, 32 steps.
// He marches 768 steps per ray; here a row is exact between the lines of texels that its ray crosses.
//   see_and_build   from the rays to the matrix and the first gradient, with the visibility of three views
//   steps           32 steps of the solver
//   products        T x and T' y, once each
// Args: 0 the atrium (where its file is present), 1 the forest, 2 the atrium under a spot. Worst case: whole pictures
//       are painted, in colours that no light map can throw, and thinned to that many pixels, so that strokes see
//       nearly all texels.
#include "light_shafts/light_map_fit.hpp"
#include "light_shafts/map_cache.hpp"
#include "support/machine.hpp"
#include "support/scenes.hpp"
#include "support/shaft_scenes.hpp"
#include <array>

namespace tyndall::bench {
using namespace light_shafts;
namespace {
constexpr std::size_t stroke_pixel_count = 41'240;
constexpr std::uint32_t resolution = 512, step_count = 32;

struct FitScene {
    std::unique_ptr<Scene> scene;
    std::unique_ptr<Media> media;
    std::vector<Strokes> strokes;
    /// Gathered with the scene, as a session does for all its pictures; no rows are kept.
    std::shared_ptr<MapCache> occluders = std::make_shared<MapCache>(0);
    std::unique_ptr<LightMapFit> fit;
};
struct FitView {
    vec3 position, forward;
    float tan_half_width;
};

LightMapFitConfig fit_config() { return {.resolution = resolution, .shafts = {.resolution = 1024}}; }

std::unique_ptr<LightMapFit> see_and_build(const FitScene& scene, LightMapFitConfig config = fit_config()) {
    Progress progress;
    config.shafts.kept_maps = scene.occluders;
    return std::make_unique<LightMapFit>(*scene.scene, *scene.media, scene.strokes, LightMap{}, config, progress);
}

/// A picture of full HD, thinned by a golden-ratio sequence: neighbours in it lie far apart.
Strokes painted(const Scene& scene, const FitView& view, std::size_t count) {
    Strokes strokes{.view = {.position = view.position}, .pixels = {}};
    const vec3 right = glm::normalize(glm::cross(view.forward, vec3(0, 0, 1)));
    const vec3 up = glm::cross(right, view.forward);
    for (std::size_t i = 0; i < count; ++i) {
        const dvec2 place =
            glm::fract(dvec2(0.5) + static_cast<double>(i) * dvec2(0.7548776662466927, 0.5698402909980532));
        const float u = static_cast<float>(place.x) * 2 - 1, v = (static_cast<float>(place.y) * 2 - 1) * 1080 / 1920;
        const vec3 direction = glm::normalize(view.forward + view.tan_half_width * (u * right + v * up));
        const Hit hit = scene.closest_hit({.origin = view.position, .direction = direction});
        const Rgb desired(u > 0 ? 1.5f : 0.0f, 0.4f + 0.4f * v, u < 0.3f ? 1.2f : 0.1f);
        strokes.pixels.push_back(
            {{view.position, direction, 0.0f, hit.is_hit() ? hit.distance_m : 1e4f}, desired, 1.0f});
    }
    // As a picture has them, row by row.
    std::ranges::sort(strokes.pixels, {}, [&](const StrokePixel& pixel) {
        const vec3 d = pixel.ray.direction / glm::dot(pixel.ray.direction, view.forward);
        return std::floor(glm::dot(d, up) * 500.0f) * 1e3f + glm::dot(d, right);
    });
    return strokes;
}

FitScene make(support::TriangleSoup soup, const Bounds3& fog, float sigma_t_per_m, const Light& light,
              const std::array<FitView, 3>& views) {
    FitScene made;
    const Medium medium{.name = "fog", .lobes = {{Rgb(sigma_t_per_m), 0.0f}}, .sigma_a_per_m = Rgb(0.0f)};
    made.scene = support::make_scene(
        {{.mesh = support::mesh_of(
              {.name = "occluders", .positions = std::move(soup.positions), .triangles = std::move(soup.triangles)})},
         {.mesh = support::cube(),
          .world_from_object = glm::scale(support::translation(fog.centre()), 0.5f * (fog.max - fog.min)),
          .material = {.name = "fog", .medium_index = 0, .has_surface = false}}},
        {medium}, {light});
    const Progress progress;
    made.media = std::make_unique<Media>(*made.scene, progress);
    for (std::size_t view = 0; view < views.size(); ++view)
        made.strokes.push_back(
            painted(*made.scene, views[view], stroke_pixel_count * (view + 1) / 3 - stroke_pixel_count * view / 3));
    made.fit = see_and_build(made);
    return made;
}

Light sun(const vec3& towards_light) { return {.name = "Sun", .kind = LightKind::Sun, .towards_light = towards_light}; }

FitScene* fit_scene(benchmark::State& state) {
    static const bool has_machine = (add_machine_to_context(), true);
    if (state.range(0) == 1 && has_machine) {
        const vec3 at = support::forest_camera_position;
        static FitScene forest =
            make(support::make_forest(), support::forest_fog_box, 0.02f, sun(support::forest_towards_sun()),
                 {FitView{at, {0, 1, 0}, 0.6f},
                  {at + vec3(30, 10, 0), glm::normalize(vec3(-0.6f, 1, 0.05f)), 0.6f},
                  {at + vec3(-40, 30, 1), glm::normalize(vec3(1, 0.5f, 0.05f)), 0.6f}});
        return &forest;
    }
    static std::array<std::optional<FitScene>, 3> of_argument;
    std::optional<FitScene>& atrium = of_argument[static_cast<std::size_t>(state.range(0))];
    if (!atrium) {
        std::optional<support::TriangleSoup> soup = load_sponza();
        if (!soup) {
            state.SkipWithError("Sponza-LowPoly is not there: set TYNDALL_SHARED_DATA");
            return nullptr;
        }
        const Light spot{.name = "Spot",
                         .kind = LightKind::Spot,
                         .position = {6, -1, 11},
                         .spot_axis = glm::normalize(vec3(-0.6f, 0.1f, -1.0f)),
                         .spot_half_angle_rad = 0.8f,
                         .spot_blend = 0.2f};
        atrium = make(std::move(*soup), {.min = vec3(-15.5f, -9.5f, -1.1f), .max = vec3(14.5f, 9.5f, 11.5f)}, 0.05f,
                      state.range(0) == 2 ? spot : sun(glm::normalize(vec3(-0.5f, 0.2f, 0.8f))),
                      {FitView{{8, 0, 2}, glm::normalize(vec3(-1.0f, 0.1f, 0.1f)), 0.8f},
                       {{-8, 1, 3}, glm::normalize(vec3(1.0f, 0.05f, 0.1f)), 0.8f},
                       {{0, 2, 4}, glm::normalize(vec3(-0.3f, -1.0f, 0.0f)), 0.8f}});
    }
    return &*atrium;
}
void report(benchmark::State& state, const LightMapFit& fit) {
    state.counters["weights"] = static_cast<double>(fit.matrix().weight_count());
    state.counters["samples"] = static_cast<double>(fit.matrix().sample_count());
    state.counters["matrix_mb"] = static_cast<double>(fit.matrix().byte_count()) * 1e-6;
    for (const Statistics::Count& count : fit.statistics().counts)
        if (count.name == "light map fit: seen texels")
            state.counters["seen_texels"] = count.value;
}
/// What of the fitted map's radiance is wrong because rays share lines of the map.
double error_of_sharing(const FitScene& scene, const LightMapFit& fit) {
    LightMapFitConfig config = fit_config();
    config.shared_texels = 0.0f;
    const std::unique_ptr<LightMapFit> alone = see_and_build(scene, config);
    const LightMap map = fit.map();
    MapTexels texels(fit.matrix().texel_count(), vec4(0.0f));
    for (std::size_t texel = 0; texel < map.texels.size(); ++texel)
        texels[texel / resolution * fit.matrix().pitch() + texel % resolution] = vec4(map.texels[texel], 0.0f);
    LightMapMatrix::Scratch scratch;
    std::vector<vec4> shared(fit.matrix().ray_count()), exact(shared.size());
    fit.matrix().multiply(texels, shared, scratch, Progress());
    alone->matrix().multiply(texels, exact, scratch, Progress());
    double difference = 0.0, size = 0.0;
    for (std::size_t ray = 0; ray < exact.size(); ++ray) {
        difference += glm::dot(glm::dvec4(shared[ray] - exact[ray]), glm::dvec4(shared[ray] - exact[ray]));
        size += glm::dot(glm::dvec4(exact[ray]), glm::dvec4(exact[ray]));
    }
    return std::sqrt(difference / size);
}
} // namespace

static void see_and_build(benchmark::State& state) {
    const FitScene* const scene = fit_scene(state);
    if (scene == nullptr)
        return;
    std::unique_ptr<LightMapFit> fit;
    for (auto _ : state)
        fit = see_and_build(*scene);
    report(state, *fit);
    for (const Statistics::Stage& stage : fit->statistics().stages) // of the last one
        state.counters[stage.name.substr(stage.name.find(": ") + 2) + "_ms"].value += 1e3 * stage.seconds;
}

static void steps(benchmark::State& state) {
    const FitScene* const scene = fit_scene(state);
    if (scene == nullptr)
        return;
    Progress progress;
    std::unique_ptr<LightMapFit> fit;
    for (auto _ : state) {
        state.PauseTiming();
        fit = see_and_build(*scene);
        state.ResumeTiming();
        fit->iterate(step_count, progress);
    }
    report(state, *fit);
    state.counters["residual_before"] = fit->history().front().residual;
    state.counters["residual_after"] = fit->history().back().residual;
    state.counters["error_of_sharing"] = error_of_sharing(*scene, *fit);
}

static void products(benchmark::State& state) {
    const FitScene* const scene = fit_scene(state);
    if (scene == nullptr)
        return;
    const Progress progress;
    const LightMapMatrix& matrix = scene->fit->matrix();
    const MapTexels texels(matrix.texel_count(), vec4(0.5f));
    MapTexels back(texels.size());
    LightMapMatrix::Scratch scratch;
    std::vector<vec4> radiance(matrix.ray_count());
    for (auto _ : state) {
        matrix.multiply(texels, radiance, scratch, progress);
        matrix.multiply_transposed(radiance, back, progress);
    }
    report(state, *scene->fit);
}

BENCHMARK(see_and_build)->DenseRange(0, 2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(steps)->DenseRange(0, 2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(products)->DenseRange(0, 2)->UseRealTime()->Unit(benchmark::kMillisecond);
} // namespace tyndall::bench
