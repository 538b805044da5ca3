// SPDX-License-Identifier: GPL-3.0-or-later
// Where a light's map lies. A sun's: across its light, along its own axes, in metres from its origin, as its masks and
// its gobo. A lamp's fills its cone, or surrounds it.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.2: the map has a resolution and a focus of its own.
// Differs:  the focus is what the strokes' rays see lit, grown to one of few sizes and moved by whole texels, so that a map
//           that is fitted again, or continued from another camera, has its texels where they were.
#pragma once
#include "core/math.hpp"
#include "scene/light.hpp"
#include <cstdint>
#include <vector>

namespace tyndall::light_shafts {
struct LightMapPlace {
    std::uint32_t resolution = 512; ///< Texels per side, [8, 8192].
    float size_m = 0.0f;            ///< Of a side, > 0. Of a lamp there are no metres: see thrown_place.
    vec2 centre_m{0.0f};            ///< From the light's origin along its axes.
    bool operator==(const LightMapPlace&) const = default;
    [[nodiscard]] float texel_m() const { return size_m / static_cast<float>(resolution); }
};
struct LightMap {
    LightMapPlace place;
    std::vector<Rgb> texels; ///< Rows bottom to top; >= 0: what the light's strength is multiplied by.
};

/// Around what is seen.
struct Focus {
    vec2 min_m{std::numeric_limits<float>::infinity()}, max_m{-std::numeric_limits<float>::infinity()};
    void grow(const vec2& point_m) {
        min_m = glm::min(min_m, point_m);
        max_m = glm::max(max_m, point_m);
    }
    void grow(const Focus& other) {
        min_m = glm::min(min_m, other.min_m);
        max_m = glm::max(max_m, other.max_m);
    }
    [[nodiscard]] bool is_empty() const { return !(min_m.x <= max_m.x); }
};
/// Texels around the focus that nothing reads: where the map goes on beyond its border, it is what it was.
inline constexpr float light_map_margin_texels = 2.0f;
[[nodiscard]] bool covers(const LightMapPlace& place, const Focus& focus);
/// Sizes are powers of the fourth root of 2; the centre is a multiple of a texel.
[[nodiscard]] LightMapPlace snapped(const Focus& focus, std::uint32_t resolution);
/// Of a lamp, in widths of its picture: all of it.
[[nodiscard]] inline LightMapPlace thrown_place(std::uint32_t resolution) {
    return {.resolution = resolution, .size_m = 1.0f, .centre_m = vec2(0.5f)};
}
/// The same map with other texels, bilinear; beyond its border it goes on as there. An empty map is white.
[[nodiscard]] std::vector<Rgb> resampled(const LightMap& map, const LightMapPlace& place);

/// Texel coordinates across a sun: texel i has its centre at i.
class LightMapAxes {
public:
    explicit LightMapAxes(const Light& sun);
    [[nodiscard]] vec2 metres(const vec3& point) const { return along(point - origin_); }
    [[nodiscard]] vec2 along(const vec3& direction) const {
        return {glm::dot(direction, x_axis_), glm::dot(direction, y_axis_)};
    }

private:
    vec3 origin_, x_axis_, y_axis_;
};
[[nodiscard]] inline vec2 texel_at(const LightMapPlace& place, const vec2& point_m) {
    return (point_m - place.centre_m) / place.texel_m() + 0.5f * static_cast<float>(place.resolution) - 0.5f;
}
} // namespace tyndall::light_shafts
