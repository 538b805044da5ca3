// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/surface_values.hpp"
#include "core/parallel.hpp"
#include "image/srgb.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::voxel_dag {
static void require_count(std::size_t count, std::size_t wanted, std::string_view name, std::string_view of_what) {
    require(count == wanted, name, ": ", count, " for ", wanted, " ", of_what);
}
static bool is_unit(float value) { return 0.0f <= value && value <= 1.0f; } // false for a NaN, too

static void require_colors(std::span<const vec3> colors, std::size_t vertex_count) {
    require_count(colors.size(), vertex_count, "colors", "vertices");
    for (std::size_t i = 0; i < colors.size(); ++i)
        require(is_unit(colors[i].x) && is_unit(colors[i].y) && is_unit(colors[i].z), "colors: vertex ", i, " has (",
                colors[i].x, ", ", colors[i].y, ", ", colors[i].z, "), outside [0, 1]");
}

static void require_materials(const Surface& surface, std::size_t triangle_count) {
    bool has_textures = false;
    for (std::size_t i = 0; i < surface.materials.size(); ++i) {
        const vec3& color = surface.materials[i].color;
        require(is_unit(color.x) && is_unit(color.y) && is_unit(color.z), "material ", i, " has the colour (", color.x,
                ", ", color.y, ", ", color.z, "), outside [0, 1]");
        has_textures = has_textures || surface.materials[i].texture != nullptr;
        for (std::size_t channel = 0; channel < surface.channels.size(); ++channel) {
            const float value = surface.materials[i].channels[channel];
            require(is_unit(value), "material ", i, " has ", value, " for channel \"", surface.channels[channel].name,
                    "\", outside [0, 1]");
            has_textures = has_textures || surface.materials[i].channel_textures[channel] != nullptr;
        }
    }
    if (!surface.material_of_triangle.empty())
        require_count(surface.material_of_triangle.size(), triangle_count, "material_of_triangle", "triangles");
    for (std::size_t i = 0; i < surface.material_of_triangle.size(); ++i)
        require(surface.material_of_triangle[i] < surface.materials.size(), "triangle ", i, " has material ",
                surface.material_of_triangle[i], "; there are ", surface.materials.size());
    if (has_textures || !surface.corner_uvs.empty())
        require_count(surface.corner_uvs.size(), 3 * triangle_count, "corner_uvs", "corners of triangles");
    for (std::size_t i = 0; i < surface.corner_uvs.size(); ++i)
        require(std::isfinite(surface.corner_uvs[i].x) && std::isfinite(surface.corner_uvs[i].y), "corner_uvs: corner ",
                i % 3, " of triangle ", i / 3, " has (", surface.corner_uvs[i].x, ", ", surface.corner_uvs[i].y, ")");
}

static void require_normals(std::span<const vec3> normals, std::size_t vertex_count) {
    require_count(normals.size(), vertex_count, "normals", "vertices");
    for (std::size_t i = 0; i < normals.size(); ++i)
        require(std::isfinite(normals[i].x) && std::isfinite(normals[i].y) && std::isfinite(normals[i].z),
                "normals: vertex ", i, " has (", normals[i].x, ", ", normals[i].y, ", ", normals[i].z, ")");
}

static void require_channels(std::span<const SurfaceChannel> channels, std::size_t vertex_count) {
    require(channels.size() <= VoxelAttributes::most_channels, "there are ", channels.size(), " channels; at most ",
            VoxelAttributes::most_channels, " are possible");
    for (const SurfaceChannel& channel : channels) {
        require(std::ranges::count(channels, channel.name, &SurfaceChannel::name) == 1, "channel \"", channel.name,
                "\" is there twice");
        require(channel.values.empty() || channel.values.size() == vertex_count, "channel \"", channel.name,
                "\": ", channel.values.size(), " values for ", vertex_count, " vertices");
        const auto wrong = std::ranges::find_if_not(channel.values, is_unit);
        if (wrong != channel.values.end())
            refuse("channel \"", channel.name, "\": vertex ", wrong - channel.values.begin(), " has ", *wrong,
                   ", outside [0, 1]");
    }
}

void require_usable(const Surface& surface, std::size_t vertex_count, std::size_t triangle_count) {
    if (!surface.colors.empty())
        require_colors(surface.colors, vertex_count);
    require_materials(surface, triangle_count);
    if (surface.normals == SurfaceNormals::Vertices)
        require_normals(surface.vertex_normals, vertex_count);
    require_channels(surface.channels, vertex_count);
}

