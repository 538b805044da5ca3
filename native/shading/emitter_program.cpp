// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/emitter_program.hpp"
#include "core/parallel.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>

namespace tyndall {
EmitterProgram::EmitterProgram(Material material) : material_(std::move(material)) { validate(material_); }

std::vector<Rgb> EmitterProgram::image(const FlatEmitter& emitter, std::uint32_t width, std::uint32_t height,
                                       const Progress& progress) const {
    const mat4 &to_world = emitter.world_from_object, to_object = glm::inverse(to_world);
    const vec3 normal = glm::normalize(-vec3(to_world[2]));
    std::vector<Rgb> pixels(std::size_t{width} * height);
    parallel_for(
        height, progress,
        [&](std::size_t row) {
            std::vector<vec2> uvs(material_.uv_map_names.size());
            for (std::uint32_t column = 0; column < width; ++column) {
                const vec2 uv((static_cast<float>(column) + 0.5f) / static_cast<float>(width),
                              (static_cast<float>(row) + 0.5f) / static_cast<float>(height));
                if (emitter.is_object)
                    std::ranges::fill(uvs, uv);
                const vec3 local((uv - 0.5f) * emitter.size, 0.0f), position(to_world * vec4(local, 1.0f));
                ProgramPoint point{
                    .surface = {.position = position,
                                .geometric_normal = normal,
                                .shading_normal = normal,
                                .barycentrics = {uv.y, 1.0f - uv.x - uv.y}}, // which Parametric turns into the uv
                    .ray_kind = RayKind::Diffuse,
                    .incoming = normal,
                    .object_position = emitter.is_object ? local : position,
                    .object = {.info = &emitter.object.info, .random = emitter.object.random}};
                if (emitter.is_object)
                    point.object.scene_from_object = &to_world, point.object.object_from_scene = &to_object;
                pixels[row * width + column] = evaluate(material_, point, uvs).emission;
            }
        },
        4);
    return pixels;
}

std::vector<Rgb> EmitterProgram::leaving(const LocalEmitter& lamp, std::span<const EmitterPoint> points,
                                         const Progress& progress) const {
    const mat4 &to_world = lamp.world_from_object, to_object = glm::inverse(to_world);
    std::vector<Rgb> colours(points.size());
    constexpr std::size_t block = 1024;
    parallel_for((points.size() + block - 1) / block, progress, [&](std::size_t index) {
        std::vector<vec2> uvs(material_.uv_map_names.size());
        for (std::size_t at = index * block; at < std::min(points.size(), (index + 1) * block); ++at) {
            const EmitterPoint& seen = points[at];
            std::ranges::fill(uvs, seen.uv);
            const vec3 position = lamp.middle + lamp.radius_m * seen.direction;
            const ProgramPoint point{.surface = {.position = position,
                                                 .geometric_normal = seen.direction,
                                                 .shading_normal = seen.direction,
                                                 .barycentrics = seen.barycentrics},
                                     .ray_kind = RayKind::Diffuse,
                                     .incoming = seen.direction,
                                     .object_position = vec3(to_object * vec4(position, 1.0f)),
                                     .object = {.scene_from_object = &to_world,
                                                .object_from_scene = &to_object,
                                                .info = &lamp.object.info,
                                                .random = lamp.object.random}};
            colours[at] = evaluate(material_, point, uvs).emission;
        }
    });
    return colours;
}
} // namespace tyndall
