// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/depth_map_face.hpp"
#include "light_shafts/shape_faces.hpp"

namespace tyndall::light_shafts {
using namespace slope_rows;

Frame frame_across(const MapAxes& axes) {
    Frame frame;
    frame.origin = axes.origin;
    frame.u = axes.x_axis;
    frame.v = axes.y_axis;
    frame.axis = axes.z_axis;
    frame.is_parallel = true;
    frame.x = {0, 0, 1};
    frame.y = {0, 1, 0};
    frame.w = {1, 0, 0};
    return frame;
}

static Layout layout_of(const DepthMap& map, const MapWindow& window, glm::uvec2 texels) {
    Layout layout;
    layout.frame = frame_across(map);
    const vec2 step = glm::max(window.max - window.min, vec2(1e-30f)) / vec2(texels);
    layout.line_step = step.x;
    layout.first_line = window.min.x;
    layout.slice_step = step.y;
    layout.first_slice = window.min.y + 0.5f * step.y;
    layout.line_count = static_cast<std::int32_t>(texels.x);
    const std::int32_t padded = (layout.line_count + block_lines - 1) / block_lines * block_lines;
    layout.rows.resize(texels.y);
    layout.slice_directions.assign(texels.y, vec2(1, 0));
    for (std::size_t y = 0; y < layout.rows.size(); ++y)
        layout.rows[y] = {
            .first = 0, .end = padded, .offset = y * static_cast<std::size_t>(padded), .smallest_slope = no_occluder};
    for (std::int32_t x = 0; x < padded; ++x)
        layout.x_at_centre.push_back(layout.first_line + (static_cast<float>(x) + 0.5f) * layout.line_step);
    layout.sample_count = layout.rows.size() * static_cast<std::size_t>(padded);
    return layout;
}

/// Puts triangles into (1/z, x/z, y/z).
static std::size_t place_in_face(const DepthMapFace& face, const OccluderInstance& instance, const OccluderBlock& block,
                                 std::size_t start, std::int32_t first, std::int32_t end, PlacedTriangles& placed) {
    const DepthMapFace::FromObject at = face.from_object(*instance.scene_from_object);
    const Pyramid rows = face.seen_by(first, end);
    if (start == 0 && DepthMapFace::misses(rows, at, block.bounds))
        return block.count;
    for (; start < block.count && placed.count + DepthMapFace::most_triangles <= PlacedTriangles::capacity; ++start) {
        const std::array<vec3, 3> triangle{at(block.corner(start, 0)), at(block.corner(start, 1)),
                                           at(block.corner(start, 2))};
        if (rows.misses(triangle))
            continue;
        face.place(triangle, first, end, placed, [&](std::size_t t, std::size_t c, const vec3& corner) {
            placed.axy[3 * c][t] = 1.0f / corner.z;
            placed.axy[3 * c + 1][t] = corner.x / corner.z;
            return placed.axy[3 * c + 2][t] = corner.y / corner.z;
        });
    }
    return start;
}

void lay_out_texels(DepthMap& map, const MapWindow& window, glm::uvec2 texels) {
    map.texels = std::make_unique<Rows>(layout_of(map, window, texels));
}

void raster_depth(DepthMap& map, const MapWindow& window, const Occluders& occluders, const Progress& progress) {
    if (!map.is_perspective) {
        raster(*map.texels, occluders, progress);
        return;
    }
    const DepthMapFace face(map, window);
    const MapDrawing drawing{
        .lamp = map.origin,
        .placer =
            [&](const OccluderInstance& instance, const OccluderBlock& block, std::size_t start, std::int32_t first,
                std::int32_t end,
                PlacedTriangles& placed) { return place_in_face(face, instance, block, start, first, end, placed); },
        .tracer =
            [&](std::int32_t first, std::int32_t end) {
                trace_shapes(*map.texels, first, end, *occluders.traced,
                             [&](std::int32_t slice, std::int32_t line) { return light_line(map, slice, line); });
            }};
    raster(*map.texels, occluders, progress, &drawing);
}
} // namespace tyndall::light_shafts
