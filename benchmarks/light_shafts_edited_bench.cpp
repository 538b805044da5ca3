// SPDX-License-Identifier: GPL-3.0-or-later
// Frames of 480 x 270 rays through fog, of a light with one edit: what its depth map costs, and what error it has.
//   edited   prepare and scatter. Arguments: the occluders (0: a lattice of bars 4 cm wide, 10 cm apart; 1: the forest of
//            1M leaves), the light (0: sun, 1: point, 2: spot), the edit (0: a disc closes holes of 0.5 m, 1: silhouettes
//            grow by 0.5 m, 2: holes, 3 octaves from 0.5 m), and the resolution (0: the error target's, 0.2 %)
// Counters: error_percent, relative RMSE of the radiance against 8,192 texels per side, the most that there are; lines of
// the slope rows, as many as texels.
#include "light_shafts/light_shafts.hpp"
#include "support/forest.hpp"
#include "support/lattice.hpp"
#include "support/machine.hpp"
#include "support/scenes.hpp"
#include <benchmark/benchmark.h>
#include <cmath>
#include <map>

namespace tyndall::bench {
using namespace light_shafts;
namespace {
enum Occluder : std::int64_t { Lattice = 0, Forest = 1 };
enum Edit : std::int64_t { Disc = 0, Silhouette = 1, Holes = 2 };

Light light_of(std::int64_t occluder, std::int64_t kind, std::int64_t edit) {
    Light light{.name = "light", .kind = static_cast<LightKind>(kind)};
    const bool is_forest = occluder == Forest;
    light.towards_light = is_forest ? support::forest_towards_sun() : glm::normalize(vec3(0.2f, 0.3f, 1.0f));
    light.position = is_forest ? vec3(4.0f, -30.0f, 22.0f) : vec3(0.1f, 0.2f, 4.0f);
    light.strength = Rgb(kind == 0 ? 1.0f : 100.0f);
    light.spot_half_angle_rad = 0.6f;
    OccluderEdit change{.name = "edit", .size_m = 0.5f, .distance_m = is_forest ? 12.0f : 4.0f};
    change.kind = edit == Disc ? EditKind::Close : edit == Silhouette ? EditKind::Silhouette : EditKind::Holes;
    change.noise = {.scale_m = 0.5f, .octaves = 3};
    light.occluder_edits = {change};
    return light;
}

struct Stage {
    std::unique_ptr<Scene> scene;
    std::unique_ptr<Media> media;
    View view;
    std::vector<ViewRay> rays;
};
Stage make_stage(std::int64_t occluder, std::int64_t kind, std::int64_t edit) {
    const bool is_forest = occluder == Forest;
    const Bounds3 fog = is_forest ? support::forest_fog_box : Bounds3{vec3(-4, -4, -4), vec3(4, 4, 3.9f)};
    static const auto leaves = [] {
        support::TriangleSoup soup = support::make_forest();
        return support::mesh_of({.name = "forest", .positions = soup.positions, .triangles = soup.triangles});
    }();
    static const auto bars = support::mesh_of(support::lattice());
    Stage stage;
    stage.scene = support::make_scene(
        {{.mesh = is_forest ? leaves : bars},
         {.mesh = support::cube(),
          .world_from_object = glm::scale(support::translation(fog.centre()), 0.5f * (fog.max - fog.min)),
          .material = {.name = "fog", .medium_index = 0, .has_surface = false}}},
        {{.name = "fog", .lobes = {{Rgb(is_forest ? 0.02f : 0.1f), 0.0f}}}}, {light_of(occluder, kind, edit)});
    Progress progress;
    stage.media = std::make_unique<Media>(*stage.scene, progress);
    stage.view.position = is_forest ? support::forest_camera_position : vec3(0.3f, -9.0f, -1.0f);
    for (int y = 0; y < 270; ++y)
        for (int x = 0; x < 480; ++x) {
            const vec3 direction(0.6f * (static_cast<float>(x) + 0.5f - 240) / 240, 1.0f,
                                 0.6f * (static_cast<float>(y) + 0.5f - 135) / 240);
            stage.rays.push_back({stage.view.position, glm::normalize(direction), 0.0f, is_forest ? 80.0f : 14.0f});
        }
    return stage;
}
} // namespace

static void edited(benchmark::State& state) {
    static const bool has_machine = (add_machine_to_context(), true);
    using Key = std::array<std::int64_t, 3>;
    static std::map<Key, std::vector<Rgb>> truths;
    const Key key{state.range(0), state.range(1), state.range(2)};
    const Stage stage = make_stage(key[0], key[1], key[2]);
    Progress progress;
    Result result;
    const auto render = [&](std::uint32_t resolution) {
        const Config config{.resolution = resolution};
        const Shafts shafts(*stage.scene, *stage.media, stage.view, stage.rays, config, progress);
        result.radiance.resize(stage.rays.size());
        shafts.scatter(stage.rays, result.radiance, {}, progress);
        result.statistics = shafts.statistics();
    };
    if (has_machine && !truths.contains(key)) {
        render(8192);
        truths[key] = result.radiance;
    }
    for (auto _ : state)
        render(static_cast<std::uint32_t>(state.range(3)));
    double error = 0.0, sum = 0.0;
    for (std::size_t ray = 0; ray < stage.rays.size(); ++ray) {
        error += std::pow(double{result.radiance[ray].x} - double{truths[key][ray].x}, 2);
        sum += double{truths[key][ray].x};
    }
    const auto count = static_cast<double>(stage.rays.size());
    state.counters["error_percent"] = 100.0 * std::sqrt(error / count) / (sum / count);
    for (const auto& [name, value] : result.statistics.counts)
        if (name == "slope rows: lines")
            state.counters["lines"] = value;
}
BENCHMARK(edited)
    ->ArgNames({"occluders", "light", "edit", "resolution"})
    ->ArgsProduct({{0, 1}, {0, 1, 2}, {0, 1, 2}, {0, 1024, 2048, 4096, 8192}})
    ->Iterations(1)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
} // namespace tyndall::bench
