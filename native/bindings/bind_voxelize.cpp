// SPDX-License-Identifier: GPL-3.0-or-later
// What voxel DAGs are made of.
#include "bindings/arrays.hpp"
#include "bindings/voxel_dag.hpp"
#include "bindings/voxel_surface.hpp"
#include "voxel_dag/encode_attributes.hpp"
#include "voxel_dag/filled_shares.hpp"
#include "voxel_dag/listed_voxels.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/snapped_mesh.hpp"
#include "voxel_dag/solid_fill.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

std::shared_ptr<PlacedDag> packed(const LeafMasks& leaves, const VoxelAttributes& attributes, const Cube& bounds_m,
                                  const Storage& storage, const Progress& progress) {
    Dag dag = build_dag(leaves, {.memory_budget_bytes = storage.memory_budget_bytes}, progress);
    if (storage.symmetry != Symmetry::None)
        dag = merge_symmetric(dag, {.symmetry = storage.symmetry, .memory_budget_bytes = storage.memory_budget_bytes},
                              progress);
    auto placed = std::make_shared<PlacedDag>(pack_dag(dag, progress), bounds_m);
    if (!attributes.is_empty()) {
        AttributeConfig config = storage.attributes;
        config.memory_budget_bytes = storage.memory_budget_bytes;
        placed->attributes = encode_attributes(placed->dag, attributes, config, progress);
    }
    return placed;
}

/// The voxels of a mesh, what they carry, and the cube that they are of.
struct MeshVoxels {
    LeafMasks leaves;
    VoxelAttributes attributes;
    Cube cube;
};
template <class Vector>
static MeshVoxels voxels_of(const py::array& positions, std::span<const uvec3> triangles, const VoxelizeConfig& config,
                            const Surface& surface, bool is_solid, const Progress& progress) {
    const auto points = rows<Vector, typename Vector::value_type>(positions, {-1, 3}, "positions");
    return without_gil([&] {
        MeshVoxels voxels{.leaves = voxel_dag::voxelize(points, triangles, config, progress).leaves,
                          .attributes = {},
                          .cube = config.bounds_m ? *config.bounds_m : cube_around(points, triangles)};
        if (is_solid)
            voxels.leaves = solid_fill(points, triangles, config, voxels.leaves, progress);
        if (!surface.is_empty())
            voxels.attributes = surface_attributes(points, triangles, config, voxels.leaves, surface, progress);
        return voxels;
    });
}

static std::shared_ptr<PlacedDag>
voxelize_mesh(const py::array& positions, const py::array& triangles, std::uint32_t resolution, VoxelizeRule rule,
              const std::optional<Bounds>& bounds, const VoxelSurface& surface, bool is_solid, Symmetry symmetry,
              const AttributeConfig& attribute_config, std::uint64_t memory_budget_bytes, const Progress& progress) {
    const auto corners = rows<uvec3, std::uint32_t>(triangles, {-1, 3}, "triangles");
    VoxelizeConfig config{
        .resolution = resolution, .rule = rule, .bounds_m = {}, .memory_budget_bytes = memory_budget_bytes};
    if (bounds)
        config.bounds_m = cube_of(*bounds);
    const bool is_double = py::isinstance<py::array_t<double>>(positions);
    const MeshVoxels voxels = is_double
                                  ? voxels_of<dvec3>(positions, corners, config, surface.surface, is_solid, progress)
                                  : voxels_of<vec3>(positions, corners, config, surface.surface, is_solid, progress);
    return without_gil([&] {
        return packed(
            voxels.leaves, voxels.attributes, voxels.cube,
            {.symmetry = symmetry, .attributes = attribute_config, .memory_budget_bytes = memory_budget_bytes},
            progress);
    });
}

using NamedChannels = std::vector<std::pair<std::string, py::array>>;

