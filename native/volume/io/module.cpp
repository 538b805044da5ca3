// SPDX-License-Identifier: GPL-3.0-or-later
// The module tyndall._volume_io: numpy arrays to OpenVDB files and back. Converts and nothing else.
#include "bindings/arrays.hpp"
#include "bindings/paths.hpp"
#include "volume/io/voxel_grids.hpp"
#include <pybind11/stl.h>

namespace tyndall::volume_io {
namespace py = pybind11;
using namespace py::literals;
using bindings::path_of;

static py::object to_array(const std::optional<Matrix>& matrix) {
    if (!matrix)
        return py::none();
    return bindings::to_numpy(std::vector<double>(matrix->begin(), matrix->end()), {4, 4});
}

static py::tuple list_grids(const py::object& path, const Progress& progress) {
    const std::string file = path_of(path);
    const FileInfo info = bindings::without_gil([&] { return list(file, progress); });
    py::list grids;
    for (const GridInfo& grid : info.grids)
        grids.append(py::dict("name"_a = grid.name, "value_type"_a = grid.value_type, "grid_class"_a = grid.grid_class,
                              "is_half"_a = grid.is_half, "active_voxel_count"_a = grid.active_voxel_count,
                              "first_index"_a = py::tuple(py::cast(grid.first_index)),
                              "last_index"_a = py::tuple(py::cast(grid.last_index)),
                              "local_from_index"_a = to_array(grid.local_from_index), "refusal"_a = grid.refusal));
    return py::make_tuple(grids, info.metadata);
}

static py::list read_grids(const py::object& path, const std::optional<std::vector<std::string>>& names,
                           std::size_t memory_limit_bytes, Progress& progress) {
    const std::string file = path_of(path);
    std::vector<Grid> grids = bindings::without_gil([&] { return read(file, names, memory_limit_bytes, progress); });
    py::list arrays;
    for (Grid& grid : grids) {
        const auto leaf_count = static_cast<py::ssize_t>(grid.leaf_origins.size());
        py::array_t<std::int32_t> origins({leaf_count, py::ssize_t{3}});
        std::copy_n(grid.leaf_origins.data()->data(), grid.leaf_origins.size() * 3, origins.mutable_data());
        arrays.append(py::make_tuple(grid.name, origins,
                                     bindings::to_numpy(std::move(grid.leaf_values), {leaf_count, 8, 8, 8}),
                                     to_array(grid.local_from_index), grid.background));
    }
    return arrays;
}

using NamedLeaves = std::tuple<std::string, py::array, py::array, py::array, float>;

static void write_grids(const py::object& path, const std::vector<NamedLeaves>& grids, bool is_half,
                        const Metadata& metadata, Progress& progress) {
    std::vector<GridView> views;
    for (const auto& [name, origins, values, local_from_index, background] : grids) {
        const std::string named = "grid \"" + name + "\": ";
        bindings::check_array<std::int32_t>(origins, {-1, 3}, named + "leaf_origins");
        bindings::check_array<float>(values, {origins.shape(0), 8, 8, 8}, named + "leaf_values");
        bindings::check_array<double>(local_from_index, {4, 4}, named + "local_from_index");
        GridView& view = views.emplace_back();
        view.name = name;
        view.leaf_origins = {static_cast<const VoxelIndex*>(origins.data()),
                             static_cast<std::size_t>(origins.shape(0))};
        view.leaf_values = {static_cast<const float*>(values.data()), static_cast<std::size_t>(values.size())};
        std::copy_n(static_cast<const double*>(local_from_index.data()), view.local_from_index.size(),
                    view.local_from_index.begin());
        view.background = background;
    }
    const std::string file = path_of(path);
    bindings::without_gil(
        [&] { write(file, views, is_half ? Precision::Half : Precision::Float, metadata, progress); });
}

static VoxelBits to_voxels(const py::array& leaf_origins, const py::array& leaf_words) {
    bindings::check_array<std::int32_t>(leaf_origins, {-1, 3}, "leaf_origins");
    bindings::check_array<std::uint64_t>(leaf_words, {leaf_origins.shape(0), 8}, "leaf_words");
    return {.leaf_origins = {static_cast<const VoxelIndex*>(leaf_origins.data()),
                             static_cast<std::size_t>(leaf_origins.shape(0))},
            .leaf_words = {static_cast<const std::uint64_t*>(leaf_words.data()),
                           static_cast<std::size_t>(leaf_words.size())}};
}

static void write_voxel_grid(const py::object& path, const std::string& name, const py::array& leaf_origins,
                             const py::array& leaf_words, const py::array& local_from_index, VoxelGridKind kind,
                             const std::optional<std::pair<std::string, py::array>>& named_colors,
                             const Metadata& metadata, const Progress& progress) {
    VoxelBits voxels = to_voxels(leaf_origins, leaf_words);
    bindings::check_array<double>(local_from_index, {4, 4}, "local_from_index");
    std::copy_n(static_cast<const double*>(local_from_index.data()), voxels.local_from_index.size(),
                voxels.local_from_index.begin());
    std::optional<VoxelColors> colors;
    if (named_colors) {
        const auto& [color_name, linear] = *named_colors;
        bindings::check_array<float>(linear, {-1, 3}, "colors");
        colors = VoxelColors{
            color_name,
            {static_cast<const std::array<float, 3>*>(linear.data()), static_cast<std::size_t>(linear.shape(0))}};
    }
    const std::string file = path_of(path);
    bindings::without_gil([&] { write_voxels(file, name, voxels, kind, colors, metadata, progress); });
}

static py::tuple smooth_mesh(const py::array& leaf_origins, const py::array& leaf_words, const Progress& progress) {
    const VoxelBits voxels = to_voxels(leaf_origins, leaf_words);
    const SmoothMesh mesh = bindings::without_gil([&] { return smooth_mesh_of(voxels, progress); });
    py::array_t<float> positions({static_cast<py::ssize_t>(mesh.positions.size()), py::ssize_t{3}});
    std::copy_n(mesh.positions.data()->data(), mesh.positions.size() * 3, positions.mutable_data());
    py::array_t<std::uint32_t> triangles({static_cast<py::ssize_t>(mesh.triangles.size()), py::ssize_t{3}});
    std::copy_n(mesh.triangles.data()->data(), mesh.triangles.size() * 3, triangles.mutable_data());
    return py::make_tuple(positions, triangles);
}

PYBIND11_MODULE(_volume_io, module) {
    module.doc() = "OpenVDB files in and out, as leaves of 8 x 8 x 8 floats.";
    py::module_::import("tyndall._native"); // Progress, InvalidInput, IoError and Cancelled are its classes
    module.attr("openvdb_version") = library_version();
    module.def("list_grids", &list_grids, "path"_a, "progress"_a,
               R"(A dictionary per grid, and the file's metadata as text, without reading voxels. Releases the GIL.

local_from_index: float64 (4, 4), or None for a frustum. refusal: why read_grids would refuse it, or "". last_index is
below first_index in a grid without active voxels. IoError names path and grid; Cancelled.)");
    module.def(
        "read_grids", &read_grids, "path"_a, "names"_a, "memory_limit_bytes"_a, "progress"_a,
        R"(Name, leaf origins int32 (n, 3), values float32 (n, 8, 8, 8), local_from_index float64 (4, 4) and background
of each grid named, or of all that can be read. Releases the GIL.

Leaves ascend by origin. IoError and InvalidInput name path and grid; Cancelled.)");
    module.def("write_grids", &write_grids, "path"_a, "grids"_a, "is_half"_a, "metadata"_a, "progress"_a,
               R"(Write grids, given as read_grids returns them, whole or not at all. Releases the GIL.

TypeError: dtype or shape; IoError and InvalidInput name path and grid; Cancelled.)");
    py::enum_<VoxelGridKind>(module, "VoxelGridKind")
        .value("FOG", VoxelGridKind::Fog)
        .value("LEVEL_SET", VoxelGridKind::LevelSet);
    module.def(
        "write_voxel_grid", &write_voxel_grid, "path"_a, "name"_a, "leaf_origins"_a, "leaf_words"_a,
        "local_from_index"_a, "kind"_a, "colors"_a, "metadata"_a, "progress"_a,
        R"(Write voxels that are set as one grid, and their colours as another, whole or not at all. Releases the GIL.

leaf_origins: int32 (n, 3); leaf_words: uint64 (n, 8), bit 8 y + z of word x; local_from_index: float64 (4, 4); colors:
None, or a grid's name and float32 (k, 3), a row for each voxel, leaf by leaf, x slowest and z fastest.
TypeError: dtype or shape; IoError and InvalidInput name path and grid; Cancelled.)");
    module.def(
        "smooth_mesh", &smooth_mesh, "leaf_origins"_a, "leaf_words"_a, "progress"_a,
        R"(Positions, float32 (p, 3), in indices of voxels' centres, and triangles, uint32 (m, 3). Releases the GIL.

leaf_origins and leaf_words as write_voxel_grid takes them. TypeError: dtype or shape; InvalidInput; Cancelled.)");
}
} // namespace tyndall::volume_io
