// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/voxel_dag.hpp"
#include "voxel_dag/coarse_cubes.hpp"

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

static std::pair<py::array_t<std::uint32_t>, std::uint32_t> coarse(const PlacedDag& self, std::uint32_t level,
                                                                   std::uint64_t most_cubes, const Progress& progress) {
    std::vector<std::uint32_t> coordinates;
    const std::uint32_t found = without_gil([&] {
        const CoarseCubes cubes = coarse_cubes(self.dag, level, most_cubes, progress);
        coordinates.reserve(3 * cubes.codes.size());
        for (const std::uint64_t code : cubes.codes) {
            const Voxel cube = voxel_at(code);
            coordinates.insert(coordinates.end(), cube.begin(), cube.end());
        }
        return cubes.level;
    });
    const auto count = static_cast<py::ssize_t>(coordinates.size() / 3);
    return {to_numpy(std::move(coordinates), {count, 3}), found};
}

void bind_voxel_preview(VoxelDagClass& type) {
    type.def("coarse_cubes", &coarse, "level"_a, "most_cubes"_a, "progress"_a,
             "uint32 (k, 3), and their level. Releases the GIL. Cancelled.");
}
} // namespace tyndall::bindings
