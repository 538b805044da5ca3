// SPDX-License-Identifier: GPL-3.0-or-later
// The optical depth of one grid that the light of one sample has passed before it reaches a point: the integral of its
// densities' extinction over its way, kept in columns that run with the light.
// Based on: Lokovic and Veach, Deep Shadow Maps, SIGGRAPH 2000; optical depth instead of transmittance, which would
//           underflow and does not interpolate (von Radziewsky et al., Visibility Sweeps, TVCG 2017).
// Differs:  a column's values are exact integrals at its places, not sums of earlier interpolations as in a sweep:
//           nothing smears, and the only error is that of interpolating between columns. A column is made when a point
//           first asks for it: of a lamp among many grids, or one of thousands of cells, few are.
//           Where columns are two voxels apart or more the integral is a sum of the densities at every voxel, as precise
//           as what lies between columns then is. What has one colour of all channels is one number per place, else three.
// Bound:    one walk through the grid per column that is asked for, two looks per cell or one per voxel; 8 bytes per
//           column, 4 or 12 per place of those with density before it and behind it; 8 or 24 loads per lookup.
#pragma once
#include "scene/light.hpp"
#include "scene/media.hpp"
#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// Of light columns: what stands in any case, and what would if all of them were made, as those that are.
struct ColumnBytes {
    double of_places = 0.0, of_values = 0.0;
};

class LightColumns {
public:
    /// Columns and places in them are `spacing_voxels` apart: for a lamp, in the middle of the grid, which must outlive
    /// this.
    LightColumns(const PlacedGrid& placed, const LightSample& light, float spacing_voxels);

    /// Between the point and the light. Safe from any thread.
    [[nodiscard]] Rgb depth(const vec3& point) const;
    [[nodiscard]] ColumnBytes bytes() const;

private:
    /// Columns through a rectangle of the (u, v) plane: across a sun, or at unit distance from a lamp.
    struct Face {
        vec3 across{0.0f}, up{0.0f}, forward{0.0f}; ///< forward: away from the light.
        vec2 first{0.0f};                           ///< (u, v) of the first column.
        std::uint32_t width = 0, height = 0;
        std::size_t first_column = 0;
    };
    /// Values at places begin, begin + 1, ..; 0 before, the last one behind. None: no density along it.
    struct Column {
        std::uint32_t begin = 0;
        std::vector<float> values; ///< One or three per place.
    };
    struct DeleteColumns {
        std::size_t count; ///< Of the array.
        void operator()(std::atomic<const Column*>* columns) const;
    };
    using Columns = std::unique_ptr<std::atomic<const Column*>[], DeleteColumns>;
    void find_colour();
    void add_face(const vec3& forward, const vec2& low, const vec2& high);
    [[nodiscard]] GridLine line_of(const Face& face, std::uint32_t x, std::uint32_t y) const;
    [[nodiscard]] Column walk(const GridLine& line) const;
    [[nodiscard]] Column sampled(const GridLine& line) const;
    [[nodiscard]] const Column& column(const Face& face, std::uint32_t x, std::uint32_t y) const;
    [[nodiscard]] Rgb depth(const Face& face, const vec2& uv, float way_m) const;
    [[nodiscard]] Rgb depth_at(const Column& column, float place) const;
    /// To the values of a place, of densities times metres.
    void append(const glm::dvec4& integral, std::vector<float>& values) const;

    const PlacedGrid* placed_;
    std::optional<Rgb> colour_; ///< What all channels that dim are multiples of; none: each has its own.
    vec4 shares_{0.0f};         ///< Of the colour, for each channel.
    bool is_directional_;
    vec3 origin_;             ///< The lamp, or a point before the grid as the sun sees it.
    float spacing_uv_ = 1.0f; ///< Between columns.
    float spacing_m_ = 1.0f;  ///< Between places.
    float first_m_ = 0.0f;    ///< Way from the origin of place 0.
    bool is_sampled_;
    std::vector<Face> faces_;
    Columns columns_; ///< Null: not asked for yet.
};

/// How a light sample's loss in density grids is found.
struct GridLoss {
    float spacing_voxels = 0.0f; ///< Of LightColumns; 0: exactly, by a walk through the grids per end of a piece.
    float piece_voxels = 4.0f;   ///< Longest piece of a ray outside of the grids, where its light passes through one.
};

/// The optical depth between points and one light sample, through all grids of a scene.
class GridLightDepth {
public:
    /// `media` must outlive this. Exact until tabulated.
    GridLightDepth(const Media& media, const LightSample& light);
    /// From now on by LightColumns.
    void tabulate(float spacing_voxels);

    [[nodiscard]] Rgb depth(const vec3& point) const;
    [[nodiscard]] Rgb exact_depth(const vec3& point) const;
    /// Appends the parts of a ray whose points the light may reach through the bounds of some grid, in no order.
    void append_reached(const vec3& origin, const vec3& direction, float near_m, float far_m,
                        std::vector<LinePart>& parts) const;
    /// Whether there is such a part.
    [[nodiscard]] bool reaches(const vec3& origin, const vec3& direction, float near_m, float far_m) const;
    [[nodiscard]] ColumnBytes bytes() const;

private:
    const GridMedia& grids_;
    LightSample light_;
    std::vector<LightColumns> columns_;
};
} // namespace tyndall::light_shafts
