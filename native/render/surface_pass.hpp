// SPDX-License-Identifier: GPL-3.0-or-later
// One sample of the surfaces of some rows of pixels: camera rays in squares of 4 x 4, their light into the film, their
// parts in media to those that wait.
// Differs:  the squares lie on a grid of the full frame, and are traced whole where a region cuts them: a pixel's rays
//           have the same neighbours in every region, so that a region is a crop of the full frame, bit for bit.
#pragma once
#include "render/pixel_filter.hpp"
#include "render/view_path.hpp"
#include "render/waiting_parts.hpp"
#include <functional>

namespace tyndall::render {
/// Pixels [x0, x1) x [y0, y1) of the full frame, y up.
struct Region {
    std::uint32_t x0, y0, x1, y1;
};

class SurfacePass {
public:
    /// Side of the squares: bands that end at a multiple of it in the full frame trace no ray twice.
    static constexpr std::uint32_t square_px = 4;

    struct Config {
        std::uint32_t pixel_samples = 1; ///< 1: the pixel's centre, unfiltered.
        std::uint32_t seed = 0;
    };
    SurfacePass(const ViewPath& path, const Camera& camera, const Region& region, const FilterSampler& filter,
                const Config& config)
        : path_(path), camera_(camera), region_(region), filter_(filter), config_(config) {}

    struct Rows {
        std::uint32_t sample_index;
        std::uint32_t first_row, end_row; ///< Of the region.
    };
    /// Takes what a pixel's ray found; the pixel is counted in the region, row by row. Called from any thread.
    using Deliver = std::function<void(std::size_t pixel, const PathSample& sample)>;
    /// One sample of those pixels of the region's rows that `is_active`. Appends to `waiting`, which holds what lies
    /// before. Throws Cancelled.
    void trace(const Rows& rows, std::span<const std::uint8_t> is_active, const Deliver& deliver, WaitingParts& waiting,
               const Progress& progress) const;

private:
    struct Block;
    struct Catch;
    struct Call;
    [[nodiscard]] std::vector<Block> blocks_of(const Rows& rows) const;
    void trace_block(const Call& call, Block& block) const;
    void trace_square(const Call& call, std::uint32_t x0, std::uint32_t y0, const Block& block, Catch& caught) const;
    static void append(std::span<const Block> blocks, WaitingParts& waiting, const Progress& progress);

    const ViewPath& path_;
    const Camera& camera_;
    Region region_;
    const FilterSampler& filter_;
    Config config_;
};
} // namespace tyndall::render
