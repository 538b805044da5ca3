// SPDX-License-Identifier: GPL-3.0-or-later
// Programs asked at points of an object, and meshes that these move, before anything is rendered.
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "scene/displaced_corners.hpp"
#include "shading/point_values.hpp"
#include <algorithm>
#include <functional>
#include <optional>
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
namespace {
/// No kind of ray asks for it.
constexpr auto no_ray = static_cast<RayKind>(7);

/// What a program may read of the object whose points it is asked at.
class PointsOfObject {
public:
    PointsOfObject(const std::array<float, 16>& world_from_object, const std::array<float, 4>& color, float pass_index,
                   float random)
        : info_{.color = {color[0], color[1], color[2], color[3]}, .pass_index = pass_index},
          linear_(to_matrix<mat4, 4>(world_from_object.data())), place_(linear_[3]), random_(random) {
        linear_[3] = vec4(0, 0, 0, 1);
        inverse_ = glm::inverse(linear_);
    }

    /// Normals, unit or zero, in the object's space.
    [[nodiscard]] ProgramPoint at(const vec3& position, const vec3& normal = vec3(0.0f),
                                  const vec3& true_normal = vec3(0.0f)) const {
        ProgramPoint point;
        point.ray_kind = no_ray;
        point.object_position = position;
        point.object = {
            .scene_from_object = &linear_, .object_from_scene = &inverse_, .info = &info_, .random = random_};
        point.origin_in_world = place_;
        point.object_normal = normal;
        const auto in_scene = [&](const vec3& direction) {
            const vec3 turned = glm::transpose(mat3(inverse_)) * direction;
            return unit_or(turned, turned);
        };
        point.surface.position = mat3(linear_) * position;
        point.surface.geometric_normal = in_scene(true_normal);
        point.surface.shading_normal = point.incoming = in_scene(normal);
        return point;
    }
    [[nodiscard]] vec3 in_object(const vec3& direction) const { return mat3(inverse_) * direction; }

private:
    ObjectInfo info_;
    mat4 linear_, inverse_;
    vec3 place_;
    float random_;
};

/// Rows of three numbers, 0 where they are not finite.
py::array_t<float> finite_rows(py::ssize_t count, const std::function<vec3(std::size_t)>& row_of) {
    std::vector<float> found(3 * static_cast<std::size_t>(count));
    without_gil([&] {
        parallel_for(
            static_cast<std::size_t>(count), Progress(),
            [&](std::size_t index) {
                const vec3 row = row_of(index);
                for (int axis = 0; axis < 3; ++axis)
                    found[3 * index + static_cast<std::size_t>(axis)] = std::isfinite(row[axis]) ? row[axis] : 0.0f;
            },
            1024);
    });
    return to_numpy(std::move(found), {count, 3});
}

/// Of each point the maps of a material, (n, maps, 2).
class UvsOfPoints {
public:
    UvsOfPoints(const Material& material, const py::array& uvs, py::ssize_t count)
        : map_count_(material.uv_map_names.size()), first_(static_cast<const vec2*>(uvs.data())) {
        check_array<float>(uvs, {count, static_cast<py::ssize_t>(map_count_), 2}, "uvs");
    }
    [[nodiscard]] std::span<const vec2> at(std::size_t point) const {
        return {first_ + point * map_count_, map_count_};
    }

private:
    std::size_t map_count_;
    const vec2* first_;
};

/// A mesh whose triangles use vertices that there are.
struct Triangles {
    std::span<const vec3> positions;
    std::span<const uvec3> triangles;

