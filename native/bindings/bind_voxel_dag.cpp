// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/decode.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/voxelize.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

/// A DAG whose nodes stay where they are: what hands its voxels out refers to them.
struct VoxelDag {
    std::shared_ptr<const Dag> dag;
    std::uint64_t voxel_count;
};
struct VoxelParts {
    std::shared_ptr<const Dag> dag;
    Decoder decoder;
};

template <class Vector>
static LeafMasks leaves_of(const py::array& positions, std::span<const uvec3> triangles, const VoxelizeConfig& config,
                           const Progress& progress) {
    check_array<typename Vector::value_type>(positions, {-1, 3}, "positions");
    const std::span points(static_cast<const Vector*>(positions.data()), static_cast<std::size_t>(positions.shape(0)));
    return without_gil([&] { return voxel_dag::voxelize(points, triangles, config, progress).leaves; });
}

static VoxelDag voxelize_mesh(const py::array& positions, const py::array& triangles, std::uint32_t resolution,
                              VoxelizeRule rule, const std::optional<std::pair<std::array<double, 3>, double>>& bounds,
                              Symmetry symmetry, std::uint64_t memory_budget_bytes, const Progress& progress) {
    check_array<std::uint32_t>(triangles, {-1, 3}, "triangles");
    const std::span corners(static_cast<const uvec3*>(triangles.data()), static_cast<std::size_t>(triangles.shape(0)));
    VoxelizeConfig config{.resolution = resolution, .rule = rule};
    if (bounds)
        config.bounds_m = {.lower_m = dvec3(bounds->first[0], bounds->first[1], bounds->first[2]),
                           .side_m = bounds->second};
    const bool is_double = py::isinstance<py::array_t<double>>(positions);
    const LeafMasks leaves = is_double ? leaves_of<dvec3>(positions, corners, config, progress)
                                       : leaves_of<vec3>(positions, corners, config, progress);
    return without_gil([&] {
        Dag dag = build_dag(leaves, {.memory_budget_bytes = memory_budget_bytes}, progress);
        if (symmetry != Symmetry::None)
            dag = merge_symmetric(dag, {.symmetry = symmetry, .memory_budget_bytes = memory_budget_bytes}, progress);
        return VoxelDag{std::make_shared<const Dag>(std::move(dag)), leaves.voxel_count()};
    });
}

static py::array_t<bool> contains(const VoxelDag& self, const py::array& coordinates) {
    check_array<std::uint32_t>(coordinates, {-1, 3}, "coordinates");
    py::array_t<bool> found(coordinates.shape(0));
    const auto* voxels = static_cast<const Voxel*>(coordinates.data());
    bool* const results = found.mutable_data();
    const auto count = static_cast<std::size_t>(coordinates.shape(0));
    without_gil([&] {
        for (std::size_t i = 0; i < count; ++i)
            results[i] = self.dag->contains(voxels[i]);
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

static std::uint64_t geometry_bytes(const VoxelDag& self) {
    std::uint64_t bytes = self.dag->leaves.size() * sizeof(std::uint64_t);
    for (const DagLevel& level : self.dag->levels)
        bytes += level.child_masks.size() + level.first_children.size() * sizeof(std::uint32_t) +
                 level.children.size() * sizeof(std::uint32_t) + level.tags.size();
    return bytes;
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
    py::class_<VoxelDag>(native, "VoxelDag", "Immutable; for any number of threads.")
        .def_property_readonly("resolution", [](const VoxelDag& self) { return self.dag->resolution(); })
        .def_readonly("voxel_count", &VoxelDag::voxel_count)
        .def_property_readonly("node_count", [](const VoxelDag& self) { return self.dag->node_count(); })
        .def_property_readonly("geometry_bytes", &geometry_bytes)
        .def("contains", &contains, "coordinates"_a, "coordinates: uint32 (k, 3). Releases the GIL.")
        .def("coordinates", [](const VoxelDag& self) {
            return VoxelParts{self.dag, Decoder(*self.dag)};
        });
    native.def(
        "voxelize", &voxelize_mesh, "positions"_a, "triangles"_a, "resolution"_a, "rule"_a, "bounds"_a, "symmetry"_a,
        "memory_budget_bytes"_a, "progress"_a,
        R"(positions: float32 or float64 (n, 3); triangles: uint32 (m, 3); bounds: lower corner and side of a cube, or None.
Releases the GIL. TypeError: dtype or shape; InvalidInput: a value; Cancelled.)");
}
} // namespace tyndall::bindings
