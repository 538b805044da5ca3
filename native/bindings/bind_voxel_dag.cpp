// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "bindings/paths.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/dag_file.hpp"
#include "voxel_dag/decode.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/snapped_mesh.hpp"
#include "voxel_dag/trace.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

struct VoxelParts {
    std::shared_ptr<const PlacedDag> placed; ///< What the decoder refers to.
    Decoder<PackedDag> decoder;
};

using Bounds = std::pair<std::array<double, 3>, double>; ///< Lower corner and side.
static Cube cube_of(const Bounds& bounds) {
    const auto& [lower_m, side_m] = bounds;
    return {.lower_m = dvec3(lower_m[0], lower_m[1], lower_m[2]), .side_m = side_m};
}

static std::shared_ptr<PlacedDag> packed(const LeafMasks& leaves, const Cube& bounds_m, Symmetry symmetry,
                                         std::uint64_t memory_budget_bytes, const Progress& progress) {
    Dag dag = build_dag(leaves, {.memory_budget_bytes = memory_budget_bytes}, progress);
    if (symmetry != Symmetry::None)
        dag = merge_symmetric(dag, {.symmetry = symmetry, .memory_budget_bytes = memory_budget_bytes}, progress);
    return std::make_shared<PlacedDag>(pack_dag(dag, progress), bounds_m);
}

/// The voxels of a mesh, and the cube that they are of.
template <class Vector>
static std::pair<LeafMasks, Cube> voxels_of(const py::array& positions, std::span<const uvec3> triangles,
                                            const VoxelizeConfig& config, const Progress& progress) {
    check_array<typename Vector::value_type>(positions, {-1, 3}, "positions");
    const std::span points(static_cast<const Vector*>(positions.data()), static_cast<std::size_t>(positions.shape(0)));
    return without_gil([&] {
        LeafMasks leaves = voxel_dag::voxelize(points, triangles, config, progress).leaves;
        return std::pair(std::move(leaves), config.bounds_m ? *config.bounds_m : cube_around(points, triangles));
    });
}

static std::shared_ptr<PlacedDag> voxelize_mesh(const py::array& positions, const py::array& triangles,
                                                std::uint32_t resolution, VoxelizeRule rule,
                                                const std::optional<Bounds>& bounds, Symmetry symmetry,
                                                std::uint64_t memory_budget_bytes, const Progress& progress) {
    check_array<std::uint32_t>(triangles, {-1, 3}, "triangles");
    const std::span corners(static_cast<const uvec3*>(triangles.data()), static_cast<std::size_t>(triangles.shape(0)));
    VoxelizeConfig config{
        .resolution = resolution, .rule = rule, .bounds_m = {}, .memory_budget_bytes = memory_budget_bytes};
    if (bounds)
        config.bounds_m = cube_of(*bounds);
    const bool is_double = py::isinstance<py::array_t<double>>(positions);
    const auto [leaves, cube] = is_double ? voxels_of<dvec3>(positions, corners, config, progress)
                                          : voxels_of<vec3>(positions, corners, config, progress);
    return without_gil([&] { return packed(leaves, cube, symmetry, memory_budget_bytes, progress); });
}

static std::shared_ptr<PlacedDag> dag_of_voxels(const py::array& coordinates, std::uint32_t level, const Bounds& bounds,
                                                Symmetry symmetry, std::uint64_t memory_budget_bytes,
                                                const Progress& progress) {
    auto voxels = to_vector<Voxel, std::uint32_t>(coordinates, {-1, 3}, "coordinates");
    return without_gil([&] {
        return packed(leaf_masks_of(std::move(voxels), level), cube_of(bounds), symmetry, memory_budget_bytes,
                      progress);
    });
}

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

static py::array_t<bool> contains(const PlacedDag& self, const py::array& coordinates) {
    check_array<std::uint32_t>(coordinates, {-1, 3}, "coordinates");
    py::array_t<bool> found(coordinates.shape(0));
    const auto* voxels = static_cast<const Voxel*>(coordinates.data());
    bool* const results = found.mutable_data();
    const auto count = static_cast<std::size_t>(coordinates.shape(0));
    without_gil([&] {
        for (std::size_t i = 0; i < count; ++i)
            results[i] = self.dag.contains(voxels[i]);
    });
    return found;
}

