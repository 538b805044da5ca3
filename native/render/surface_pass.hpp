// SPDX-License-Identifier: GPL-3.0-or-later
// One sample of the surfaces of some rows of pixels: camera rays in squares of 4 x 4, their light into the film, their
// parts in media to those that wait.
// Differs:  the squares lie on a grid of the full frame, and are traced whole where a region cuts them: a pixel's rays
//           have the same neighbours in every region, so that a region is a crop of the full frame, bit for bit.
#pragma once
#include "render/indirect_light.hpp"
#include "render/packed_samples.hpp"
#include "render/pixel_filter.hpp"
#include "render/view_path.hpp"
#include "render/waiting_parts.hpp"
#include <functional>

namespace tyndall::render {
/// Pixels [x0, x1) x [y0, y1) of the full frame, y up.
struct Region {
    std::uint32_t x0, y0, x1, y1;
    bool operator==(const Region&) const = default;
};

/// What is kept of a pass over surfaces.
enum class SurfaceForm : std::uint8_t {
    Nothing = 0,
    Samples = 1, ///< With their light: serves while all lights stay.
    Points = 2,  ///< Samples without light, surface points, and what each light gives them: serves when lights change.
};

/// Up to 4 rows of up to 64 pixels, less what lies outside of the region, with what their rays met.
struct SurfaceBlock {
    Region pixels{};
    WaitingParts parts; ///< Row by row.
    bool is_walked = false;
    PackedSamples samples; ///< As are the walk and its light: of the form that is kept.
    SurfaceWalk walk;
    SurfaceLight light;
    std::size_t lit_again_count = 0; ///< Light of points that was asked for again when it was traced last.
    bool was_kept = false;           ///< Then its walk served.

    [[nodiscard]] std::uint32_t width_px() const { return pixels.x1 - pixels.x0; }
    [[nodiscard]] std::uint32_t pixel_count() const { return width_px() * (pixels.y1 - pixels.y0); }
    [[nodiscard]] std::uint32_t index_of(std::uint32_t x, std::uint32_t y) const {
        return (y - pixels.y0) * width_px() + (x - pixels.x0);
    }
    [[nodiscard]] bool has(std::uint32_t x, std::uint32_t y) const {
        return pixels.x0 <= x && x < pixels.x1 && pixels.y0 <= y && y < pixels.y1;
    }
    [[nodiscard]] std::size_t bytes() const;
};

class MovedView; // moved_view.hpp

class SurfacePass {
public:
    /// Side of the squares: bands that end at a multiple of it in the full frame trace no ray twice.
    static constexpr std::uint32_t square_px = 4;

    struct Config {
        std::uint32_t pixel_samples = 1; ///< 1: the pixel's centre, unfiltered and sharp.
        std::uint32_t seed = 0;
    };
    SurfacePass(const ViewPath& path, const Camera& camera, const Region& region, const FilterSampler& filter,
                const Config& config)
        : path_(path), camera_(camera), air_camera_(camera.of_air()), region_(region), filter_(filter),
          config_(config) {}

    struct Rows {
        std::uint32_t sample_index;
        std::uint32_t first_row, end_row; ///< Of the region.
    };
    /// What is kept of these rows.
    struct Kept {
        SurfaceForm form = SurfaceForm::Nothing;
        PackedSamples::Parts parts;
        /// Lights that have changed. Of what is not walked, all are asked.
        std::span<const std::uint8_t> is_asked;
        std::size_t group_count = 0;             ///< Samples come with the light of so many groups; as with data.
        const DataPassConfig* data = nullptr;    ///< Samples come with what this asks for; then nothing is kept.
        bool is_lit = true;                      ///< False: light is not wanted.
        const IndirectLight* indirect = nullptr; ///< Nothing: surfaces see nothing of one another.
        const MovedView* moved = nullptr;        ///< What moved since the rows were walked; nothing: nothing did.
    };
    /// Takes what a pixel's ray found; the pixel is counted in the region, row by row. Called from any thread. Nothing: no
    /// data is asked for.
    using Deliver = std::function<void(std::size_t pixel, const PathSample& sample, const PathData* data)>;
    /// One sample of those pixels of the region's rows that `is_active`: all, where something is kept. `blocks` has what
    /// is kept of the rows, or is empty: then they are walked, and what is to be kept is put there. Appends to `waiting`,
    /// which holds what lies before. Throws Cancelled, after which the light of those that were asked is not complete.
    void trace(const Rows& rows, std::span<const std::uint8_t> is_active, const Kept& kept,
               std::vector<SurfaceBlock>& blocks, const Deliver& deliver, WaitingParts& waiting,
               const Progress& progress) const;

    /// Appends the parts of all rays of the rows alone: nothing is lit.
    void find_parts(const Rows& rows, WaitingParts& waiting, const Progress& progress) const;

private:
    struct Catch;
    struct Call;
    /// Of the region.
    [[nodiscard]] std::size_t pixel_at(std::uint32_t x, std::uint32_t y) const {
        return std::size_t{y - region_.y0} * (region_.x1 - region_.x0) + (x - region_.x0);
    }
    [[nodiscard]] std::vector<SurfaceBlock> blocks_of(const Rows& rows) const;
    void trace_block(const Call& call, SurfaceBlock& block) const;
    void ask_lights(const Call& call, SurfaceBlock& block, const SurfaceWalk& walk, SurfaceLight& light) const;
    void walk_block(const Call& call, SurfaceBlock& block, Catch& caught, SurfaceWalk& walk) const;
    void walk_square(const Call& call, std::uint32_t x0, std::uint32_t y0, const SurfaceBlock& block, Catch& caught,
                     SurfaceWalk& walk) const;
    static void append(std::span<const SurfaceBlock> blocks, WaitingParts& waiting, const Progress& progress);

    const ViewPath& path_;
    const Camera& camera_;
    const Camera air_camera_;
    Region region_;
    const FilterSampler& filter_;
    Config config_;
};
} // namespace tyndall::render
