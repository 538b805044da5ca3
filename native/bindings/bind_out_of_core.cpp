// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes to files of voxel DAGs, part by part.
#include "bindings/arrays.hpp"
#include "bindings/paths.hpp"
#include "bindings/voxel_dag.hpp"
#include "bindings/voxel_surface.hpp"
#include "voxel_dag/out_of_core.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

/// With the arrays that it refers to.
struct HeldOutOfCore {
    py::array triangles;
    std::shared_ptr<VoxelSurface> surface;
    OutOfCore parts;
};

template <class Vector>
static OutOfCore out_of_core_of(const py::array& positions, std::span<const uvec3> triangles,
                                const OutOfCoreConfig& config, const Progress& progress) {
    const auto points = rows<Vector, typename Vector::value_type>(positions, {-1, 3}, "positions");
    return without_gil([&] { return OutOfCore(points, triangles, config, progress); });
}

static std::unique_ptr<HeldOutOfCore> made(const py::array& positions, const py::array& triangles,
                                           std::uint32_t resolution, VoxelizeRule rule,
                                           const std::optional<Bounds>& bounds, std::shared_ptr<VoxelSurface> surface,
                                           bool is_solid, Symmetry symmetry, const AttributeConfig& attribute_config,
                                           std::uint64_t memory_budget_bytes, std::uint32_t worker_count,
                                           const py::object& scratch_folder, const Progress& progress) {
    const auto corners = rows<uvec3, std::uint32_t>(triangles, {-1, 3}, "triangles");
    OutOfCoreConfig config{
        .voxels = {.resolution = resolution, .rule = rule, .memory_budget_bytes = memory_budget_bytes},
        .symmetry = symmetry,
        .is_solid = is_solid,
        .surface = surface->surface,
        .attributes = attribute_config,
        .worker_count = worker_count,
        .scratch_folder = path_of(scratch_folder)};
    if (bounds)
        config.voxels.bounds_m = cube_of(*bounds);
    const bool is_double = py::isinstance<py::array_t<double>>(positions);
    return std::make_unique<HeldOutOfCore>(triangles, std::move(surface),
                                           is_double ? out_of_core_of<dvec3>(positions, corners, config, progress)
                                                     : out_of_core_of<vec3>(positions, corners, config, progress));
}

void bind_out_of_core(py::module_& native) {
    py::class_<OutOfCoreStatistics>(native, "OutOfCoreStatistics", "What a voxel DAG's parts were.")
        .def_readonly("voxel_count", &OutOfCoreStatistics::voxel_count)
        .def_readonly("node_count", &OutOfCoreStatistics::node_count)
        .def_readonly("geometry_bytes", &OutOfCoreStatistics::geometry_bytes)
        .def_readonly("attribute_bytes", &OutOfCoreStatistics::attribute_bytes)
        .def_readonly("part_count", &OutOfCoreStatistics::part_count)
        .def_readonly("kept_part_count", &OutOfCoreStatistics::kept_part_count, "Parts that were finished before.")
        .def_readonly("part_bytes", &OutOfCoreStatistics::part_bytes)
        .def_readonly("join_pass_count", &OutOfCoreStatistics::join_pass_count)
        .def_readonly("damaged_parts", &OutOfCoreStatistics::damaged_parts, "Names of files that were made again.");
    py::class_<HeldOutOfCore>(native, "OutOfCoreVoxels", "A mesh that becomes a voxel DAG part by part.")
        .def(py::init(&made), "positions"_a, "triangles"_a, "resolution"_a, "rule"_a, "bounds"_a, "surface"_a,
             "is_solid"_a, "symmetry"_a, "attribute_config"_a, "memory_budget_bytes"_a, "worker_count"_a,
             "scratch_folder"_a, "progress"_a,
             R"(As voxelize() takes them; parts lie in a folder of their own in scratch_folder. Releases the GIL.
TypeError: dtype or shape; InvalidInput: a value; Cancelled.)")
        .def_property_readonly("part_count", [](const HeldOutOfCore& self) { return self.parts.part_count(); })
        .def(
            "part_path",
            [](const HeldOutOfCore& self, std::size_t part) { return self.parts.part_path(part).string(); }, "part"_a,
            "The file of a part below part_count.")
        .def(
            "make_part",
            [](const HeldOutOfCore& self, std::size_t part, const Progress& progress) {
                without_gil([&] { self.parts.make_part(part, progress); });
            },
            "part"_a, "progress"_a,
            "Make the file of a part below part_count, unless it is there. Releases the GIL. IoError; Cancelled.")
        .def(
            "finish",
            [](HeldOutOfCore& self, const py::object& path, Progress& progress) {
                const std::string name = path_of(path);
                return without_gil([&] { return self.parts.finish(name, progress); });
            },
            "path"_a, "progress"_a,
            "Make what is missing, join it, write the file, remove the parts. Releases the GIL. IoError; InvalidInput; "
            "Cancelled.");
}
} // namespace tyndall::bindings
