// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/direction_program.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "shading/surface_program.hpp"
#include <cmath>
#include <numbers>

namespace tyndall {
DirectionProgram::DirectionProgram(Material material)
    : material_(std::move(material)), no_uvs_(material_.uv_map_names.size(), vec2(0.0f)) {
    validate(material_);
}

Rgb DirectionProgram::radiance(const vec3& unit_direction, RayKind kind) const {
    const vec3 back = -unit_direction;
    const ProgramPoint point{.surface = {.position = unit_direction, .geometric_normal = back, .shading_normal = back},
                             .ray_kind = kind,
                             .incoming = back,
                             .object_position = unit_direction};
    return evaluate(material_, point, no_uvs_).emission;
}

void DirectionProgram::radiance(std::span<const vec3> unit_directions, RayKind kind, std::span<Rgb> values,
                                const Progress& progress) const {
    require(values.size() == unit_directions.size(), "world \"", name(), "\": ", values.size(), " values for ",
            unit_directions.size(), " directions");
    parallel_for(values.size(), progress,
                 [&](std::size_t index) { values[index] = radiance(unit_directions[index], kind); });
}

std::vector<Rgb> DirectionProgram::image(std::uint32_t width, std::uint32_t height, RayKind kind,
                                         const Progress& progress) const {
    std::vector<dvec2> around(width); // cosine and sine of each column's longitude
    for (std::uint32_t column = 0; column < width; ++column) {
        const double longitude = (0.5 - (column + 0.5) / width) * 2.0 * std::numbers::pi;
        around[column] = {std::cos(longitude), std::sin(longitude)};
    }
    std::vector<Rgb> pixels(std::size_t{width} * height);
    parallel_for(
        height, progress,
        [&](std::size_t row) {
            const double latitude = ((static_cast<double>(row) + 0.5) / height - 0.5) * std::numbers::pi;
            for (std::uint32_t column = 0; column < width; ++column)
                pixels[row * width + column] =
                    radiance(vec3(dvec3(std::cos(latitude) * around[column], std::sin(latitude))), kind);
        },
        4);
    return pixels;
}
} // namespace tyndall
