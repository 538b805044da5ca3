// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/paths.hpp"
#include "bindings/voxel_dag.hpp"
#include "voxel_dag/decode.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

struct VoxelParts {
    std::shared_ptr<const PlacedDag> placed; ///< What the decoder refers to.
    Decoder<PackedDag> decoder;
};

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

/// The cubes of a level as voxels, with their mean colours.
static std::shared_ptr<PlacedDag> read_coarse(const std::string& path, std::uint32_t level, const Progress& progress) {
    std::optional<TopOfDag> top = read_top(path, level, progress);
    if (!top) {
        const PlacedDag whole = read_dag(path, progress);
        if (level >= whole.dag.level || whole.dag.is_empty())
            return std::make_shared<PlacedDag>(whole);
        const DagAttributes* const carried = whole.attributes.get();
        const auto colors = [&](std::span<const Voxel> lowest, std::uint32_t side_level) {
            const bool has_them = carried != nullptr && carried->layout().has_colors &&
                                  (side_level < least_mean_level || carried->has_means());
            return has_them ? colors_at(whole.dag, *carried, lowest, side_level, progress) : std::vector<ByteColor>();
        };
        top = TopOfDag{.bounds_m = whole.bounds_m,
                       .levels = top_levels_of(whole.dag, colors, {.most_level = level}, progress)};
    }
    VoxelAttributes attributes;
    for (const auto& [red, green, blue] : top->levels.back().colors)
        attributes.colors.push_back(red | std::uint32_t{green} << 8 | std::uint32_t{blue} << 16);
    return packed(voxels_of(top->levels), attributes, top->bounds_m,
                  {.symmetry = Symmetry::Cube, .attributes = {}, .memory_budget_bytes = ~std::uint64_t{0}}, progress);
}

void bind_voxel_dag(py::module_& native) {
    py::class_<VoxelParts>(native, "VoxelParts", "uint32 (k, 3), x, y and z of voxels in Morton order, part by part.")
        .def("__iter__", [](VoxelParts& self) -> VoxelParts& { return self; })
        .def("__next__", &next_voxels);
    VoxelDagClass type(native, "VoxelDag", "Immutable; for any number of threads.");
    type.def_property_readonly("resolution", [](const PlacedDag& self) { return std::uint64_t{1} << self.dag.level; })
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
            "save",
            [](const PlacedDag& self, const py::object& path, const Progress& progress) {
                const std::string name = path_of(path);
                without_gil([&] { write_dag(self, name, progress); });
            },
            "path"_a, "progress"_a, "Releases the GIL. IoError: the path and why; Cancelled.");
    bind_voxel_counts(native, type);
    bind_voxel_preview(type);
    bind_voxel_trace(type);
    bind_voxel_export(type);
    bind_voxel_attributes(type);
    bind_voxelize(native);
    bind_voxel_files(native, type);
    bind_out_of_core(native);
    native.def(
        "load_voxel_dag_top",
        [](const py::object& path, std::uint32_t level, const Progress& progress) {
            const std::string name = path_of(path);
            return without_gil([&] { return read_coarse(name, level, progress); });
        },
        "path"_a, "level"_a, "progress"_a,
        "2 ** level cubes a side. Releases the GIL. IoError: the path and what is wrong with it; Cancelled.");
    native.def(
        "load_voxel_dag",
        [](const py::object& path, const Progress& progress) {
            const std::string name = path_of(path);
            return without_gil([&] { return std::make_shared<PlacedDag>(read_dag(name, progress)); });
        },
        "path"_a, "progress"_a, "Releases the GIL. IoError: the path and what is wrong with it; Cancelled.");
    native.def(
        "load_voxel_geometry",
        [](const py::object& path, const Progress& progress) {
            const std::string name = path_of(path);
            return without_gil([&] { return std::make_shared<PlacedDag>(read_dag(name, progress, false)); });
        },
        "path"_a, "progress"_a, "Without attributes. Releases the GIL. IoError: as load_voxel_dag(); Cancelled.");
}
} // namespace tyndall::bindings
