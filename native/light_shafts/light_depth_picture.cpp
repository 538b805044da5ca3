// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_depth_picture.hpp"
#include "core/errors.hpp"
#include "light_shafts/occluder_edits.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
using namespace slope_rows;

/// All occluders as a sun sees them.
static SunPlace place_of(const Scene& scene, const OccluderEdits& edits, const LightSample& sample) {
    const auto [x_axis, y_axis] = edits.axes_across(sample);
    SunPlace place{.axes = {vec3(0.0f), x_axis, y_axis, sample.towards_light}};
    place.window = {vec2(std::numeric_limits<float>::infinity()), vec2(-std::numeric_limits<float>::infinity())};
    const Bounds3 bounds = scene.surface_bounds();
    for (std::size_t corner = 0; corner < 8; ++corner) {
        const vec3 p = bounds.corner(corner);
        const vec2 at(glm::dot(p, x_axis), glm::dot(p, y_axis));
        place.window.min = glm::min(place.window.min, at);
        place.window.max = glm::max(place.window.max, at);
    }
    return place;
}

/// Distance from the light, up to what all texels share; infinite in holes.
static float distance_of(const DepthMap& face, float depth) {
    if (depth == no_occluder)
        return std::numeric_limits<float>::infinity();
    return face.is_perspective ? 1.0f / depth : -depth;
}

namespace {
struct Range {
    float nearest = std::numeric_limits<float>::infinity(), farthest = -nearest;
};
} // namespace

static Range range_of(const ShadowMap& map) {
    Range range;
    for (const DepthMap& face : map.faces) {
        const Layout& layout = face.texels->layout;
        for (const RowExtent& row : layout.rows)
            for (std::int32_t column = 0; column < layout.line_count; ++column) {
                const float distance =
                    distance_of(face, face.texels->slopes[row.offset + static_cast<std::size_t>(column)]);
                if (!std::isfinite(distance))
                    continue;
                range.nearest = std::min(range.nearest, distance);
                range.farthest = std::max(range.farthest, distance);
            }
    }
    return range;
}

static std::vector<float> picture_of(const ShadowMap& map, const Range& range, std::uint32_t& width,
                                     std::uint32_t& height) {
    const Layout& layout = map.faces.front().texels->layout;
    const auto face_width = static_cast<std::size_t>(layout.line_count), face_height = layout.rows.size();
    const std::size_t across = map.is_cube ? 3 : 1, up = map.is_cube ? 2 : 1;
    width = static_cast<std::uint32_t>(across * face_width);
    height = static_cast<std::uint32_t>(up * face_height);
    std::vector<float> picture(std::size_t{width} * height, 1.0f);
    const float scale = range.farthest > range.nearest ? 1.0f / (range.farthest - range.nearest) : 0.0f;
    for (std::size_t index = 0; index < map.faces.size(); ++index) {
        const DepthMap& face = map.faces[index];
        for (std::size_t row = 0; row < face_height; ++row)
            for (std::size_t column = 0; column < face_width; ++column) {
                const float distance =
                    distance_of(face, face.texels->slopes[face.texels->layout.rows[row].offset + column]);
                picture[(index / across * face_height + row) * width + index % across * face_width + column] =
                    std::isfinite(distance) ? std::clamp((distance - range.nearest) * scale, 0.0f, 1.0f) : 1.0f;
            }
    }
    return picture;
}

LightDepthPicture light_depth_picture(const Scene& scene, std::size_t index, std::uint32_t resolution,
                                      const Progress& progress) {
    require(index < scene.lights().size(), "light ", index, " of ", scene.lights().size(), " does not exist");
    require(16 <= resolution && resolution <= 16384, "resolution is ", resolution, ", outside [16, 16384]");
    const Light& light = scene.lights()[index];
    const Occluders all = gather_occluders(scene.description(), progress);
    const std::unique_ptr<const Occluders> some =
        light.links.is_blocked_by_all() ? nullptr : blocking(scene, all, light.links, progress);
    const Occluders& occluders = some ? *some : all;
    require(!occluders.is_empty() && !scene.surface_bounds().is_empty(), "nothing casts a shadow before light \"",
            light.name, "\"");
    const LightSample sample = sample_light(light, static_cast<std::uint32_t>(index), vec3(0.5f));
    const PartialShading partial(occluders.partial_instances, sample, 0);
    const OccluderEdits edits(scene.description(), light, occluders);
    const SunPlace place = sample.is_directional ? place_of(scene, edits, sample) : SunPlace{};
    LightDepthPicture picture;
    const ShadowMap before =
        raster_filter_map(place, edits.map_margin(), sample, resolution, occluders, progress, partial);
    const Range range = range_of(before);
    picture.before = picture_of(before, range, picture.width, picture.height);
    picture.after =
        picture_of(edits.map(place, sample, {resolution}, partial, progress), range, picture.width, picture.height);
    return picture;
}
} // namespace tyndall::light_shafts
