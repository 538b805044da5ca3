// SPDX-License-Identifier: GPL-3.0-or-later
// EXACT visibility: pixels per second of the exact strip, per instruction set, under the sun of the scene and under a
// lamp; a hierarchy's build. 96 runs of 256 neighbouring pixels of full HD, two threads at work as in a frame.
// Counters: transitions between light and dark per ray as 2,048 steps see them, error against 4,096-step marching.
#include "core/simd.hpp"
#include "light_shafts/exact_strip.hpp"
#include "support/machine.hpp"
#include "support/shaft_scenes.hpp"
#include <benchmark/benchmark.h>
#include <cmath>

namespace tyndall::bench {
using namespace light_shafts;

namespace {
/// The benchmark's soup as a scene of one instance.
struct ExactScene {
    ShaftScene& source;
    std::unique_ptr<Scene> scene;
    std::unique_ptr<Visibility> sun, lamp;
    std::vector<ViewRay> rays;

    explicit ExactScene(ShaftScene& shaft_scene) : source(shaft_scene) {
        SceneDescription description;
        description.meshes = {std::make_shared<const TriangleMesh>(
            MeshArrays{.name = "soup", .positions = source.soup.positions, .triangles = source.soup.triangles},
            Progress())};
        description.materials = {{.name = "white"}};
        description.slot_materials = {0};
        description.object_names = {"soup"};
        description.instances = {{}};
        scene = std::make_unique<Scene>(std::move(description), Progress());
        Progress progress;
        const auto strip = std::make_shared<const StripScene>(make_strip_scene(*scene, progress));
        sun = make_exact_strip(*scene, source.sun, strip);
        const vec3 above = source.view.position + 40.0f * source.sun.towards_light;
        lamp = make_exact_strip(*scene, LightSample{.is_directional = false, .position = above}, strip);
        support::SceneRandom random(3);
        constexpr std::size_t run = 256;
        for (int part = 0; part < 96; ++part) {
            const auto first =
                run * static_cast<std::size_t>(random.uniform() * static_cast<float>(source.rays.size() / run));
            for (std::size_t ray = first; ray < first + run; ++ray)
                if (source.rays[ray].far_m > 0.0f)
                    rays.push_back(source.rays[ray]);
        }
    }
};

ExactScene* scene_of(char name) {
    if (name == 'F') {
        static ExactScene forest(forest_scene());
        return &forest;
    }
    static const std::unique_ptr<ExactScene> sponza =
        sponza_scene() ? std::make_unique<ExactScene>(*sponza_scene()) : nullptr;
    return sponza.get();
}

double transitions_per_ray(const Visibility& visibility, std::span<const ViewRay> rays) {
    LitRows rows;
    visibility.lit_intervals(rays, rows);
    std::size_t transitions = 0;
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        std::uint32_t lit = rows.first[ray];
        bool was_lit = false;
        constexpr int steps = 2048;
        for (int step = 0; step < steps; ++step) {
            const float t = rays[ray].far_m * (static_cast<float>(step) + 0.5f) / steps;
            while (lit < rows.first[ray + 1] && rows.intervals[lit].far_m <= t)
                ++lit;
            const bool is_lit = lit < rows.first[ray + 1] && rows.intervals[lit].near_m <= t;
            transitions += step > 0 && is_lit != was_lit;
            was_lit = is_lit;
        }
    }
    return static_cast<double>(transitions) / static_cast<double>(rays.size());
}

/// RMS error over the mean of the scattered share, against the marched truth.
double relative_error(const ExactScene& scene) {
    double squares = 0.0, sum = 0.0;
    const double sigma = scene.source.sigma_t_per_m;
    for (std::size_t index = 0; index < scene.source.truth.size(); ++index) {
        LitRows rows;
        scene.sun->lit_intervals({&scene.source.rays[scene.source.truth_rays[index]], 1}, rows);
        double share = 0.0;
        for (const LitInterval& lit : rows.intervals)
            share += std::exp(-sigma * lit.near_m) * -std::expm1(-sigma * (lit.far_m - lit.near_m));
        const double difference = share - scene.source.truth[index];
        squares += difference * difference, sum += scene.source.truth[index];
    }
    const auto count = static_cast<double>(scene.source.truth.size());
    return std::sqrt(squares / count) / (sum / count);
}

void exact(benchmark::State& state, char name, SimdTarget target, bool is_lamp) {
    const ExactScene* scene = scene_of(name);
    if (scene == nullptr) {
        state.SkipWithError("Sponza-LowPoly is not here");
        return;
    }
    const Visibility& visibility = is_lamp ? *scene->lamp : *scene->sun;
    const ForcedSimdTarget forced(target);
    const Progress progress;
    for (auto _ : state)
        parallel_blocks(scene->rays.size(), 256, progress, [&](std::size_t begin, std::size_t end) {
            LitRows rows;
            visibility.lit_intervals(std::span(scene->rays).subspan(begin, end - begin), rows);
            benchmark::DoNotOptimize(rows.intervals.data());
        });
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene->rays.size()));
    state.counters["transitions_per_ray"] = transitions_per_ray(visibility, scene->rays);
    if (!is_lamp)
        state.counters["relative_rmse"] = relative_error(*scene);
}

void build_hierarchy(benchmark::State& state, char name) {
    const ExactScene* scene = scene_of(name);
    if (scene == nullptr) {
        state.SkipWithError("Sponza-LowPoly is not here");
        return;
    }
    const SharedMeshArrays& arrays = scene->scene->description().meshes[0]->arrays();
    for (auto _ : state)
        benchmark::DoNotOptimize(TriangleBvh(rtcGetSceneDevice(scene->scene->trees().all()), arrays, Progress()));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(arrays.triangles.size()));
}

const bool is_registered = [] {
    add_machine_to_context();
    for (const char name : {'S', 'F'}) {
        for (const SimdTarget target : available_simd_targets()) {
            const ForcedSimdTarget forced(target);
            for (const bool is_lamp : {false, true})
                benchmark::RegisterBenchmark(
                    ("exact_strip/" + std::string(1, name) + "/" + (is_lamp ? "lamp/" : "sun/") + simd_target_name())
                        .c_str(),
                    [=](benchmark::State& state) { exact(state, name, target, is_lamp); })
                    ->UseRealTime()
                    ->Unit(benchmark::kMillisecond);
        }
        benchmark::RegisterBenchmark(("build_hierarchy/" + std::string(1, name)).c_str(),
                                     [=](benchmark::State& state) { build_hierarchy(state, name); })
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
    }
    return true;
}();
} // namespace
} // namespace tyndall::bench
