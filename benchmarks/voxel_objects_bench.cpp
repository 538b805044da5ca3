// SPDX-License-Identifier: GPL-3.0-or-later
// The Stanford dragon's voxels (thin rule) as an object of a scene. resolution: voxels a side.
//   direct            1024 x 1024 rays of a camera: the shape itself, one thread
//   embree, packets   the same rays through a scene with one placement: one by one, and 16 at a time
//   occlusion         from what they meet towards a sun: shadow rays, 16 at a time
//   place             a scene of that many placements, from its description: what a moved one costs
// Counters: mrays_per_s; share of rays that hit.
#include "scene/scene.hpp"
#include "support/machine.hpp"
#include "support/voxel_meshes.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/voxel_shape.hpp"
#include <benchmark/benchmark.h>

namespace tyndall::bench {
using namespace voxel_dag;
namespace {
/// In a cube of 1 m; the last resolution asked for is kept. Nothing without the mesh.
std::shared_ptr<const CellGeometry> dragon(benchmark::State& state) {
    static const bool has_machine = (add_machine_to_context(), true);
    static const std::optional<BareMesh> mesh = load_dragon();
    static std::int64_t kept = -1;
    static std::shared_ptr<const CellGeometry> geometry;
    if (!has_machine || !mesh) {
        state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
        return nullptr;
    }
    if (kept != state.range(0)) {
        const LeafMasks voxels = voxelize(std::span<const vec3>(mesh->positions), mesh->triangles,
                                          {.resolution = static_cast<std::uint32_t>(state.range(0))}, Progress())
                                     .leaves;
        const Dag dag = merge_symmetric(build_dag(voxels, {}, Progress()), {}, Progress());
        auto placed = std::make_shared<const PlacedDag>(PlacedDag{pack_dag(dag, Progress()), Cube{dvec3(0.0), 1.0}});
        geometry = std::make_shared<const CellGeometry>(make_voxel_shape(std::move(placed), "dragon"));
        kept = state.range(0);
    }
    return geometry;
}

SceneDescription placements(const std::shared_ptr<const CellGeometry>& geometry, std::int64_t count) {
    SceneDescription scene;
    scene.object_names = {"dragon"};
    scene.materials = {Material{.name = "white"}};
    scene.shapes = {geometry};
    for (std::int64_t i = 0; i < count; ++i)
        scene.placed_shapes.push_back(
            {.world_from_object =
                 glm::translate(mat4(1.0f), vec3(static_cast<float>(i % 100), 0.0f, static_cast<float>(i / 100)))});
    return scene;
}

/// From in front and a little above, 1.2 m away.
std::vector<Ray> camera_rays(const CellShape& shape) {
    const vec3 forward = glm::normalize(vec3(-0.4f, -0.3f, -1.0f));
    const vec3 right = glm::normalize(glm::cross(forward, vec3(0, 1, 0))), up = glm::cross(right, forward);
    std::vector<Ray> rays;
    for (int y = 0; y < 1024; ++y)
        for (int x = 0; x < 1024; ++x) {
            const vec2 at = 0.9f * (vec2(x, y) + 0.5f) / 1024.0f - 0.45f;
            rays.push_back({.origin = shape.bounds().centre() - 1.2f * forward,
                            .direction = glm::normalize(forward + at.x * right + at.y * up)});
        }
    return rays;
}

void report(benchmark::State& state, std::size_t rays, std::size_t hits) {
    state.counters["hit_share"] = static_cast<double>(hits) / static_cast<double>(rays);
    state.counters["mrays_per_s"] =
        benchmark::Counter(1e-6 * static_cast<double>(rays), benchmark::Counter::kIsIterationInvariantRate);
}

void direct(benchmark::State& state) {
    const auto geometry = dragon(state);
    if (geometry == nullptr)
        return;
    const std::vector<Ray> rays = camera_rays(geometry->shape());
    std::size_t hits = 0;
    for (auto _ : state) {
        hits = 0;
        for (const Ray& ray : rays)
            hits += geometry->shape().closest_hit(ray).is_hit();
    }
    report(state, rays.size(), hits);
}

template <std::size_t at_once>
void embree(benchmark::State& state) {
    const auto geometry = dragon(state);
    if (geometry == nullptr)
        return;
    const Scene scene(placements(geometry, 1), Progress());
    const std::vector<Ray> rays = camera_rays(geometry->shape());
    std::vector<Hit> found(rays.size());
    for (auto _ : state)
        for (std::size_t first = 0; first < rays.size(); first += at_once)
            scene.closest_hits(std::span(rays).subspan(first, at_once), std::span(found).subspan(first, at_once));
    report(state, rays.size(), static_cast<std::size_t>(std::ranges::count_if(found, &Hit::is_hit)));
}

void occlusion(benchmark::State& state) {
    const auto geometry = dragon(state);
    if (geometry == nullptr)
        return;
    const Scene scene(placements(geometry, 1), Progress());
    std::vector<Ray> rays;
    for (const Ray& ray : camera_rays(geometry->shape()))
        if (const Hit hit = scene.closest_hit(ray); hit.is_hit())
            rays.push_back(scene.leaving_ray(hit, glm::normalize(vec3(0.5f, 1.0f, 0.6f))));
    std::vector<Rgb> passing(rays.size());
    for (auto _ : state)
        scene.shadow_transmittances(rays, passing);
    report(state, rays.size(), static_cast<std::size_t>(std::ranges::count(passing, Rgb(0.0f))));
}

void place(benchmark::State& state) {
    const auto geometry = dragon(state);
    if (geometry == nullptr)
        return;
    const SceneDescription description = placements(geometry, state.range(1));
    for (auto _ : state)
        benchmark::DoNotOptimize(Scene(description, Progress()).bounds());
}

void resolutions(benchmark::internal::Benchmark* run) {
    run->ArgName("resolution")->UseRealTime()->Unit(benchmark::kMillisecond)->Arg(1024)->Arg(8192);
}
} // namespace

BENCHMARK(direct)->Apply(resolutions);
BENCHMARK_TEMPLATE(embree, 1)->Name("embree")->Apply(resolutions);
BENCHMARK_TEMPLATE(embree, 16)->Name("packets")->Apply(resolutions);
BENCHMARK(occlusion)->Apply(resolutions);
BENCHMARK(place)
    ->ArgNames({"resolution", "count"})
    ->Args({1024, 100})
    ->Args({1024, 10000})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
} // namespace tyndall::bench
