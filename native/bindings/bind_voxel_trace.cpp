// SPDX-License-Identifier: GPL-3.0-or-later
// Rays through voxel DAGs.
#include "bindings/arrays.hpp"
#include "bindings/voxel_dag.hpp"
#include "voxel_dag/trace.hpp"

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

static py::tuple trace_rays(const PlacedDag& self, const py::array& origins, const py::array& directions,
                            const Progress& progress) {
    check_array<double>(origins, {-1, 3}, "origins");
    check_array<double>(directions, {origins.shape(0), 3}, "directions");
    const auto count = static_cast<std::size_t>(origins.shape(0));
    py::array_t<double> distances(origins.shape(0));
    py::array_t<std::uint32_t> voxels({origins.shape(0), py::ssize_t{3}});
    py::array_t<float> normals({origins.shape(0), py::ssize_t{3}});
    const auto* starts = static_cast<const dvec3*>(origins.data());
    const auto* ways = static_cast<const dvec3*>(directions.data());
    double* const distance = distances.mutable_data();
    auto* const voxel = reinterpret_cast<Voxel*>(voxels.mutable_data());
    auto* const normal = reinterpret_cast<vec3*>(normals.mutable_data());
    without_gil([&] {
        const double per_m = static_cast<double>(std::uint64_t{1} << self.dag.level) / self.bounds_m.side_m;
        std::vector<VoxelRay> rays(count);
        for (std::size_t i = 0; i < count; ++i)
            rays[i] = {.origin = (starts[i] - self.bounds_m.lower_m) * per_m, .direction = ways[i] * per_m};
        std::vector<VoxelHit> hits(count);
        trace(self.dag, rays, hits, progress);
        for (std::size_t i = 0; i < count; ++i) {
            const bool is_hit = hits[i].is_hit(); // a miss stays one along a direction of length 0
            distance[i] = is_hit ? hits[i].distance * glm::length(ways[i]) : hits[i].distance;
            voxel[i] = hits[i].voxel;
            normal[i] = vec3(0.0f);
            if (const int axis = static_cast<int>(hits[i].axis); is_hit && axis < 3)
                normal[i][axis] = ways[i][axis] < 0.0 ? 1.0f : -1.0f;
        }
    });
    return py::make_tuple(distances, voxels, normals);
}

void bind_voxel_trace(VoxelDagClass& type) {
    type.def(
        "trace", &trace_rays, "origins"_a, "directions"_a, "progress"_a,
        R"(origins and directions: float64 (k, 3), in metres. Returns distances in metres, (k,), infinite where nothing is
hit; voxels, uint32 (k, 3); and normals, float32 (k, 3), 0 where a ray began in a voxel. Releases the GIL. Cancelled.)");
}
} // namespace tyndall::bindings
