// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;

using ChannelLeaves = std::tuple<std::string, py::array, py::array>;

static std::shared_ptr<DensityGrid> make_grid(const std::vector<ChannelLeaves>& channels,
                                              const py::array& local_from_index, const Progress& progress) {
    constexpr py::ssize_t side = GridLeaves::side;
    check_array<double>(local_from_index, {4, 4}, "local_from_index");
    const auto* rows = static_cast<const double*>(local_from_index.data());
    std::vector<GridLeaves> leaves;
    for (const auto& [name, origins, values] : channels) {
        leaves.push_back(
            {.name = name,
             .origins = to_vector<glm::ivec3, std::int32_t>(origins, {-1, 3}, "leaf_origins"),
             .values = to_vector<float, float>(values, {origins.shape(0), side, side, side}, "leaf_values")});
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 4; ++column)
                leaves.back().local_from_index[column][row] = rows[row * 4 + column];
    }
    return without_gil([&] { return std::make_shared<DensityGrid>(leaves, progress); });
}

static VolumeInstance make_volume(std::string name, const std::shared_ptr<DensityGrid>& grid, std::uint32_t channel,
                                  std::uint32_t medium, const py::array& world_from_local, float density_scale) {
    return {.name = std::move(name),
            .grid = grid,
            .channel = channel,
            .medium_index = medium,
            .world_from_local = to_matrix<mat4, 4>(world_from_local, "world_from_local"),
            .density_scale = density_scale};
}

void bind_volumes(py::module_& native) {
    py::class_<DensityGrid, std::shared_ptr<DensityGrid>>(native, "DensityGrid",
                                                          "Sparse densities; keeps a copy of the voxels.")
        .def(
            py::init(&make_grid), "channels"_a, "local_from_index"_a, "progress"_a,
            R"(channels: one to four of (name, leaf_origins, leaf_values), int32 (n, 3) and float32 (n, 8, 8, 8), by x, y, z;
local_from_index: float64 (4, 4), voxels' centres to the object's space. Densities below 0 are 0. Releases the GIL.
TypeError: dtype or shape; InvalidInput: a value; Cancelled.)");
    py::class_<VolumeInstance>(native, "VolumeInstance")
        .def(py::init(&make_volume), "name"_a, "grid"_a, "channel"_a, "medium"_a, "world_from_local"_a,
             "density_scale"_a, "world_from_local: float32 (4, 4), relative to the scene's origin.");
}
} // namespace tyndall::bindings
