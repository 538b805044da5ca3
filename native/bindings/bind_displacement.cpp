// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "shading/point_values.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
namespace {
/// No kind of ray asks for it.
constexpr auto no_ray = static_cast<RayKind>(7);

py::array_t<float> displacements(const Material& material, const py::array& positions, const py::array& normals,
                                 const py::array& true_normals, const py::array& uvs,
                                 const std::array<float, 16>& world_from_object, const std::array<float, 4>& color,
                                 float pass_index, float random) {
    const py::ssize_t count = positions.shape(0), map_count = static_cast<py::ssize_t>(material.uv_map_names.size());
    for (const py::array* vectors : {&positions, &normals, &true_normals})
        check_array<float>(*vectors, {count, 3}, "positions and normals");
    check_array<float>(uvs, {count, map_count, 2}, "uvs");
    mat4 linear = to_matrix<mat4, 4>(world_from_object.data());
    const vec3 place(linear[3]);
    linear[3] = vec4(0, 0, 0, 1);
    const mat4 inverse = glm::inverse(linear);
    const ObjectInfo info{.color = {color[0], color[1], color[2], color[3]}, .pass_index = pass_index};
    const auto *const at = static_cast<const vec3*>(positions.data()),
                      *const normal = static_cast<const vec3*>(normals.data()),
                      *const true_normal = static_cast<const vec3*>(true_normals.data());
    const auto* const uv = static_cast<const vec2*>(uvs.data());
    std::vector<float> found(3 * static_cast<std::size_t>(count));
    without_gil([&] {
        parallel_for(
            static_cast<std::size_t>(count), Progress(),
            [&](std::size_t index) {
                ProgramPoint point;
                point.ray_kind = no_ray;
                point.object_position = at[index];
                point.object = {
                    .scene_from_object = &linear, .object_from_scene = &inverse, .info = &info, .random = random};
                point.origin_in_world = place;
                point.object_normal = normal[index];
                const auto in_scene = [&](const vec3& direction) {
                    const vec3 turned = glm::transpose(mat3(inverse)) * direction;
                    const float length = glm::length(turned);
                    return length > 0.0f ? turned / length : turned;
                };
                point.surface.position = mat3(linear) * at[index];
                point.surface.geometric_normal = in_scene(true_normal[index]);
                point.surface.shading_normal = point.incoming = in_scene(normal[index]);
                const Rgb moved = emission_register_at(
                    material, point,
                    {uv + index * static_cast<std::size_t>(map_count), static_cast<std::size_t>(map_count)});
                const vec3 in_object = mat3(inverse) * moved;
                for (int axis = 0; axis < 3; ++axis)
                    found[3 * index + static_cast<std::size_t>(axis)] =
                        std::isfinite(in_object[axis]) ? in_object[axis] : 0.0f;
            },
            1024);
    });
    return to_numpy(std::move(found), {count, 3});
}
} // namespace

void bind_displacement(py::module_& native) {
    native.def(
        "displacements", &displacements, "material"_a, "positions"_a, "normals"_a, "true_normals"_a, "uvs"_a,
        "world_from_object"_a, "color"_a, "pass_index"_a, "random"_a,
        R"(What a program's emission, in the world, moves points of an object by, in its own space, (n, 3) float32.

positions, normals (unit) and true_normals, (n, 3), in the object's space; uvs, (n, maps of the material, 2); all
float32. What is not finite moves nothing. TypeError: dtype or shape.)");
}
} // namespace tyndall::bindings
