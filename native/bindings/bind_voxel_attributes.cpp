// SPDX-License-Identifier: GPL-3.0-or-later
// What voxels of DAGs carry.
#include "bindings/arrays.hpp"
#include "bindings/voxel_dag.hpp"
#include <map>
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

static const DagAttributes& attributes_of(const PlacedDag& self) {
    require(self.attributes != nullptr, "the voxel DAG has no attributes");
    return *self.attributes;
}
static std::span<const Voxel> voxels_of(const py::array& coordinates) {
    return rows<Voxel, std::uint32_t>(coordinates, {-1, 3}, "coordinates");
}
/// Rows of three numbers each.
template <class Row>
static auto rows_to_numpy(const std::vector<Row>& rows) {
    using Scalar = typename Row::value_type;
    py::array_t<Scalar> array({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}});
    std::memcpy(array.mutable_data(), rows.data(), rows.size() * sizeof(Row));
    return array;
}

void bind_voxel_attributes(VoxelDagClass& type) {
    type.def_property_readonly(
            "attribute_bytes",
            [](const PlacedDag& self) { return self.attributes ? self.attributes->parts().byte_count() : 0; })
        .def_property_readonly("attribute_errors",
                               [](const PlacedDag& self) {
                                   const AttributeErrors& errors = attributes_of(self).parts().errors;
                                   return std::map<std::string, double>{{"mean_cie94", errors.mean_cie94},
                                                                        {"most_cie94", errors.most_cie94},
                                                                        {"mean_degrees", errors.mean_degrees},
                                                                        {"most_degrees", errors.most_degrees}};
                               })
        .def_property_readonly(
            "has_colors", [](const PlacedDag& self) { return self.attributes && self.attributes->layout().has_colors; })
        .def_property_readonly(
            "has_normals",
            [](const PlacedDag& self) { return self.attributes && self.attributes->layout().normal_bits > 0; })
        .def_property_readonly("channels",
                               [](const PlacedDag& self) {
                                   return self.attributes ? self.attributes->layout().channels
                                                          : std::vector<std::string>();
                               })
        .def(
            "colors_at",
            [](const PlacedDag& self, const py::array& coordinates, std::uint32_t level, const Progress& progress) {
                const auto voxels = voxels_of(coordinates);
                return rows_to_numpy(
                    without_gil([&] { return colors_at(self.dag, attributes_of(self), voxels, level, progress); }));
            },
            "coordinates"_a, "level"_a, "progress"_a,
            "uint8 (k, 3) of uint32 (k, 3). Releases the GIL. InvalidInput: a voxel that is not set; Cancelled.")
        .def(
            "normals_at",
            [](const PlacedDag& self, const py::array& coordinates, std::uint32_t level, const Progress& progress) {
                const auto voxels = voxels_of(coordinates);
                return rows_to_numpy(
                    without_gil([&] { return normals_at(self.dag, attributes_of(self), voxels, level, progress); }));
            },
            "coordinates"_a, "level"_a, "progress"_a,
            "float32 (k, 3) of uint32 (k, 3). Releases the GIL. InvalidInput: a voxel that is not set; Cancelled.")
        .def(
            "channel_at",
            [](const PlacedDag& self, const std::string& name, const py::array& coordinates, std::uint32_t level,
               const Progress& progress) {
                const auto voxels = voxels_of(coordinates);
                auto values = without_gil(
                    [&] { return channel_at(self.dag, attributes_of(self), name, voxels, level, progress); });
                return to_numpy(std::move(values), {coordinates.shape(0)});
            },
            "name"_a, "coordinates"_a, "level"_a, "progress"_a,
            "uint8 (k,) of uint32 (k, 3). Releases the GIL. InvalidInput: a voxel that is not set; Cancelled.");
}
} // namespace tyndall::bindings
