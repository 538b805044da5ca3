// SPDX-License-Identifier: GPL-3.0-or-later
// Primary rays through Scene::closest_hit against a bare Embree loop over the same triangles: 1M of them, one thread,
// full HD from a camera above hills. "bare" is a flat Embree scene with the same flags, rtcIntersect1 and nothing else.
#include "scene/embree.hpp"
#include "scene/scene.hpp"
#include <benchmark/benchmark.h>
#include <cmath>

namespace tyndall::bench {
/// Hills of 708 x 708 squares: 1,002,528 triangles.
static MeshArrays hills() {
    constexpr std::uint32_t side = 709;
    MeshArrays arrays;
    arrays.name = "hills";
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) {
            const vec2 p =
                40.0f * vec2(static_cast<float>(x), static_cast<float>(y)) / static_cast<float>(side - 1) - 20.0f;
            arrays.positions.emplace_back(p, std::sin(p.x) * std::cos(1.3f * p.y) +
                                                 0.2f * std::sin(7.0f * p.x + 5.0f * p.y));
        }
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x;
            arrays.triangles.emplace_back(a, a + 1, a + side + 1);
            arrays.triangles.emplace_back(a, a + side + 1, a + side);
        }
    return arrays;
}
static const std::shared_ptr<const TriangleMesh>& mesh() {
    static const auto hill_mesh = std::make_shared<const TriangleMesh>(hills(), Progress());
    return hill_mesh;
}
static const Scene& scene() {
    static const Scene hill_scene(
        [] {
            SceneDescription description;
            description.meshes = {mesh()};
            description.materials = {{.name = "white"}};
            description.slot_materials = {0};
            description.object_names = {"hills"};
            description.instances = {{}};
            return description;
        }(),
        Progress());
    return hill_scene;
}
static Camera camera() {
    Camera camera;
    camera.world_from_camera = glm::rotate(glm::translate(mat4(1.0f), vec3(0, -18, 6)), 1.15f, vec3(1, 0, 0));
    return camera;
}

/// Calls visit(ray) for every pixel of every fourth row.
template <typename Visit>
static void over_pixels(benchmark::State& state, const Visit& visit) {
    const Camera view = camera();
    std::size_t ray_count = 0, hit_count = 0;
    for (auto _ : state)
        for (std::uint32_t y = 0; y < view.height_px; y += 4)
            for (std::uint32_t x = 0; x < view.width_px; ++x) {
                hit_count += visit(view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f));
                ++ray_count;
            }
    state.counters["rays_per_second"] = benchmark::Counter(static_cast<double>(ray_count), benchmark::Counter::kIsRate);
    state.counters["hit_share"] = static_cast<double>(hit_count) / static_cast<double>(ray_count);
}

static void bare_embree(benchmark::State& state) {
    const SharedMeshArrays& arrays = mesh()->arrays();
    const RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, arrays.positions.data(), 0,
                               sizeof(vec3), arrays.positions.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, arrays.triangles.data(), 0,
                               sizeof(uvec3), arrays.triangles.size());
    rtcCommitGeometry(geometry);
    const RTCScene flat = rtcNewScene(embree_device());
    rtcAttachGeometry(flat, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(flat, static_cast<RTCSceneFlags>(state.range(0)));
    rtcCommitScene(flat);
    over_pixels(state, [&](const Ray& ray) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit query{};
        query.ray = {ray.origin.x,
                     ray.origin.y,
                     ray.origin.z,
                     ray.near_m,
                     ray.direction.x,
                     ray.direction.y,
                     ray.direction.z,
                     0.0f,
                     ray.far_m,
                     ~0u,
                     0,
                     0};
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(flat, &context, &query);
        return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    });
    rtcReleaseScene(flat);
}
static void closest_hit(benchmark::State& state) {
    over_pixels(state, [&](const Ray& ray) { return scene().closest_hit(ray).is_hit(); });
}
static void shadow(benchmark::State& state) {
    over_pixels(state, [&](const Ray& ray) { return scene().shadow_transmittance(ray).x == 0.0f; });
}
static void build_mesh(benchmark::State& state) {
    for (auto _ : state) {
        MeshArrays arrays = hills();
        benchmark::DoNotOptimize(TriangleMesh(std::move(arrays), Progress()));
    }
}
static void build_instances(benchmark::State& state) {
    SceneDescription description;
    description.meshes = {mesh()};
    description.materials = {{.name = "white"}};
    description.slot_materials = {0};
    description.object_names = {"hills"};
    for (int instance = 0; instance < state.range(0); ++instance)
        description.instances.push_back(
            {.world_from_object = glm::translate(mat4(1.0f), vec3(instance % 317, instance / 317, 0))});
    for (auto _ : state)
        benchmark::DoNotOptimize(Scene(description, Progress()).bounds());
}
BENCHMARK(bare_embree)->ArgName("flags")->Arg(static_cast<int>(traced_scene_flags))->Arg(RTC_SCENE_FLAG_ROBUST)->Arg(0);
BENCHMARK(closest_hit);
BENCHMARK(shadow);
BENCHMARK(build_mesh)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(build_instances)->Arg(100000)->UseRealTime()->Unit(benchmark::kMillisecond);
} // namespace tyndall::bench
