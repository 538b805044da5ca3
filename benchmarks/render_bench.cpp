// SPDX-License-Identifier: GPL-3.0-or-later
// What a frame costs before any light shaft: camera rays beside bare Embree loops of the same run, and the time from
// render() entered to the first picture, geometry sent and hierarchies built included.
#include "core/parallel.hpp"
#include "render/frame.hpp"
#include "support/forest.hpp"
#include "support/machine.hpp"
#include <array>
#include <atomic>
#include <benchmark/benchmark.h>
#include <stdexcept>

namespace tyndall::bench {
namespace {
constexpr std::uint32_t width_px = 1920, height_px = 1080;

Camera forest_camera() {
    Camera camera;
    // Looks along +Y, +Z up.
    camera.world_from_camera = glm::translate(mat4(1.0f), support::forest_camera_position) *
                               mat4(vec4(1, 0, 0, 0), vec4(0, 0, 1, 0), vec4(0, -1, 0, 0), vec4(0, 0, 0, 1));
    camera.window_left = -0.6f, camera.window_right = 0.6f;
    camera.window_bottom = -0.3375f, camera.window_top = 0.3375f;
    camera.width_px = width_px, camera.height_px = height_px;
    return camera;
}

MeshArrays forest_arrays(std::size_t triangle_count) {
    support::TriangleSoup soup = support::make_forest(triangle_count);
    MeshArrays arrays;
    arrays.name = "forest";
    arrays.positions = std::move(soup.positions);
    arrays.triangles = std::move(soup.triangles);
    return arrays;
}

Light forest_sun() {
    Light sun;
    sun.name = "Sun";
    sun.towards_light = support::forest_towards_sun();
    return sun;
}

/// One mesh, placed once or on a square grid that is two metres wide per instance.
SceneDescription description_of(std::shared_ptr<const TriangleMesh> mesh, std::uint32_t instances_per_side) {
    SceneDescription description;
    description.meshes = {std::move(mesh)};
    description.materials.resize(1);
    description.slot_materials = {0};
    description.object_names = {"forest"};
    description.lights = {forest_sun()};
    for (std::uint32_t row = 0; row < instances_per_side; ++row)
        for (std::uint32_t column = 0; column < instances_per_side; ++column) {
            Instance instance;
            instance.world_from_object =
                glm::translate(mat4(1.0f), 2.0f * vec3(static_cast<float>(column), static_cast<float>(row), 0.0f));
            description.instances.push_back(instance);
        }
    return description;
}

const Scene& forest_scene() {
    static const auto mesh = std::make_shared<const TriangleMesh>(forest_arrays(1'000'000), Progress());
    static const Scene scene(description_of(mesh, 1), Progress());
    return scene;
}

/// Calls trace(ray) for every pixel's centre; returns how many hit.
template <typename Trace>
std::size_t trace_pixels(const Trace& trace) {
    const Camera camera = forest_camera();
    const Progress progress;
    std::atomic<std::size_t> hit_count = 0;
    parallel_blocks(std::size_t{width_px} * height_px, 4096, progress, [&](std::size_t begin, std::size_t end) {
        std::size_t hits = 0;
        for (std::size_t pixel = begin; pixel < end; ++pixel)
            hits += trace(
                camera.ray(static_cast<float>(pixel % width_px) + 0.5f, static_cast<float>(pixel / width_px) + 0.5f));
        hit_count += hits;
    });
    return hit_count;
}
void report_rays(benchmark::State& state, std::size_t hit_count) {
    const double rays = static_cast<double>(width_px) * height_px;
    state.counters["rays_per_s"] = benchmark::Counter(rays, benchmark::Counter::kIsIterationInvariantRate);
    state.counters["hit_share"] = static_cast<double>(hit_count) / rays;
}
} // namespace

/// The baseline: the mesh's own hierarchy, rtcIntersect1, nothing else.
static void bare_embree_loop(benchmark::State& state) {
    RTCScene embree = forest_scene().description().meshes[0]->embree_scene();
    std::size_t hits = 0;
    for (auto _ : state)
        hits = trace_pixels([&](const Ray& ray) {
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            RTCRayHit query{};
            query.ray.org_x = ray.origin.x, query.ray.org_y = ray.origin.y, query.ray.org_z = ray.origin.z;
            query.ray.dir_x = ray.direction.x, query.ray.dir_y = ray.direction.y, query.ray.dir_z = ray.direction.z;
            query.ray.tnear = ray.near_m, query.ray.tfar = ray.far_m;
            query.ray.mask = ~0u;
            query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(embree, &context, &query);
            return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        });
    report_rays(state, hits);
}
/// The same rays through our scene: one instance of that mesh.
static void scene_closest_hit(benchmark::State& state) {
    const Scene& scene = forest_scene();
    std::size_t hits = 0;
    for (auto _ : state)
        hits = trace_pixels([&](const Ray& ray) { return scene.closest_hit(ray).is_hit(); });
    report_rays(state, hits);
}
/// Calls trace(rays) for every square of 4 x 4 pixels; returns how many rays hit.
template <typename Trace>
static std::size_t trace_squares(const Trace& trace) {
    const Camera camera = forest_camera();
    const Progress progress;
    std::atomic<std::size_t> hit_count = 0;
    parallel_blocks(std::size_t{height_px} / 4, 1, progress, [&](std::size_t begin, std::size_t) {
        std::size_t hits = 0;
        std::array<Ray, 16> rays;
        for (std::uint32_t x = 0; x < width_px; x += 4) {
            for (std::uint32_t pixel = 0; pixel < 16; ++pixel)
                rays[pixel] = camera.ray(static_cast<float>(x + pixel % 4) + 0.5f,
                                         static_cast<float>(4 * begin + pixel / 4) + 0.5f);
            hits += trace(rays);
        }
        hit_count += hits;
    });
    return hit_count;
}
/// The baseline of packets: the mesh's own hierarchy, rtcIntersect16, coherent, nothing else.
static void bare_embree_packets(benchmark::State& state) {
    RTCScene embree = forest_scene().description().meshes[0]->embree_scene();
    std::size_t hits = 0;
    for (auto _ : state)
        hits = trace_squares([&](const std::array<Ray, 16>& rays) {
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
            RTCRayHit16 query;
            alignas(64) std::array<int, 16> valid;
            for (std::size_t lane = 0; lane < 16; ++lane) {
                const Ray& ray = rays[lane];
                valid[lane] = -1;
                query.ray.org_x[lane] = ray.origin.x, query.ray.org_y[lane] = ray.origin.y;
                query.ray.org_z[lane] = ray.origin.z, query.ray.tnear[lane] = ray.near_m;
                query.ray.dir_x[lane] = ray.direction.x, query.ray.dir_y[lane] = ray.direction.y;
                query.ray.dir_z[lane] = ray.direction.z, query.ray.tfar[lane] = ray.far_m;
                query.ray.time[lane] = 0.0f, query.ray.mask[lane] = ~0u, query.ray.flags[lane] = 0;
                query.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
            }
            rtcIntersect16(valid.data(), embree, &context, &query);
            std::size_t count = 0;
            for (const unsigned int geometry : query.hit.geomID)
                count += geometry != RTC_INVALID_GEOMETRY_ID;
            return count;
        });
    report_rays(state, hits);
}
/// The same rays as a frame traces them.
static void scene_closest_hits(benchmark::State& state) {
    const Scene& scene = forest_scene();
    std::size_t hits = 0;
    for (auto _ : state)
        hits = trace_squares([&](const std::array<Ray, 16>& rays) {
            std::array<Hit, 16> found;
            scene.closest_hits(rays, found);
            std::size_t count = 0;
            for (const Hit& hit : found)
                count += hit.is_hit();
            return count;
        });
    report_rays(state, hits);
}
/// A whole frame of one sample: camera rays, materials, one shadow ray per hit, film.
static void frame_of_one_sample(benchmark::State& state) {
    const Scene& scene = forest_scene();
    render::FrameConfig config;
    config.pixel_samples = 1;
    for (auto _ : state) {
        Progress progress;
        benchmark::DoNotOptimize(render::render(scene, forest_camera(), config, progress));
    }
    report_rays(state, 0);
}

namespace {
struct FirstPicture : std::exception {};
void render_first_picture(const Scene& scene) {
    Progress progress;
    try {
        (void)render::render(scene, forest_camera(), {}, progress, [](const render::Film&) { throw FirstPicture(); });
    } catch (const FirstPicture&) {
        return;
    }
    throw std::logic_error("the frame ended without an update");
}
} // namespace

/// Arrays in memory -> mesh, hierarchies, scene, first band of the picture.
static void first_picture_of_a_million_triangles(benchmark::State& state) {
    const MeshArrays arrays = forest_arrays(1'000'000);
    for (auto _ : state) {
        const auto mesh = std::make_shared<const TriangleMesh>(arrays, Progress());
        render_first_picture(Scene(description_of(mesh, 1), Progress()));
    }
}
static void first_picture_of_100k_instances(benchmark::State& state) {
    const MeshArrays arrays = forest_arrays(1000);
    for (auto _ : state) {
        const auto mesh = std::make_shared<const TriangleMesh>(arrays, Progress());
        render_first_picture(Scene(description_of(mesh, 317), Progress())); // 317^2 = 100,489
    }
}

BENCHMARK(bare_embree_loop)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(scene_closest_hit)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(bare_embree_packets)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(scene_closest_hits)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(frame_of_one_sample)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(first_picture_of_a_million_triangles)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(first_picture_of_100k_instances)->UseRealTime()->Unit(benchmark::kMillisecond);
} // namespace tyndall::bench
