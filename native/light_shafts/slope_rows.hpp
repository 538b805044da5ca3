// SPDX-License-Identifier: GPL-3.0-or-later
// Slope rows: per slice a row of samples, one per light line; each holds the largest slope of the occluders on its line.
// Layout:   all rows share one numbering of light lines (a table of X), each keeps the stretch that its view rays need.
//           Rows start and end at multiples of 16 lines, so that a block of 16 has one smallest and one largest slope.
// Bound:    4.5 bytes per sample; make_layout lowers the resolution until all rows fit into `memory_limit_bytes`.
#pragma once
#include "core/memory_room.hpp"
#include "light_shafts/ray_outline.hpp"
#include "light_shafts/slope_rows_frame.hpp"
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <vector>

namespace tyndall::light_shafts::slope_rows {
inline constexpr std::int32_t block_lines = 16; ///< Light lines per block.
inline constexpr float no_occluder = -std::numeric_limits<float>::infinity();
inline constexpr float near_epipole = 1.0f / 64; ///< Of the largest radius per metre (or radius) of the view.

/// The lines of a slice that are kept: [first, end), multiples of block_lines; empty rows have first == end.
struct RowExtent {
    std::int32_t first = 0, end = 0;
    std::size_t offset = 0;                                        ///< Of line `first` in Rows::slopes.
    float smallest_slope = std::numeric_limits<float>::infinity(); ///< Of the view rays: lower occluders do not matter.
};

struct Layout {
    Frame frame;
    float first_slice = 0.0f; ///< Slice coordinate of the centre of slice 0.
    float slice_step = 1.0f;  ///< Radians or metres.
    float first_line = 0.0f;  ///< Edge of line 0: metres or radians.
    float line_step = 1.0f;
    float smallest_radius = 0;        ///< Rays with less (per metre, or metres) are too close to the epipole for rows.
    float smallest_radius_cut = 0;    ///< Half-planes begin here, not on their axis, where X is infinite, metres.
    std::int32_t slices_per_turn = 0; ///< 0 where slices are parallel.
    std::int32_t line_count = 0;
    std::vector<RowExtent> rows;
    std::vector<float> x_at_centre;     ///< Per line; line_count of them and padding to a multiple of 16.
    std::vector<float> x_at_edge;       ///< line_count + 1.
    std::vector<vec2> slice_directions; ///< Cosine and sine per slice, and 16 more; (1, 0) where slices are parallel.
    std::size_t sample_count = 0;
    std::shared_ptr<MemoryRoom> room = {}; ///< As LayoutConfig's.

    [[nodiscard]] std::int32_t slice_count() const { return static_cast<std::int32_t>(rows.size()); }
};

/// May lie outside [0, slice_count) where no ray was announced.
[[nodiscard]] std::int32_t nearest_slice(const Layout& layout, float slice_coordinate);

struct LayoutConfig {
    std::uint32_t lines = 2048;   ///< Along the longest row, [16, 65536].
    float slices_per_line = 1.0f; ///< Density of slices at the far border relative to that of lines.
    std::size_t memory_limit_bytes = std::size_t{2} << 30;
    /// Lines beyond what the rays need, towards the camera and away from it: metres, or radians of an angular frame. For
    /// filters along the rows.
    float margin_before = 0.0f, margin_after = 0.0f;
    std::shared_ptr<MemoryRoom> room = {}; ///< That rows are filled from; nothing: whatever they take.
};
/// Rows for the rays, which are finite. Throws Cancelled.
[[nodiscard]] Layout make_layout(const Frame& frame, std::span<const RaySpan> spans, const LayoutConfig& config,
                                 const Progress& progress);
[[nodiscard]] Layout make_layout(const Frame& frame, std::span<const ViewRay> rays, const LayoutConfig& config,
                                 const Progress& progress);

/// One row as a query reads it.
struct RowView {
    const float* slopes = nullptr; ///< Of line `first` on.
    const float* lowest = nullptr; ///< Per block.
    const float* highest = nullptr;
    std::int32_t first = 0, end = 0;
};

struct Rows {
    Layout layout;
    struct FreeAligned {
        void operator()(float* values) const { ::operator delete[](values, std::align_val_t{64}); }
    };
    std::unique_ptr<float[], FreeAligned> slopes; ///< Not initialised: clear_slices does that, in parallel.
    std::unique_ptr<float[]> lowest, highest;
    std::shared_ptr<const void> room_taken; ///< Of layout.room, from take_room() on.

    explicit Rows(Layout layout_to_keep);
    [[nodiscard]] RowView row(std::int32_t slice) const {
        const RowExtent& extent = layout.rows[static_cast<std::size_t>(slice)];
        const std::size_t block = extent.offset / block_lines;
        return {slopes.get() + extent.offset, lowest.get() + block, highest.get() + block, extent.first, extent.end};
    }
    [[nodiscard]] std::size_t bytes() const { return layout.sample_count * 4 + layout.sample_count / 2; }
    /// Before they are filled. Throws InvalidInput where there is none.
    void take_room();
};
} // namespace tyndall::light_shafts::slope_rows
