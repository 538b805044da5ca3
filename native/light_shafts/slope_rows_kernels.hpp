// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loops of slope rows, dispatched at run time to the best SIMD target of the machine.
#pragma once
#include "light_shafts/slope_rows.hpp"
#include <array>

namespace tyndall::light_shafts::slope_rows {
/// View rays in the frame's coordinates, see FramedRay, with the light lines of their ends.
struct PlacedRays {
    static constexpr std::size_t capacity = 256;
    using Column = std::array<float, capacity>;
    alignas(64) Column slice_coordinate, slope, axial, radial, axial_per_m, radial_per_m, near_line, far_line;
};
/// At most PlacedRays::capacity rays.
void place_rays(const Frame& frame, std::span<const ViewRay> rays, PlacedRays& placed);

/// A triangle in the frame's coordinates: per corner a along the axis, and (x, y) along u and v.
struct FramedTriangle {
    std::array<float, 9> axy;
    std::uint16_t first_slice, last_slice; ///< Of the band that holds it.
};
static_assert(sizeof(FramedTriangle) == 40);

/// Triangles of one mesh instance in the frame's coordinates, and the slices they may touch (not wrapped:
/// last_slice may exceed the slice count). Triangles around the axis touch all slices.
struct PlacedTriangles {
    static constexpr std::size_t capacity = 256;
    using Column = std::array<float, capacity>;
    alignas(64) std::array<Column, 9> axy;
    alignas(64) Column first_slice, last_slice;
};
struct TriangleSource {
    const vec3* positions;
    const uvec3* triangles; ///< At most PlacedTriangles::capacity are placed.
    std::size_t count;
    mat3 frame_from_object; ///< Rows of (u, v, axis) times the instance's linear part.
    vec3 origin_in_frame;   ///< Of the object: (u, v, axis).
};
void place_triangles(const Layout& layout, const TriangleSource& source, PlacedTriangles& placed);

/// Cuts the triangles by the slices of one band and keeps the largest slope per line.
void raster_band(Rows& rows, std::int32_t first_slice, std::span<const FramedTriangle> triangles);
/// Fills the rows of a band with no_occluder.
void clear_band(Rows& rows, std::int32_t first_slice);
/// Smallest and largest slope per block of a band.
void summarise_band(Rows& rows, std::int32_t first_slice);
} // namespace tyndall::light_shafts::slope_rows