static Four four_of_color(const vec3& linear) {
    const vec3 whole = glm::clamp(linear, 0.0f, 1.0f) * whole_value;
    return {whole.x, whole.y, whole.z, 1.0f}; // the last adds up the weights
}
static Four four_of_normal(const vec3& normal) {
    const dvec3 wide(normal); // whose squares do not underflow
    const double length = glm::length(wide);
    const vec3 whole(length > 0 ? wide * (double{whole_normal} / length) : dvec3(0));
    return {whole.x, whole.y, whole.z, 0.0f};
}

SurfaceValues::SurfaceValues(const Surface& surface, std::size_t vertex_count, std::span<const uvec3> triangles,
                             const Progress& progress)
    : surface_(surface), triangles_(triangles) {
    require_usable(surface, vertex_count, triangles.size());
    if (!surface.colors.empty())
        colors_at_ = per_vertex_++;
    if (surface.normals != SurfaceNormals::None)
        fours_.normals = fours_.count++;
    if (surface.normals == SurfaceNormals::Vertices)
        normals_at_ = per_vertex_++;
    if (!surface.channels.empty())
        fours_.channels = fours_.count++;
    if (std::ranges::any_of(surface.channels, [](const SurfaceChannel& channel) { return !channel.values.empty(); })) {
        has_vertex_channels_ = true;
        channels_at_ = per_vertex_++;
    }
    of_vertices_.resize(vertex_count * per_vertex_);
    if (per_vertex_ == 0)
        return;
    parallel_for(
        vertex_count, progress,
        [&](std::size_t vertex) {
            Four* const fours = of_vertices_.data() + vertex * per_vertex_;
            if (!surface_.colors.empty()) {
                const vec3& color = surface_.colors[vertex];
                fours[colors_at_] =
                    four_of_color({linear_from_srgb(color.x), linear_from_srgb(color.y), linear_from_srgb(color.z)});
            }
            if (surface_.normals == SurfaceNormals::Vertices)
                fours[normals_at_] = four_of_normal(surface_.vertex_normals[vertex]);
            for (std::size_t channel = 0; has_vertex_channels_ && channel < surface_.channels.size(); ++channel)
                fours[channels_at_][channel] = surface_.channels[channel].values.empty()
                                                   ? whole_value
                                                   : surface_.channels[channel].values[vertex] * whole_value;
        },
        4096);
}

static Four times(const Four& a, const Four& b) { return {a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]}; }

void SurfaceValues::corners(std::size_t triangle, const vec3& normal,
                            std::array<Corners, SurfaceFours::most>& to) const {
    const Four of_triangle = four_of_normal(normal);
    const SurfaceMaterial* const same = material(triangle);
    // Factors of what vertices have: a picture is one for itself.
    Four color{1, 1, 1, 1}, channels{1, 1, 1, 1};
    if (same != nullptr) {
        if (same->texture == nullptr)
            color = {same->color.x, same->color.y, same->color.z, 1.0f};
        for (std::size_t channel = 0; channel < surface_.channels.size(); ++channel)
            if (same->channel_textures[channel] == nullptr)
                channels[channel] = same->channels[channel];
    }
    constexpr Four all{whole_value, whole_value, whole_value, whole_value},
        white{whole_value, whole_value, whole_value, 1};
    const Four nothing{0, 0, 0, 1};
    for (std::size_t corner = 0; corner < 3; ++corner) {
        const Four* const fours = of_vertices_.data() + triangles_[triangle][static_cast<int>(corner)] * per_vertex_;
        to[0][corner] = !surface_.colors.empty() ? times(color, fours[colors_at_])
                        : same != nullptr        ? times(color, white)
                                                 : nothing;
        if (fours_.normals != 0) {
            const bool has_own = surface_.normals == SurfaceNormals::Vertices && fours[normals_at_] != Four{0, 0, 0, 0};
            to[fours_.normals][corner] = has_own ? fours[normals_at_] : of_triangle;
        }
        if (fours_.channels != 0)
            to[fours_.channels][corner] = times(channels, has_vertex_channels_ ? fours[channels_at_] : all);
    }
}
} // namespace tyndall::voxel_dag