static std::shared_ptr<PlacedDag> dag_of_voxels(const py::array& coordinates, std::uint32_t level, const Bounds& bounds,
                                                Symmetry symmetry, const std::optional<py::array>& colors,
                                                const std::optional<py::array>& normals, const NamedChannels& channels,
                                                const AttributeConfig& attribute_config,
                                                std::uint64_t memory_budget_bytes, const Progress& progress) {
    check_array<std::uint32_t>(coordinates, {-1, 3}, "coordinates");
    const auto count = static_cast<std::size_t>(coordinates.shape(0));
    const std::span voxels(static_cast<const Voxel*>(coordinates.data()), count);
    ListedAttributes attributes;
    if (colors) {
        check_array<std::uint8_t>(*colors, {coordinates.shape(0), 3}, "colors");
        attributes.colors = {static_cast<const ByteColor*>(colors->data()), count};
    }
    if (normals) {
        check_array<float>(*normals, {coordinates.shape(0), 3}, "normals");
        attributes.normals = {static_cast<const vec3*>(normals->data()), count};
    }
    for (const auto& [name, values] : channels) {
        check_array<std::uint8_t>(values, {coordinates.shape(0)}, name);
        attributes.channels.push_back({name, {static_cast<const std::uint8_t*>(values.data()), count}});
    }
    return without_gil([&] {
        const ListedVoxels listed = voxels_of_list(voxels, attributes, level, progress);
        return packed(
            listed.leaves, listed.attributes, cube_of(bounds),
            {.symmetry = symmetry, .attributes = attribute_config, .memory_budget_bytes = memory_budget_bytes},
            progress);
    });
}

static py::array_t<float> shares_filled(const py::array& positions, const py::array& triangles,
                                        const std::array<double, 3>& lower, const std::array<double, 3>& step,
                                        const std::array<std::uint32_t, 3>& counts, const Progress& progress) {
    const auto points = rows<vec3, float>(positions, {-1, 3}, "positions");
    const auto corners = rows<uvec3, std::uint32_t>(triangles, {-1, 3}, "triangles");
    const BoxLattice lattice{.lower_m = {lower[0], lower[1], lower[2]},
                             .step_m = {step[0], step[1], step[2]},
                             .counts = {counts[0], counts[1], counts[2]}};
    return to_numpy(without_gil([&] { return filled_shares(points, corners, lattice, progress); }),
                    {counts[0], counts[1], counts[2]});
}

void bind_voxelize(py::module_& native) {
    bind_voxel_surface(native);
    py::enum_<VoxelizeRule>(native, "VoxelizeRule")
        .value("THIN", VoxelizeRule::Thin)
        .value("CONSERVATIVE", VoxelizeRule::Conservative);
    py::enum_<Symmetry>(native, "VoxelSymmetry")
        .value("NONE", Symmetry::None)
        .value("REFLECTIONS", Symmetry::Reflections)
        .value("CUBE", Symmetry::Cube);
    py::class_<AttributeConfig>(native, "VoxelAttributeConfig", "How attributes are stored.")
        .def(py::init([](std::uint32_t color_count, double most_color_difference, std::uint32_t normal_bits) {
                 return AttributeConfig{.color_count = color_count,
                                        .most_color_difference = most_color_difference,
                                        .normal_bits = normal_bits};
             }),
             "color_count"_a, "most_color_difference"_a, "normal_bits"_a,
             "color_count and most_color_difference: 0 keeps all colors.");
    native.def(
        "voxelize", &voxelize_mesh, "positions"_a, "triangles"_a, "resolution"_a, "rule"_a, "bounds"_a, "surface"_a,
        "is_solid"_a, "symmetry"_a, "attribute_config"_a, "memory_budget_bytes"_a, "progress"_a,
        R"(positions: float32 or float64 (n, 3); triangles: uint32 (m, 3); bounds: lower corner and side of a cube, or None.
Releases the GIL. TypeError: dtype or shape; InvalidInput: a value; Cancelled.)");
    native.def(
        "filled_shares", &shares_filled, "positions"_a, "triangles"_a, "lower"_a, "step"_a, "counts"_a, "progress"_a,
        R"(positions: float32 (n, 3); triangles: uint32 (m, 3); gives float32 of shape counts. Releases the GIL. TypeError:
dtype or shape; InvalidInput: a value; Cancelled.)");
    native.def(
        "voxel_dag_of", &dag_of_voxels, "coordinates"_a, "level"_a, "bounds"_a, "symmetry"_a, "colors"_a, "normals"_a,
        "channels"_a, "attribute_config"_a, "memory_budget_bytes"_a, "progress"_a,
        R"(coordinates: uint32 (n, 3), below 2 ** level; bounds: lower corner and side of a cube; colors: uint8 (n, 3) or
None; normals: float32 (n, 3) or None; channels: names, and uint8 (n,) of each. Releases the GIL. TypeError: dtype or
shape; InvalidInput: a value; Cancelled.)");
}
} // namespace tyndall::bindings
