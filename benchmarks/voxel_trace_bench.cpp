// SPDX-License-Identifier: GPL-3.0-or-later
// Rays through the Stanford dragon at 8K^3 (thin rule, packed bits with 48 turns), one thread, beside Embree on its mesh.
//   rays      primary: 1024 x 1024 of a camera, row by row; random: from a sphere around, aimed at voxels; bounce: from what
//             the camera sees, into the half space over the voxel's face
//   ways      reference: trace() of one ray; single: Tracer, one ray; many: Tracer, all; occluded: whether anything is hit;
//             starts, from_starts: beams of 8 x 8 pixels, and rays that begin where these say; embree, embree_16:
//             rtcIntersect1 and 16; prepare: making a Tracer
// Counters: Mrays/s, the share that hits, bytes of the Tracer beside the packed ones. Rays are not sorted.
#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "scene/embree.hpp"
#include "support/machine.hpp"
#include "support/voxel_meshes.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/tracer.hpp"
#include "voxel_dag/voxelize.hpp"
#include <algorithm>
#include <benchmark/benchmark.h>
#include <map>
#include <random>

namespace tyndall::bench {
using namespace voxel_dag;
namespace {
constexpr std::size_t picture_px = 1024;

struct Dragon {
    BareMesh mesh; ///< In voxels.
    PackedDag dag;
    std::map<std::string, std::vector<VoxelRay>> rays;
};

std::vector<VoxelRay> primary_rays(const PackedDag& dag, const dvec3& middle) {
    const dvec3 forward = glm::normalize(dvec3(-0.4, -0.3, -1.0));
    const dvec3 right = glm::normalize(glm::cross(forward, dvec3(0, 1, 0))), up = glm::cross(right, forward);
    const dvec3 camera = middle - 1.2 * static_cast<double>(1u << dag.level) * forward;
    std::vector<VoxelRay> rays;
    for (std::size_t y = 0; y < picture_px; ++y)
        for (std::size_t x = 0; x < picture_px; ++x)
            rays.push_back({.origin = camera,
                            .direction = forward + 0.9 * ((static_cast<double>(x) + 0.5) / picture_px - 0.5) * right +
                                         0.9 * ((static_cast<double>(y) + 0.5) / picture_px - 0.5) * up});
    return rays;
}
dvec3 random_direction(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const double x = normal(random), y = normal(random);
    return glm::normalize(dvec3(x, y, normal(random)));
}
std::vector<VoxelRay> random_rays(const PackedDag& dag, const LeafMasks& voxels) {
    std::mt19937_64 random(2);
    const double side = static_cast<double>(1u << dag.level);
    std::vector<VoxelRay> rays;
    for (int i = 0; i < 1 << 19; ++i) {
        const Voxel brick = voxel_at(voxels.codes[random() % voxels.codes.size()] << 3 * leaf_level);
        const dvec3 origin = 0.5 * side + side * random_direction(random);
        rays.push_back({.origin = origin, .direction = dvec3(brick[0], brick[1], brick[2]) + 2.0 - origin});
    }
    return rays;
}
std::vector<VoxelRay> bounce_rays(const PackedDag& dag, const std::vector<VoxelRay>& primary) {
    std::mt19937_64 random(3);
    std::vector<VoxelHit> hits(primary.size());
    Tracer(dag).trace(primary, hits, Progress());
    std::vector<VoxelRay> rays;
    for (std::size_t i = 0; i < hits.size(); ++i)
        if (const int axis = static_cast<int>(hits[i].axis); hits[i].is_hit() && axis < 3) {
            dvec3 normal(0.0);
            normal[axis] = primary[i].direction[axis] < 0.0 ? 1.0 : -1.0;
            const dvec3 direction = random_direction(random);
            rays.push_back({.origin = primary[i].origin + hits[i].distance * primary[i].direction + 0.01 * normal,
                            .direction = glm::dot(direction, normal) < 0.0 ? -direction : direction});
        }
    return rays;
}

const Dragon* dragon() {
    static const std::optional<Dragon> made = []() -> std::optional<Dragon> {
        add_machine_to_context();
        std::optional<BareMesh> mesh = load_dragon();
        if (!mesh)
            return std::nullopt;
        constexpr std::uint32_t resolution = 8192;
        const LeafMasks voxels =
            voxelize(std::span<const vec3>(mesh->positions), mesh->triangles, {.resolution = resolution}, Progress())
                .leaves;
        Dragon all{.mesh = std::move(*mesh),
                   .dag = pack_dag(merge_symmetric(build_dag(voxels, {}, Progress()), {}, Progress()), Progress()),
                   .rays = {}};
        vec3 lowest(1e9f), highest(-1e9f);
        for (const vec3& position : all.mesh.positions)
            lowest = glm::min(lowest, position), highest = glm::max(highest, position);
        const vec3 sides = highest - lowest;
        const float per_m = static_cast<float>(resolution) / std::max({sides.x, sides.y, sides.z});
        for (vec3& position : all.mesh.positions)
            position = (position - lowest) * per_m;
        all.rays["primary"] = primary_rays(all.dag, 0.5 * dvec3(sides * per_m));
        all.rays["random"] = random_rays(all.dag, voxels);
        all.rays["bounce"] = bounce_rays(all.dag, all.rays["primary"]);
        return all;
    }();
    return made ? &*made : nullptr;
}

void report(benchmark::State& state, std::size_t ray_count, std::size_t hit_count) {
    state.counters["hit_share"] = static_cast<double>(hit_count) / static_cast<double>(ray_count);
    state.counters["mrays_per_s"] =
        benchmark::Counter(1e-6 * static_cast<double>(ray_count), benchmark::Counter::kIsIterationInvariantRate);
}
/// Nothing, and the benchmark is skipped, without the mesh.
const std::vector<VoxelRay>* rays_of(benchmark::State& state, const std::string& kind) {
    if (dragon() != nullptr)
        return &dragon()->rays.at(kind);
    state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
    return nullptr;
}

template <class TraceOne>
void one_by_one(benchmark::State& state, const std::string& kind, const TraceOne& trace_one) {
    if (const std::vector<VoxelRay>* const rays = rays_of(state, kind)) {
        std::size_t hit_count = 0;
        for (auto _ : state) {
            hit_count = 0;
            for (const VoxelRay& ray : *rays)
                hit_count += trace_one(ray);
        }
        report(state, rays->size(), hit_count);
    }
}
void reference(benchmark::State& state, const std::string& kind) {
    one_by_one(state, kind, [](const VoxelRay& ray) { return trace(dragon()->dag, ray).is_hit(); });
}
const Tracer& tracer() {
    static const Tracer made(dragon()->dag);
    return made;
}
void single(benchmark::State& state, const std::string& kind, SimdTarget target) {
    const ForcedSimdTarget forced(target);
    one_by_one(state, kind, [](const VoxelRay& ray) { return tracer().trace(ray).is_hit(); });
}
void many(benchmark::State& state, const std::string& kind, SimdTarget target) {
    const ForcedSimdTarget forced(target);
    if (const std::vector<VoxelRay>* const rays = rays_of(state, kind)) {
        std::vector<VoxelHit> hits(rays->size());
        for (auto _ : state)
            with_threads(1, [&] { tracer().trace(*rays, hits, Progress()); });
        report(state, rays->size(),
               static_cast<std::size_t>(std::ranges::count_if(hits, [](const auto& hit) { return hit.is_hit(); })));
    }
}
void occluded(benchmark::State& state, const std::string& kind, SimdTarget target) {
    const ForcedSimdTarget forced(target);
    if (const std::vector<VoxelRay>* const rays = rays_of(state, kind)) {
        const auto are_occluded = std::make_unique<bool[]>(rays->size());
        const std::span<bool> found(are_occluded.get(), rays->size());
        for (auto _ : state)
            with_threads(1, [&] { tracer().find_occluded(*rays, found, Progress()); });
        report(state, rays->size(), static_cast<std::size_t>(std::ranges::count(found, true)));
    }
}
void starts(benchmark::State& state) {
    if (const std::vector<VoxelRay>* const rays = rays_of(state, "primary")) {
        std::vector<double> found;
        for (auto _ : state)
            with_threads(1, [&] { found = tracer().block_starts(*rays, picture_px, Progress()); });
        report(state, rays->size(),
               rays->size() / found.size() *
                   static_cast<std::size_t>(std::ranges::count_if(found, [](double at) { return at < 1e9; })));
    }
}
void from_starts(benchmark::State& state) {
    if (const std::vector<VoxelRay>* const rays = rays_of(state, "primary")) {
        const std::vector<double> found = tracer().block_starts(*rays, picture_px, Progress());
        constexpr std::size_t block_px = Tracer::block_px;
        std::vector<VoxelRay> late = *rays;
        for (std::size_t i = 0; i < late.size(); ++i)
            late[i].start = found[i / picture_px / block_px * (picture_px / block_px) + i % picture_px / block_px];
        std::vector<VoxelHit> hits(late.size());
        for (auto _ : state)
            with_threads(1, [&] { tracer().trace(late, hits, Progress()); });
        report(state, late.size(),
               static_cast<std::size_t>(std::ranges::count_if(hits, [](const auto& hit) { return hit.is_hit(); })));
    }
}
void prepare(benchmark::State& state) {
    if (rays_of(state, "primary") == nullptr)
        return;
    for (auto _ : state)
        benchmark::DoNotOptimize(Tracer(dragon()->dag).byte_count());
    state.counters["bytes"] = static_cast<double>(tracer().byte_count());
    state.counters["packed_bytes"] = static_cast<double>(dragon()->dag.byte_count());
}

RTCScene embree_scene() {
    static const RTCScene made = [] {
        const BareMesh& mesh = dragon()->mesh;
        const RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.positions.data(), 0,
                                   sizeof(vec3), mesh.positions.size());
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                                   sizeof(uvec3), mesh.triangles.size());
        rtcCommitGeometry(geometry);
        const RTCScene scene = rtcNewScene(embree_device());
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
        return scene;
    }();
    return made;
}
void embree(benchmark::State& state, const std::string& kind) {
    one_by_one(state, kind, [](const VoxelRay& ray) {
        const vec3 origin(ray.origin), direction(ray.direction);
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit query{};
        query.ray.org_x = origin.x, query.ray.org_y = origin.y, query.ray.org_z = origin.z;
        query.ray.dir_x = direction.x, query.ray.dir_y = direction.y, query.ray.dir_z = direction.z;
        query.ray.tfar = std::numeric_limits<float>::infinity();
        query.ray.mask = ~0u;
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(embree_scene(), &context, &query);
        return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    });
}
/// Sixteen after sixteen; their number is a multiple.
void embree_16(benchmark::State& state, const std::string& kind) {
    const std::vector<VoxelRay>* const rays = rays_of(state, kind);
    if (rays == nullptr)
        return;
    std::size_t hit_count = 0;
    for (auto _ : state) {
        hit_count = 0;
        for (std::size_t first = 0; first + 16 <= rays->size(); first += 16) {
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
            alignas(64) int valid[16];
            RTCRayHit16 query{};
            for (std::size_t i = 0; i < 16; ++i) {
                const vec3 origin((*rays)[first + i].origin), direction((*rays)[first + i].direction);
                query.ray.org_x[i] = origin.x, query.ray.org_y[i] = origin.y, query.ray.org_z[i] = origin.z;
                query.ray.dir_x[i] = direction.x, query.ray.dir_y[i] = direction.y, query.ray.dir_z[i] = direction.z;
                query.ray.tfar[i] = std::numeric_limits<float>::infinity();
                query.ray.mask[i] = ~0u;
                query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
                valid[i] = -1;
            }
            rtcIntersect16(valid, embree_scene(), &context, &query);
            hit_count += static_cast<std::size_t>(std::ranges::count_if(
                query.hit.geomID, [](unsigned geometry) { return geometry != RTC_INVALID_GEOMETRY_ID; }));
        }
    }
    report(state, rays->size(), hit_count);
}

const bool is_registered = [] {
    const auto add = [](const std::string& name, const auto& run) {
        benchmark::RegisterBenchmark(name.c_str(), run)->UseRealTime()->Unit(benchmark::kMillisecond);
    };
    for (const std::string kind : {"primary", "random", "bounce"}) {
        add("reference/" + kind, [=](benchmark::State& state) { reference(state, kind); });
        for (const SimdTarget target : available_simd_targets()) {
            const ForcedSimdTarget forced(target);
            const std::string name = kind + "/" + simd_target_name();
            add("single/" + name, [=](benchmark::State& state) { single(state, kind, target); });
            add("many/" + name, [=](benchmark::State& state) { many(state, kind, target); });
            add("occluded/" + name, [=](benchmark::State& state) { occluded(state, kind, target); });
        }
        add("embree/" + kind, [=](benchmark::State& state) { embree(state, kind); });
    }
    add("embree_16/primary", [](benchmark::State& state) { embree_16(state, "primary"); });
    add("starts", starts);
    add("from_starts", from_starts);
    add("prepare", prepare);
    return true;
}();
} // namespace
} // namespace tyndall::bench
