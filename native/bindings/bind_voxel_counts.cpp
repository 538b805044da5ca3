// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/voxel_dag.hpp"
#include "voxel_dag/tree_counts.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

using Row = std::tuple<std::uint32_t, std::uint64_t, std::uint64_t>;
static std::vector<Row> levels(const PlacedDag& self, const Progress& progress) {
    return without_gil([&] {
        std::vector<Row> rows;
        for (const TreeCounts& counts : tree_counts(self.dag, progress))
            rows.emplace_back(counts.level, counts.node_count, counts.tree_count);
        return rows;
    });
}

/// Of geometry, then of attributes, as they lie in memory and in the file.
static py::dict bytes_of_parts(const PlacedDag& self) {
    py::dict bytes;
    for (const PartBytes& part : bytes_by_part(self.dag))
        bytes[part.name] = part.byte_count;
    if (self.attributes) {
        const AttributeParts& parts = self.attributes->parts();
        bytes["counts"] = parts.order.byte_count();
        bytes["materials"] = parts.voxels.materials.size();
        bytes["indices"] = parts.voxels.indices.size();
        bytes["mean_materials"] = parts.means.materials.size();
        bytes["mean_indices"] = parts.means.indices.size();
    }
    return bytes;
}

void bind_voxel_counts(py::module_& native, VoxelDagClass& type) {
    type.def_property_readonly("bytes_by_part", &bytes_of_parts)
        .def("levels", &levels, "progress"_a,
             "Rows of level, distinct nodes and nodes of an octree. Releases the GIL. Cancelled.");
    native.def("estimated_voxel_build_bytes", &estimated_build_bytes, "brick_count"_a, "level"_a,
               "Of the tables that build a DAG of so many bricks in a cube of 2 ** level voxels a side.");
}
} // namespace tyndall::bindings
