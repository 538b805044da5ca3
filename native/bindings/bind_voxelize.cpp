// SPDX-License-Identifier: GPL-3.0-or-later
// What voxel DAGs are made of.
#include "bindings/arrays.hpp"
#include "bindings/voxel_dag.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/snapped_mesh.hpp"
#include "voxel_dag/voxel_attributes.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

/// attributes: of the voxels of leaves, or none.
static std::shared_ptr<PlacedDag> packed(const LeafMasks& leaves, const VoxelAttributes& attributes,
                                         const Cube& bounds_m, Symmetry symmetry, std::uint64_t memory_budget_bytes,
                                         const Progress& progress) {
    require(attributes.is_empty(), "voxel DAG: attributes cannot be kept yet");
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
    return without_gil([&] { return packed(leaves, {}, cube, symmetry, memory_budget_bytes, progress); });
}

static std::shared_ptr<PlacedDag> dag_of_voxels(const py::array& coordinates, std::uint32_t level, const Bounds& bounds,
                                                Symmetry symmetry, std::uint64_t memory_budget_bytes,
                                                const Progress& progress) {
    auto voxels = to_vector<Voxel, std::uint32_t>(coordinates, {-1, 3}, "coordinates");
    return without_gil([&] {
        return packed(leaf_masks_of(std::move(voxels), level), {}, cube_of(bounds), symmetry, memory_budget_bytes,
                      progress);
    });
}

void bind_voxelize(py::module_& native) {
    py::enum_<VoxelizeRule>(native, "VoxelizeRule")
        .value("THIN", VoxelizeRule::Thin)
        .value("CONSERVATIVE", VoxelizeRule::Conservative);
    py::enum_<Symmetry>(native, "VoxelSymmetry")
        .value("NONE", Symmetry::None)
        .value("REFLECTIONS", Symmetry::Reflections)
        .value("CUBE", Symmetry::Cube);
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
