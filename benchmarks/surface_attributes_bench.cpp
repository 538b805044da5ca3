// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes of the voxels of a mesh, per voxel that is there already. mesh: 0 the Stanford dragon, 1 Sponza-LowPoly.
// surface: 0 colours of vertices, 1 normals of vertices, 2 both and four channels, 3 a picture of 1024 x 1024 texels, laid
// on by each triangle's main axis (Sponza-LowPoly's file has no materials; nor has the dragon), and normals of faces.
#include "core/parallel.hpp"
#include "support/voxel_meshes.hpp"
#include "voxel_dag/surface_attributes.hpp"
#include <benchmark/benchmark.h>
#include <random>

namespace tyndall::bench {
using namespace voxel_dag;

namespace {
struct Painted {
    BareMesh mesh;
    std::vector<vec3> normals, colors;
    std::vector<float> heights;
    std::vector<vec2> corner_uvs;
};

Painted painted(BareMesh mesh) {
    Painted result{.mesh = std::move(mesh), .normals = {}, .colors = {}, .heights = {}, .corner_uvs = {}};
    const auto& positions = result.mesh.positions;
    Bounds3 bounds;
    for (const vec3& position : positions)
        bounds.grow(position);
    const vec3 extent = bounds.max - bounds.min;
    const float longest = std::max({extent.x, extent.y, extent.z});
    result.normals.assign(positions.size(), vec3(0));
    for (const uvec3& t : result.mesh.triangles) {
        const vec3 n = glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
        const vec3 seen = glm::abs(n);
        for (int corner = 0; corner < 3; ++corner) {
            result.normals[t[corner]] += n;
            const vec3 at = 8.0f * (positions[t[corner]] - bounds.min) / longest;
            result.corner_uvs.push_back(seen.x > std::max(seen.y, seen.z)   ? vec2(at.y, at.z)
                                        : seen.y > std::max(seen.x, seen.z) ? vec2(at.x, at.z)
                                                                            : vec2(at.x, at.y));
        }
    }
    for (const vec3& position : positions) {
        const vec3 at = (position - bounds.min) / longest;
        result.colors.push_back(0.5f + 0.5f * glm::sin(40.0f * at));
        result.heights.push_back(at.y);
    }
    return result;
}
const Painted* mesh(std::int64_t which) {
    const auto load = [](std::optional<BareMesh> bare) {
        return bare ? std::optional<Painted>(painted(std::move(*bare))) : std::nullopt;
    };
    static const std::optional<Painted> dragon = load(load_dragon()), sponza = load(load_bare_sponza());
    const std::optional<Painted>& wanted = which == 0 ? dragon : sponza;
    return wanted ? &*wanted : nullptr;
}
std::shared_ptr<const FilteredTexture> noise() {
    Texture texture{.name = "noise", .width = 1024, .height = 1024};
    std::mt19937 random(1);
    std::vector<std::uint8_t> texels;
    for (std::uint32_t byte = 0; byte < 4 * texture.width * texture.height; ++byte)
        texels.push_back(static_cast<std::uint8_t>(random() >> 24));
    texture.bytes = std::move(texels);
    return std::make_shared<FilteredTexture>(std::make_shared<Texture>(std::move(texture)));
}
} // namespace

static void paint(benchmark::State& state) {
    const Painted* const bare = mesh(state.range(0));
    if (bare == nullptr) {
        state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
        return;
    }
    static const std::array<SurfaceMaterial, 1> materials{SurfaceMaterial{.color = {}, .texture = noise()}};
    Surface surface;
    if (state.range(2) == 3) {
        surface.materials = materials;
        surface.corner_uvs = bare->corner_uvs;
        surface.normals = SurfaceNormals::Faces;
    }
    if (state.range(2) == 0 || state.range(2) == 2)
        surface.colors = bare->colors;
    if (state.range(2) == 1 || state.range(2) == 2) {
        surface.normals = SurfaceNormals::Vertices;
        surface.vertex_normals = bare->normals;
    }
    if (state.range(2) == 2)
        surface.channels = {{"a", bare->heights}, {"b", bare->heights}, {"c", bare->heights}, {"d", bare->heights}};
    const VoxelizeConfig config{.resolution = static_cast<std::uint32_t>(state.range(1))};
    const Progress progress;
    const std::span<const vec3> positions(bare->mesh.positions);
    const LeafMasks leaves = voxelize(positions, bare->mesh.triangles, config, progress).leaves;
    for (auto _ : state)
        benchmark::DoNotOptimize(with_threads(static_cast<int>(state.range(3)), [&] {
            return surface_attributes(positions, bare->mesh.triangles, config, leaves, surface, progress);
        }));
    const auto voxels = static_cast<double>(leaves.voxel_count());
    state.counters["voxels"] = voxels;
    state.counters["mvoxels_per_s"] = benchmark::Counter(voxels * 1e-6, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(paint)
    ->ArgNames({"mesh", "resolution", "surface", "threads"})
    ->ArgsProduct({{0, 1}, {4096, 8192}, {0, 1, 2, 3}, {1, 2}})
    ->MeasureProcessCPUTime() // of all threads: what a machine that others use, too, changes least
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
} // namespace tyndall::bench