    Triangles(const py::array& position_array, const py::array& triangle_array)
        : positions(rows<vec3, float>(position_array, {-1, 3}, "positions")),
          triangles(rows<uvec3, std::uint32_t>(triangle_array, {-1, 3}, "triangles")) {
        const auto fits = [&](const uvec3& triangle) {
            return std::max({triangle.x, triangle.y, triangle.z}) < positions.size();
        };
        require(std::ranges::all_of(triangles, fits), "a triangle uses a vertex that does not exist");
    }
    [[nodiscard]] std::span<const bool> flags(const py::array& of_triangles, std::string_view name) const {
        return rows<bool, bool>(of_triangles, {static_cast<py::ssize_t>(triangles.size())}, name);
    }
};

py::array_t<std::uint32_t> first_corners(const py::array& triangles, const py::array& is_moved,
                                         const py::array& positions) {
    const Triangles mesh(positions, triangles);
    const std::span<const bool> moved = mesh.flags(is_moved, "is_moved");
    auto corners = without_gil([&] { return tyndall::first_corners(mesh.triangles, moved, mesh.positions.size()); });
    const auto count = static_cast<py::ssize_t>(corners.size());
    return to_numpy(std::move(corners), {count});
}

void renew_normals(const py::array& positions, const py::array& triangles, const py::array& is_renewed,
                   py::array& corner_normals) {
    const Triangles mesh(positions, triangles);
    const std::span<const bool> renewed = mesh.flags(is_renewed, "is_renewed");
    check_array<float>(corner_normals, {static_cast<py::ssize_t>(mesh.triangles.size()), 3, 3}, "corner_normals");
    const std::span normals(static_cast<vec3*>(corner_normals.mutable_data()), 3 * mesh.triangles.size());
    without_gil([&] { tyndall::renew_normals(mesh.positions, mesh.triangles, renewed, normals, Progress()); });
}

py::array_t<float> displacements(const Material& material, const py::array& positions, const py::array& triangles,
                                 const py::array& vertex_normals, const py::array& corners, const py::array& uvs,
                                 const std::array<float, 16>& world_from_object, const std::array<float, 4>& color,
                                 float pass_index, float random) {
    const Triangles mesh(positions, triangles);
    const auto normals =
        rows<vec3, float>(vertex_normals, {static_cast<py::ssize_t>(mesh.positions.size()), 3}, "vertex_normals");
    const auto asked = rows<std::uint32_t, std::uint32_t>(corners, {-1}, "corners");
    const auto is_known = [&](std::uint32_t corner) { return corner / 3 < mesh.triangles.size(); };
    require(std::ranges::all_of(asked, is_known), "a corner is of no triangle");
    const auto count = static_cast<py::ssize_t>(asked.size());
    const UvsOfPoints uv(material, uvs, count);
    const PointsOfObject points(world_from_object, color, pass_index, random);
    return finite_rows(count, [&](std::size_t index) {
        const uvec3& triangle = mesh.triangles[asked[index] / 3];
        const std::uint32_t vertex = triangle[static_cast<int>(asked[index] % 3)];
        const ProgramPoint point =
            points.at(mesh.positions[vertex], normals[vertex], face_normal(mesh.positions, triangle));
        return points.in_object(emission_register_at(material, point, uv.at(index)));
    });
}

py::array_t<float> program_values(const Material& material, const py::array& positions, const py::array& uvs,
                                  const std::array<float, 16>& world_from_object, const std::array<float, 4>& color,
                                  float pass_index, float random, const std::optional<py::array>& normals,
                                  const std::optional<py::array>& true_normals) {
    const py::ssize_t count = positions.shape(0);
    const auto at = rows<vec3, float>(positions, {count, 3}, "positions");
    const auto directions = [&](const std::optional<py::array>& array, std::string_view name) {
        return array ? rows<vec3, float>(*array, {count, 3}, name) : std::span<const vec3>();
    };
    const auto smooth = directions(normals, "normals"), flat = directions(true_normals, "true_normals");
    const UvsOfPoints uv(material, uvs, count);
    const PointsOfObject points(world_from_object, color, pass_index, random);
    const auto direction = [](std::span<const vec3> of, std::size_t index) {
        return of.empty() ? vec3(0.0f) : of[index];
    };
    return finite_rows(count, [&](std::size_t index) {
        const ProgramPoint point = points.at(at[index], direction(smooth, index), direction(flat, index));
        return emission_register_at(material, point, uv.at(index));
    });
}
} // namespace

void bind_displacement(py::module_& native) {
    native.def("first_corners", &first_corners, "triangles"_a, "is_moved"_a, "positions"_a,
               R"(Of each vertex of moved triangles the first corner there, 3 * triangle + 0 to 2, (n,) uint32.

triangles, (n, 3) uint32; is_moved, (n,) bool; positions, (m, 3) float32. In the order of vertices. TypeError: dtype or
shape; InvalidInput: a triangle's vertex that does not exist.)");
    native.def(
        "displacements", &displacements, "material"_a, "positions"_a, "triangles"_a, "vertex_normals"_a, "corners"_a,
        "uvs"_a, "world_from_object"_a, "color"_a, "pass_index"_a, "random"_a,
        R"(What a program's emission, in the world, moves corners of a mesh by, in the object's space, (n, 3) float32.

positions and vertex_normals, unit, (m, 3) float32; triangles, (t, 3) uint32; corners, (n,) uint32, as first_corners
has them; uvs, (n, maps of the material, 2) float32. What is not finite moves nothing. TypeError: dtype or shape;
InvalidInput: a vertex or a corner that does not exist.)");
    native.def("renew_normals", &renew_normals, "positions"_a, "triangles"_a, "is_renewed"_a, "corner_normals"_a,
               R"(Changes corner_normals, (t, 3, 3) float32: at all vertices of renewed triangles, to the mean of their
unit normals; but zero, flat, stays. positions, (m, 3) float32; triangles, (t, 3) uint32; is_renewed, (t,) bool.
TypeError: dtype or shape; InvalidInput: a triangle's vertex that does not exist.)");
    native.def("program_values", &program_values, "material"_a, "positions"_a, "uvs"_a, "world_from_object"_a,
               "color"_a, "pass_index"_a, "random"_a, "normals"_a = py::none(), "true_normals"_a = py::none(),
               R"(A program's emission at points of an object, (n, 3) float32; 0 where it is not finite.

positions, (n, 3), in the object's space; uvs, (n, maps of the material, 2); normals and true_normals, unit, (n, 3), likewise,
of a surface that is looked at along its normal; None: inside. All float32. TypeError: dtype or shape.)");
}
} // namespace tyndall::bindings
