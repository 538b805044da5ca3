// SPDX-License-Identifier: GPL-3.0-or-later
// Rays through voxel DAGs.
#include "bindings/arrays.hpp"
#include "bindings/voxel_dag.hpp"
#include "voxel_dag/smooth_normals.hpp"
#include "voxel_dag/trace.hpp"
#include <algorithm>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

/// What rays are given by: float64, in metres.
struct RaysM {
    RaysM(const py::array& from, const py::array& along, const py::array& last, const char* last_name)
        : count(static_cast<std::size_t>(from.shape(0))) {
        check_array<double>(from, {-1, 3}, "origins");
        check_array<double>(along, {from.shape(0), 3}, "directions");
        check_array<double>(last, {from.shape(0)}, last_name);
        origins = static_cast<const dvec3*>(from.data());
        directions = static_cast<const dvec3*>(along.data());
        numbers = static_cast<const double*>(last.data());
    }
    /// One number per ray goes where `set` puts it.
    template <class Set>
    [[nodiscard]] std::vector<VoxelRay> in_voxels(const PlacedDag& placed, const Set& set) const {
        const double per_m = static_cast<double>(std::uint64_t{1} << placed.dag.level) / placed.bounds_m.side_m;
        std::vector<VoxelRay> rays(count);
        for (std::size_t i = 0; i < count; ++i) {
            rays[i] = {.origin = (origins[i] - placed.bounds_m.lower_m) * per_m, .direction = directions[i] * per_m};
            set(rays[i], numbers[i], glm::length(directions[i]), per_m);
        }
        return rays;
    }
    std::size_t count;
    const dvec3 *origins, *directions;
    const double* numbers;
};

static py::tuple trace_rays(const PlacedDag& self, const py::array& origins, const py::array& directions,
                            std::uint32_t level, const py::array& spreads, const Progress& progress) {
    const RaysM given(origins, directions, spreads, "spreads");
    py::array_t<double> distances(origins.shape(0));
    py::array_t<std::uint32_t> voxels({origins.shape(0), py::ssize_t{3}});
    py::array_t<float> normals({origins.shape(0), py::ssize_t{3}});
    double* const distance = distances.mutable_data();
    auto* const voxel = reinterpret_cast<Voxel*>(voxels.mutable_data());
    auto* const normal = reinterpret_cast<vec3*>(normals.mutable_data());
    without_gil([&] {
        require(0 < level && level <= self.dag.level, "voxel DAG: level is ", level, ", not in [1, ", self.dag.level,
                "]");
        const double width = static_cast<double>(std::uint64_t{1} << (self.dag.level - level));
        const std::vector<VoxelRay> rays =
            given.in_voxels(self, [&](VoxelRay& ray, double spread, double length_m, double per_m) {
                ray.width = width;
                ray.spread = spread * length_m * per_m;
            });
        std::vector<VoxelHit> hits(rays.size());
        trace(self.dag, rays, hits, progress);
        for (std::size_t i = 0; i < hits.size(); ++i) {
            const bool is_hit = hits[i].is_hit(); // a miss stays one along a direction of length 0
            distance[i] = is_hit ? hits[i].distance * glm::length(given.directions[i]) : hits[i].distance;
            voxel[i] = hits[i].voxel;
            normal[i] = vec3(0.0f);
            if (const int axis = static_cast<int>(hits[i].axis); is_hit && axis < 3)
                normal[i][axis] = given.directions[i][axis] < 0.0 ? 1.0f : -1.0f;
        }
    });
    return py::make_tuple(distances, voxels, normals);
}

static py::array_t<bool> occluded_rays(const PlacedDag& self, const py::array& origins, const py::array& directions,
                                       const py::array& ends, const Progress& progress) {
    const RaysM given(origins, directions, ends, "ends");
    py::array_t<bool> found(origins.shape(0));
    bool* const are_occluded = found.mutable_data();
    without_gil([&] {
        const std::vector<VoxelRay> rays = given.in_voxels(
            self, [](VoxelRay& ray, double end_m, double length_m, double) { ray.end = end_m / length_m; });
        find_occluded(self.dag, rays, {are_occluded, rays.size()}, progress);
    });
    return found;
}

static py::array_t<float> normals_of(const PlacedDag& self, const py::array& coordinates, const py::array& directions,
                                     std::uint32_t radius, const Progress& progress) {
    const auto voxels = to_vector<Voxel, std::uint32_t>(coordinates, {-1, 3}, "coordinates");
    const auto along = to_vector<dvec3, double>(directions, {-1, 3}, "directions");
    py::array_t<float> rows({coordinates.shape(0), py::ssize_t{3}});
    auto* const normals = reinterpret_cast<vec3*>(rows.mutable_data());
    without_gil([&] {
        std::ranges::copy(smooth_normals::find(self.dag, voxels, along, {.radius = radius}, progress), normals);
    });
    return rows;
}

void bind_voxel_trace(VoxelDagClass& type) {
    type.def(
            "trace", &trace_rays, "origins"_a, "directions"_a, "level"_a, "spreads"_a, "progress"_a,
            R"(origins and directions: float64 (k, 3), in metres; spreads: float64 (k,). Cubes of 2^-level of the whole, or no
wider than spread times their distance, are hit whole. Returns distances in metres, (k,), infinite where nothing is hit;
voxels, uint32 (k, 3), the lowest of each cube; and normals, float32 (k, 3), 0 where a ray began in a voxel. Releases the
GIL. InvalidInput: a level that is not there; Cancelled.)")
        .def("occluded", &occluded_rays, "origins"_a, "directions"_a, "ends"_a, "progress"_a,
             "ends: float64 (k,), in metres. Whether a voxel begins before, (k,). Releases the GIL. Cancelled.")
        .def("smooth_normals", &normals_of, "coordinates"_a, "directions"_a, "radius"_a, "progress"_a,
             "coordinates: uint32 (k, 3); directions: float64, as many or none. float32 (k, 3). Releases the GIL. "
             "InvalidInput, Cancelled.");
}
} // namespace tyndall::bindings
