// SPDX-License-Identifier: GPL-3.0-or-later
// Voxel DAGs as what other programs read.
#include "bindings/arrays.hpp"
#include "bindings/paths.hpp"
#include "bindings/voxel_dag.hpp"
#include "voxel_dag/box_mesh.hpp"
#include "voxel_dag/coarse_voxels.hpp"
#include "voxel_dag/leaf_blocks.hpp"

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

/// Hands rows of numbers over to numpy without a copy; the array owns them.
template <typename Scalar, typename Row>
static py::array_t<Scalar> to_rows(std::vector<Row> rows) {
    auto owner = std::make_unique<std::vector<Row>>(std::move(rows));
    const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(owner->size()), sizeof(Row) / sizeof(Scalar)};
    const auto* const first = reinterpret_cast<const Scalar*>(owner->data());
    const py::capsule capsule(owner.get(), [](void* vector) { delete static_cast<std::vector<Row>*>(vector); });
    owner.release();
    return py::array_t<Scalar>(shape, first, capsule);
}

static py::tuple box_mesh(const PlacedDag& self, std::uint32_t level, std::uint64_t memory_budget_bytes,
                          const Progress& progress) {
    BoxMesh mesh = without_gil([&] {
        return box_mesh_of(coarse_voxels(self.dag, level, memory_budget_bytes, progress), memory_budget_bytes,
                           progress);
    });
    const auto square_count = static_cast<py::ssize_t>(mesh.voxel_numbers.size());
    return py::make_tuple(to_rows<double>(std::move(mesh.positions)), to_rows<std::uint32_t>(std::move(mesh.triangles)),
                          to_numpy(std::move(mesh.voxel_numbers), {square_count}));
}

static py::tuple leaf_blocks(const PlacedDag& self, std::uint32_t level, std::uint64_t memory_budget_bytes,
                             const Progress& progress) {
    LeafBlocks blocks = without_gil(
        [&] { return leaf_blocks_of(coarse_voxels(self.dag, level, memory_budget_bytes, progress), progress); });
    return py::make_tuple(to_rows<std::uint32_t>(std::move(blocks.origins)),
                          to_rows<std::uint64_t>(std::move(blocks.bits)));
}

void bind_voxel_export(VoxelDagClass& type) {
    type.def("box_mesh", &box_mesh, "level"_a, "memory_budget_bytes"_a, "progress"_a,
             R"(Of cubes of 2 ** level voxels: positions in cubes, float64 (p, 3); triangles, uint32 (2 m, 3); and each
square's cube, counted in Morton order, uint32 (m,). Releases the GIL. InvalidInput: the budget; Cancelled.)")
        .def(
            "leaf_blocks", &leaf_blocks, "level"_a, "memory_budget_bytes"_a, "progress"_a,
            R"(Blocks of 8 x 8 x 8 cubes of 2 ** level voxels: origins in cubes, uint32 (n, 3), and bits, uint64 (n, 8), bit
8 y + z of word x. Releases the GIL. InvalidInput: the budget; Cancelled.)");
}
} // namespace tyndall::bindings
