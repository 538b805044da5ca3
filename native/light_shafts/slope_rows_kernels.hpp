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
    alignas(64) Column slice_coordinate, slope, axial, radial, axial_per_m,
        radial_per_m, near_m, far_m, near_line, far_line;
};
/// At most PlacedRays::capacity rays.
void place_rays(const Frame& frame, std::span<const ViewRay> rays, PlacedRays& placed);

/// Consecutive slices, [first, end), and what their rows need to know of occluders.
struct SliceNeeds {
    std::int32_t first = 0, end = 0;
    float first_line = std::numeric_limits<float>::infinity(); ///< Metres or radians, the frame's count of lines.
    float last_line = -std::numeric_limits<float>::infinity();
    float smallest_slope = std::numeric_limits<float>::infinity(); ///< Occluders that stay below it do not matter.
    [[nodiscard]] bool is_empty() const { return first >= end || !(first_line <= last_line); }
};

/// Triangles in the frame's coordinates: per corner a along the axis, and (x, y) along u and v; with the slices that
/// they may touch (not wrapped: the last may exceed the slice count). Triangles around the axis touch all slices.
struct PlacedTriangles {
    static constexpr std::size_t capacity = 512;
    using Column = std::array<float, capacity + 16>; // a vector is stored whole, however few of its lanes are kept
    alignas(64) std::array<Column, 9> axy;
    alignas(64) Column first_slice, last_slice;
    std::size_t count = 0;
    /// Lines by which a cut is longer at either end: neighbours compute their shared end from different corners.
    float overlap = 1e-3f;
};
/// Triangles that let a part of the light pass: which ones they are, and what their corners weigh.
struct PlacedPartials : PlacedTriangles {
    alignas(64) std::array<std::int32_t, capacity + 16> triangle;  ///< Of the scene's mesh.
    alignas(64) std::array<std::uint32_t, capacity + 16> instance; ///< Into Occluders::partial_instances.
    /// For parts of triangles in a face of a cube: the weights of the triangle's own second and third corner at each
    /// corner of the part, times `a`, so that weight / a is right between them; has_weights false: (0, 1, 0), (0, 0, 1).
    alignas(64) std::array<Column, 6> weight;
    bool has_weights = false;
};

/// Triangles in columns as an OccluderBlock has them, and where their object stands.
struct TriangleSource {
    const float* columns;
    std::size_t stride, count;
    mat3 frame_from_object; ///< Rows of (u, v, axis) times the instance's linear part.
    vec3 origin_in_frame;   ///< Of the object: (u, v, axis).
};
/// Appends those triangles that may touch a sample which matters; there must be room for all. `kept`, unless null, gets
/// the index of each appended triangle at its place in `placed`.
void place_triangles(const Layout& layout, const SliceNeeds& needs, const TriangleSource& source,
                     PlacedTriangles& placed, std::int32_t* kept = nullptr);

/// Cuts the triangles by the slices [first, end), keeps the largest slope per line, and empties `placed`.
void raster_triangles(Rows& rows, std::int32_t first_slice, std::int32_t end_slice, PlacedTriangles& placed);
/// Fills the rows of slices with no_occluder.
void clear_slices(Rows& rows, std::int32_t first_slice, std::int32_t end_slice);
/// Smallest and largest slope per block.
void summarise_slices(Rows& rows, std::int32_t first_slice, std::int32_t end_slice);
} // namespace tyndall::light_shafts::slope_rows
