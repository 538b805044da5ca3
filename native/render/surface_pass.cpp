// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/surface_pass.hpp"
#include "core/parallel.hpp"
#include "render/pixel_samples.hpp"
#include <algorithm>
#include <array>

namespace tyndall::render {
/// Squares side by side that one task traces.
static constexpr std::uint32_t squares_per_block = 16;
static constexpr std::uint32_t block_width_px = squares_per_block * SurfacePass::square_px;
static constexpr std::size_t rays_per_square = std::size_t{SurfacePass::square_px} * SurfacePass::square_px;
static_assert(rays_per_square <= DirectLight::most_points);

/// Up to 4 rows of up to 64 pixels, less what lies outside of the region.
struct SurfacePass::Block {
    Region pixels;
    WaitingParts parts; ///< Row by row.

    [[nodiscard]] std::uint32_t width_px() const { return pixels.x1 - pixels.x0; }
    [[nodiscard]] std::size_t index_of(std::uint32_t x, std::uint32_t y) const {
        return std::size_t{y - pixels.y0} * width_px() + (x - pixels.x0);
    }
    [[nodiscard]] bool has(std::uint32_t x, std::uint32_t y) const {
        return pixels.x0 <= x && x < pixels.x1 && pixels.y0 <= y && y < pixels.y1;
    }
};

/// What the pixels of a block bring home, square by square; kept from block to block for its memory.
struct SurfacePass::Catch {
    std::array<Ray, rays_per_square * squares_per_block> rays;
    std::array<std::vector<MediumPart>, rays_per_square * squares_per_block> parts;
    std::array<std::vector<MediumPart>, rays_per_square> parts_of_square;
};

/// What all squares of a call have in common.
struct SurfacePass::Call {
    std::uint32_t sample_index;
    std::span<const std::uint8_t> is_active;
    const Deliver& deliver;
    const Progress& progress;
};

static std::uint32_t rounded_down(std::uint32_t value, std::uint32_t step) { return value / step * step; }

void SurfacePass::trace_square(const Call& call, std::uint32_t x0, std::uint32_t y0, const Block& block,
                               Catch& caught) const {
    constexpr std::size_t nowhere = ~std::size_t{0};
    std::array<std::uint32_t, rays_per_square> xs, ys, seeds;
    std::array<std::size_t, rays_per_square> pixels; ///< Of the region; nowhere: only keeps the others company.
    std::size_t count = 0, wanted_count = 0;
    for (std::uint32_t y = y0; y < std::min(y0 + square_px, camera_.height_px); ++y)
        for (std::uint32_t x = x0; x < std::min(x0 + square_px, camera_.width_px); ++x) {
            pixels[count] = nowhere;
            if (block.has(x, y)) {
                pixels[count] = std::size_t{y - region_.y0} * (region_.x1 - region_.x0) + (x - region_.x0);
                if (!call.is_active[pixels[count]])
                    continue;
                ++wanted_count;
            }
            xs[count] = x;
            ys[count] = y;
            seeds[count++] = pixel_seed(camera_, config_.seed, x, y);
        }
    if (wanted_count == 0)
        return;
    const std::span these_seeds = std::span(seeds).first(count);
    std::array<vec2, rays_per_square> u;
    std::array<Ray, rays_per_square> rays;
    if (config_.pixel_samples > 1)
        pixel_pairs(these_seeds, call.sample_index, 0, u);
    for (std::size_t i = 0; i < count; ++i)
        rays[i] = pixel_ray(camera_, xs[i], ys[i], config_.pixel_samples > 1 ? filter_.offset_px(u[i]) : vec2(0.0f));
    std::array<PathSample, rays_per_square> samples;
    for (std::vector<MediumPart>& parts : caught.parts_of_square)
        parts.clear();
    path_.follow(std::span(rays).first(count), these_seeds, call.sample_index, samples, caught.parts_of_square);
    for (std::size_t i = 0; i < count; ++i) {
        if (pixels[i] == nowhere)
            continue;
        call.deliver(pixels[i], samples[i]);
        const std::size_t pixel = block.index_of(xs[i], ys[i]);
        caught.rays[pixel] = rays[i];
        caught.parts[pixel].swap(caught.parts_of_square[i]);
    }
}

void SurfacePass::trace_block(const Call& call, Block& block) const {
    thread_local Catch caught;
    for (std::vector<MediumPart>& parts : caught.parts)
        parts.clear();
    const std::uint32_t y0 = rounded_down(block.pixels.y0, square_px);
    for (std::uint32_t x = rounded_down(block.pixels.x0, square_px); x < block.pixels.x1; x += square_px) {
        call.progress.poll();
        trace_square(call, x, y0, block, caught);
    }
    const std::size_t pixel_count = block.index_of(block.pixels.x0, block.pixels.y1);
    block.parts.first.reserve(pixel_count + 1);
    block.parts.rays.reserve(pixel_count);
    block.parts.weights.reserve(pixel_count);
    for (std::size_t pixel = 0; pixel < pixel_count; ++pixel) {
        const Ray& ray = caught.rays[pixel];
        for (const MediumPart& part : caught.parts[pixel]) {
            block.parts.rays.push_back({ray.origin, ray.direction, part.near_m, part.far_m});
            block.parts.weights.push_back(part.weight);
        }
        block.parts.first.push_back(static_cast<std::uint32_t>(block.parts.rays.size()));
    }
}

std::vector<SurfacePass::Block> SurfacePass::blocks_of(const Rows& rows) const {
    std::vector<Block> blocks;
    const std::uint32_t end_y = region_.y0 + rows.end_row;
    for (std::uint32_t y = region_.y0 + rows.first_row, next_y = 0; y < end_y; y = next_y) {
        next_y = std::min(rounded_down(y, square_px) + square_px, end_y);
        for (std::uint32_t x = region_.x0, next_x = 0; x < region_.x1; x = next_x) {
            next_x = std::min(rounded_down(x, block_width_px) + block_width_px, region_.x1);
            blocks.push_back({.pixels = {x, y, next_x, next_y}, .parts = {}});
        }
    }
    return blocks;
}

/// Rows of the picture out of the rows of blocks side by side.
void SurfacePass::append(std::span<const Block> blocks, WaitingParts& waiting, const Progress& progress) {
    struct Slice {
        const Block* block;
        std::size_t first_pixel, to;
    };
    std::vector<Slice> slices;
    std::size_t to = waiting.rays.size();
    for (auto row_begin = blocks.begin(); row_begin != blocks.end();) {
        const auto row_end = std::find_if(row_begin, blocks.end(),
                                          [&](const Block& block) { return block.pixels.y0 != row_begin->pixels.y0; });
        for (std::uint32_t y = row_begin->pixels.y0; y < row_begin->pixels.y1; ++y)
            for (auto block = row_begin; block != row_end; ++block) {
                const std::vector<std::uint32_t>& first = block->parts.first;
                const std::size_t first_pixel = block->index_of(block->pixels.x0, y);
                slices.push_back({&*block, first_pixel, to});
                for (std::size_t pixel = first_pixel; pixel < first_pixel + block->width_px(); ++pixel)
                    waiting.first.push_back(static_cast<std::uint32_t>(to + first[pixel + 1] - first[first_pixel]));
                to = waiting.first.back();
            }
        row_begin = row_end;
    }
    waiting.rays.resize(to);
    waiting.weights.resize(to);
    parallel_for(
        slices.size(), progress,
        [&](std::size_t index) {
            const auto [block, first_pixel, destination] = slices[index];
            const std::size_t begin = block->parts.first[first_pixel];
            const std::size_t count = block->parts.first[first_pixel + block->width_px()] - begin;
            std::copy_n(block->parts.rays.data() + begin, count, waiting.rays.data() + destination);
            std::copy_n(block->parts.weights.data() + begin, count, waiting.weights.data() + destination);
        },
        squares_per_block);
}

void SurfacePass::trace(const Rows& rows, std::span<const std::uint8_t> is_active, const Deliver& deliver,
                        WaitingParts& waiting, const Progress& progress) const {
    std::vector<Block> blocks = blocks_of(rows);
    const Call call{rows.sample_index, is_active, deliver, progress};
    parallel_for(
        blocks.size(), progress, [&](std::size_t index) { trace_block(call, blocks[index]); }, 1);
    append(blocks, waiting, progress);
}
} // namespace tyndall::render
