// SPDX-License-Identifier: GPL-3.0-or-later
// What the voxels of a mesh are to carry.
#include "bindings/arrays.hpp"
#include "bindings/voxel_surface.hpp"
#include "core/errors.hpp"
#include <pybind11/stl.h>
#include <variant>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

/// The rows of an array that `kept` holds on to; none of no array.
template <typename Row, typename Scalar>
static std::span<const Row> rows_of(const std::optional<py::array>& array, const std::vector<py::ssize_t>& shape,
                                    std::string_view name, std::vector<py::array>& kept) {
    if (!array)
        return {};
    kept.push_back(*array);
    return rows<Row, Scalar>(*array, shape, name);
}

using ChannelValue = std::variant<float, std::shared_ptr<FilteredTexture>>;

static SurfaceMaterial make_surface_material(const Triple& color,
                                             const std::optional<std::shared_ptr<FilteredTexture>>& texture,
                                             const std::vector<ChannelValue>& channels) {
    SurfaceMaterial material{.color = to_vec3(color), .texture = texture.value_or(nullptr)};
    require(channels.size() <= material.channels.size(), "a material has ", channels.size(), " channels; at most ",
            material.channels.size(), " are possible");
    for (std::size_t channel = 0; channel < channels.size(); ++channel)
        if (const float* value = std::get_if<float>(&channels[channel]))
            material.channels[channel] = *value;
        else
            material.channel_textures[channel] = std::get<1>(channels[channel]);
    return material;
}

static std::shared_ptr<VoxelSurface>
make_surface(const std::optional<py::array>& colors, std::vector<SurfaceMaterial> materials, bool has_material_colors,
             const std::optional<py::array>& material_of_triangle, const std::optional<py::array>& corner_uvs,
             SurfaceNormals normals, const std::optional<py::array>& vertex_normals,
             const std::vector<std::pair<std::string, std::optional<py::array>>>& channels) {
    auto result = std::make_shared<VoxelSurface>();
    result->materials = std::move(materials);
    std::vector<py::array>& kept = result->arrays;
    Surface& surface = result->surface;
    surface.colors = rows_of<vec3, float>(colors, {-1, 3}, "colors", kept);
    surface.materials = result->materials;
    surface.has_material_colors = has_material_colors;
    surface.material_of_triangle =
        rows_of<std::uint32_t, std::uint32_t>(material_of_triangle, {-1}, "material_of_triangle", kept);
    surface.corner_uvs = rows_of<vec2, float>(corner_uvs, {-1, 3, 2}, "corner_uvs", kept);
    surface.normals = normals;
    surface.vertex_normals = rows_of<vec3, float>(vertex_normals, {-1, 3}, "normals", kept);
    for (const auto& [name, values] : channels)
        surface.channels.push_back({name, rows_of<float, float>(values, {-1}, name, kept)});
    return result;
}

void bind_voxel_surface(py::module_& native) {
    py::enum_<SurfaceNormals>(native, "SurfaceNormals")
        .value("NONE", SurfaceNormals::None)
        .value("FACES", SurfaceNormals::Faces)
        .value("VERTICES", SurfaceNormals::Vertices);
    py::class_<SurfaceMaterial>(native, "SurfaceMaterial")
        .def(py::init(&make_surface_material), "color"_a, "texture"_a, "channels"_a,
             "color: linear. texture: in its place, or None. channels: numbers or textures, as the surface has them.");
    py::class_<VoxelSurface, std::shared_ptr<VoxelSurface>>(native, "VoxelSurface", "Refers to its arrays.")
        .def(py::init(&make_surface), "colors"_a, "materials"_a, "has_material_colors"_a, "material_of_triangle"_a,
             "corner_uvs"_a, "normals"_a, "vertex_normals"_a, "channels"_a,
             R"(Of n vertices and m triangles; None where there is none. colors: float32 (n, 3), sRGB-encoded;
material_of_triangle: uint32 (m,); corner_uvs: float32 (m, 3, 2); vertex_normals: float32 (n, 3); channels: names, and
float32 (n,) of each, None: the materials' alone. TypeError: dtype or shape.)");
}
} // namespace tyndall::bindings