static py::array_t<std::uint32_t> next_voxels(VoxelParts& parts) {
    constexpr std::size_t bricks_at_once = 1 << 16;
    std::vector<std::uint32_t> coordinates;
    without_gil([&] {
        LeafMasks leaves;
        parts.decoder.next(bricks_at_once, leaves);
        coordinates.reserve(3 * leaves.voxel_count());
        for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick)
            for (std::uint64_t left = leaves.masks[brick]; left != 0; left &= left - 1) {
                const auto bit = static_cast<std::uint64_t>(std::countr_zero(left));
                const Voxel voxel = voxel_at(leaves.codes[brick] << 3 * leaf_level | bit);
                coordinates.insert(coordinates.end(), voxel.begin(), voxel.end());
            }
    });
    if (coordinates.empty())
        throw py::stop_iteration();
    const auto count = static_cast<py::ssize_t>(coordinates.size() / 3);
    return to_numpy(std::move(coordinates), {count, 3});
}

void bind_voxel_dag(py::module_& native) {
    py::enum_<VoxelizeRule>(native, "VoxelizeRule")
        .value("THIN", VoxelizeRule::Thin)
        .value("CONSERVATIVE", VoxelizeRule::Conservative);
    py::enum_<Symmetry>(native, "VoxelSymmetry")
        .value("NONE", Symmetry::None)
        .value("REFLECTIONS", Symmetry::Reflections)
        .value("CUBE", Symmetry::Cube);
    py::class_<VoxelParts>(native, "VoxelParts", "uint32 (k, 3), x, y and z of voxels in Morton order, part by part.")
        .def("__iter__", [](VoxelParts& self) -> VoxelParts& { return self; })
        .def("__next__", &next_voxels);
    py::class_<PlacedDag, std::shared_ptr<PlacedDag>>(native, "VoxelDag", "Immutable; for any number of threads.")
        .def_property_readonly("resolution", [](const PlacedDag& self) { return std::uint64_t{1} << self.dag.level; })
        .def_property_readonly("voxel_count", [](const PlacedDag& self) { return self.dag.voxel_count; })
        .def_property_readonly("node_count", [](const PlacedDag& self) { return self.dag.node_count; })
        .def_property_readonly("geometry_bytes", [](const PlacedDag& self) { return self.dag.byte_count(); })
        .def_property_readonly(
            "bounds_m",
            [](const PlacedDag& self) {
                const dvec3& lower_m = self.bounds_m.lower_m;
                return std::pair(std::array{lower_m.x, lower_m.y, lower_m.z}, self.bounds_m.side_m);
            },
            "Lower corner and side of the cube.")
        .def("contains", &contains, "coordinates"_a, "coordinates: uint32 (k, 3). Releases the GIL.")
        .def("coordinates",
             [](const std::shared_ptr<PlacedDag>& self) {
                 return VoxelParts{self, Decoder<PackedDag>(self->dag)};
             })
        .def(
            "trace", &trace_rays, "origins"_a, "directions"_a, "progress"_a,
            R"(origins and directions: float64 (k, 3), in metres. Returns distances in metres, (k,), infinite where nothing is
hit; voxels, uint32 (k, 3); and normals, float32 (k, 3), 0 where a ray began in a voxel. Releases the GIL. Cancelled.)")
        .def(
            "save",
            [](const PlacedDag& self, const py::object& path, const Progress& progress) {
                const std::string name = path_of(path);
                without_gil([&] { write_dag(self.dag, self.bounds_m, name, progress); });
            },
            "path"_a, "progress"_a, "Releases the GIL. IoError: the path and why; Cancelled.");
    native.def(
        "load_voxel_dag",
        [](const py::object& path, const Progress& progress) {
            const std::string name = path_of(path);
            return without_gil([&] { return std::make_shared<PlacedDag>(read_dag(name, progress)); });
        },
        "path"_a, "progress"_a, "Releases the GIL. IoError: the path and what is wrong with it; Cancelled.");
    native.def(
        "voxelize", &voxelize_mesh, "positions"_a, "triangles"_a, "resolution"_a, "rule"_a, "bounds"_a, "symmetry"_a,
        "memory_budget_bytes"_a, "progress"_a,
        R"(positions: float32 or float64 (n, 3); triangles: uint32 (m, 3); bounds: lower corner and side of a cube, or None.
Releases the GIL. TypeError: dtype or shape; InvalidInput: a value; Cancelled.)");
    native.def(
        "voxel_dag_of", &dag_of_voxels, "coordinates"_a, "level"_a, "bounds"_a, "symmetry"_a, "memory_budget_bytes"_a,
        "progress"_a,
        R"(coordinates: uint32 (n, 3), below 2 ** level; bounds: lower corner and side of a cube. Releases the GIL.
TypeError: dtype or shape; InvalidInput: a value; Cancelled.)");
}
} // namespace tyndall::bindings
