// SPDX-License-Identifier: GPL-3.0-or-later
// How maps and rows draw shapes of cells: a small shape by the faces that its cells show, as triangles of a mesh; a large
// one by tracing, one ray per sample. Either way a sample holds what it would of a mesh of the same boxes.
// Bound:    2 triangles per face in the open, 200 bytes per cell of a surface; 0.3 to 1.5 us per sample that is traced, of
//           which a lamp's rows have millions: more than a million cells' faces take.
#pragma once
#include "light_shafts/depth_map.hpp"
#include "scene/placed_shapes.hpp"

namespace tyndall::light_shafts {
/// Cells of a shape, times how often it stands in the scene, up to which faces are drawn.
inline constexpr std::uint64_t most_cells_with_faces = std::uint64_t{1} << 20;
[[nodiscard]] std::unique_ptr<const OccluderMesh> make_face_mesh(const CellShape& shape);

/// The line of light of a sample: its slope is y / w at the nearest occluder.
struct LightLine {
    Ray ray;
    vec2 y, w; ///< At the ray's origin, and per length of its direction.
    [[nodiscard]] float slope(float distance) const { return (y[0] + y[1] * distance) / (w[0] + w[1] * distance); }
};
/// Of rows in their own frame; a sun's lines begin at `highest_axial`.
[[nodiscard]] LightLine light_line(const slope_rows::Layout& layout, float highest_axial, std::int32_t slice,
                                   std::int32_t line);
/// Along the frame's axis, where nothing of a box is any more.
[[nodiscard]] float above(const slope_rows::Frame& frame, const Bounds3& bounds);
/// Of a face of a lamp's depth map.
[[nodiscard]] LightLine light_line(const DepthMap& map, std::int32_t slice, std::int32_t line);

/// Raises the samples of the slices [first, end) to what is traced. `line_of(slice, line)` is a LightLine.
template <class LineOf>
void trace_shapes(slope_rows::Rows& rows, std::int32_t first, std::int32_t end, const ShapeTracer& shapes,
                  const LineOf& line_of) {
    for (std::int32_t slice = first; slice < end; ++slice) {
        const slope_rows::RowExtent& row = rows.layout.rows[static_cast<std::size_t>(slice)];
        for (std::int32_t line = row.first; line < row.end; ++line) {
            const LightLine light = line_of(slice, line);
            const float distance = shapes.distance_to_nearest(light.ray);
            if (!std::isfinite(distance))
                continue;
            float& slope = rows.slopes[row.offset + static_cast<std::size_t>(line - row.first)];
            slope = std::max(slope, light.slope(distance));
        }
    }
}
} // namespace tyndall::light_shafts
