// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/surface_pass.hpp"
#include "core/parallel.hpp"
#include "render/moved_view.hpp"
#include "render/pixel_samples.hpp"
#include <algorithm>
#include <array>

namespace tyndall::render {
/// Squares side by side that one task traces.
static constexpr std::uint32_t squares_per_block = 16;
static constexpr std::uint32_t block_width_px = squares_per_block * SurfacePass::square_px;
static constexpr std::size_t rays_per_square = std::size_t{SurfacePass::square_px} * SurfacePass::square_px;
static_assert(rays_per_square <= DirectLight::most_points);

std::size_t SurfaceBlock::bytes() const {
    return sizeof(*this) + parts.first.capacity() * sizeof(std::uint32_t) +
           parts.rays.capacity() * sizeof(light_shafts::ViewRay) + parts.weights.capacity() * sizeof(Rgb) +
           samples.bytes() + walk.bytes() + light.bytes();
}

/// What the pixels of a block bring home, square by square; kept from block to block for its memory.
struct SurfacePass::Catch {
    std::array<Ray, rays_per_square * squares_per_block> rays;
    std::array<std::uint8_t, rays_per_square * squares_per_block> is_caught;
    std::array<PathSample, rays_per_square * squares_per_block> samples;
    std::array<std::vector<MediumPart>, rays_per_square * squares_per_block> parts;
    std::array<std::vector<MediumPart>, rays_per_square> parts_of_square;
    std::vector<PathData> data, data_of_square; ///< Of blocks with data, as long as samples and rays of a square.
    std::vector<Rgb> by_group;                  ///< Of the light groups, sample by sample.
    std::vector<CaughtLight> caught;            ///< Per sample; empty without shadow catchers.
    std::vector<LightPaths> paths;              ///< Per sample; empty where nobody asks.
    SurfaceWalk walk;                           ///< As is the light: of blocks that do not keep it.
    SurfaceLight light;
};

/// What all squares of a call have in common.
struct SurfacePass::Call {
    std::uint32_t sample_index;
    std::span<const std::uint8_t> is_active;
    const Kept& kept;
    const Deliver& deliver;
    const Progress& progress;
};

static std::uint32_t rounded_down(std::uint32_t value, std::uint32_t step) { return value / step * step; }

void SurfacePass::walk_square(const Call& call, std::uint32_t x0, std::uint32_t y0, const SurfaceBlock& block,
                              Catch& caught, SurfaceWalk& walk) const {
    std::array<std::uint32_t, rays_per_square> xs, ys, seeds;
    std::array<std::uint32_t, rays_per_square> targets; ///< Of the block; nowhere: only keeps the others company.
    std::size_t count = 0, wanted_count = 0;
    for (std::uint32_t y = y0; y < std::min(y0 + square_px, camera_.height_px); ++y)
        for (std::uint32_t x = x0; x < std::min(x0 + square_px, camera_.width_px); ++x) {
            targets[count] = ViewPath::nowhere;
            if (block.has(x, y)) {
                if (!call.is_active[pixel_at(x, y)])
                    continue;
                targets[count] = block.index_of(x, y);
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
    std::array<Ray, rays_per_square> sharp, air, rays;
    if (config_.pixel_samples > 1)
        pixel_pairs(these_seeds, call.sample_index, 0, u);
    for (std::size_t i = 0; i < count; ++i) {
        const vec2 offset_px = config_.pixel_samples > 1 ? filter_.offset_px(u[i]) : vec2(0.0f);
        sharp[i] = pixel_ray(camera_, xs[i], ys[i], offset_px);
        air[i] = camera_.lens.is_pinhole() ? sharp[i] : pixel_ray(air_camera_, xs[i], ys[i], offset_px);
    }
    for (std::size_t i = 0; i < count; ++i)
        rays[i] = config_.pixel_samples > 1 ? lens_ray(camera_, sharp[i], seeds[i], call.sample_index) : sharp[i];
    std::array<PathSample, rays_per_square> samples;
    const std::size_t groups = call.kept.group_count;
    for (std::size_t i = 0; groups > 0 && i < count; ++i)
        if (targets[i] != ViewPath::nowhere)
            samples[i].by_group = std::span(caught.by_group).subspan(targets[i] * groups, groups);
    for (std::size_t i = 0; !caught.caught.empty() && i < count; ++i)
        if (targets[i] != ViewPath::nowhere)
            samples[i].caught = &caught.caught[targets[i]];
    for (std::size_t i = 0; !caught.paths.empty() && i < count; ++i)
        if (targets[i] != ViewPath::nowhere)
            samples[i].paths = &caught.paths[targets[i]];
    for (std::vector<MediumPart>& parts : caught.parts_of_square)
        parts.clear();
    for (PathData& data : caught.data_of_square)
        data.clear();
    path_.walk(std::span(rays).first(count), these_seeds, call.sample_index, std::span(targets).first(count), samples,
               caught.parts_of_square, &walk,
               {std::span(caught.data_of_square).first(call.kept.data != nullptr ? count : 0), call.kept.data});
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t pixel = targets[i];
        if (pixel == ViewPath::nowhere)
            continue;
        caught.is_caught[pixel] = 1;
        caught.samples[pixel] = samples[i];
        caught.rays[pixel] = air[i]; // the rows of shafts need rays that share their origin
        caught.parts[pixel].swap(caught.parts_of_square[i]);
        if (!camera_.lens.is_pinhole()) {
            const float sharp_per_m = camera_.sharp_per_blurred_m(air[i], rays[i]);
            for (MediumPart& part : caught.parts[pixel])
                part.near_m *= sharp_per_m, part.far_m *= sharp_per_m;
        }
        if (call.kept.data != nullptr)
            std::swap(caught.data[pixel], caught.data_of_square[i]);
    }
}

void SurfacePass::walk_block(const Call& call, SurfaceBlock& block, Catch& caught, SurfaceWalk& walk) const {
    caught.is_caught.fill(0);
    caught.data.resize(call.kept.data != nullptr ? caught.samples.size() : 0);
    caught.data_of_square.resize(call.kept.data != nullptr ? rays_per_square : 0);
    caught.caught.resize(path_.catches_shadows() ? caught.samples.size() : 0);
    caught.paths.resize(path_.config().tells_paths ? caught.samples.size() : 0);
    caught.by_group.assign(caught.samples.size() * call.kept.group_count, Rgb(0.0f));
    for (std::vector<MediumPart>& parts : caught.parts)
        parts.clear();
    walk.clear();
    const std::uint32_t y0 = rounded_down(block.pixels.y0, square_px);
    for (std::uint32_t x = rounded_down(block.pixels.x0, square_px); x < block.pixels.x1; x += square_px) {
        call.progress.poll();
        walk_square(call, x, y0, block, caught, walk);
    }
    block.parts.clear();
    block.samples = {};
    if (!path_.config().collects_parts)
        return; // nor is memory for any: one thread would free that of all blocks
    const std::size_t pixel_count = block.pixel_count();
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

void SurfacePass::ask_lights(const Call& call, SurfaceBlock& block, const SurfaceWalk& walk,
                             SurfaceLight& light) const {
    if (!block.was_kept) {
        thread_local std::vector<std::uint8_t> all;
        all.assign(call.kept.is_asked.size(), 1);
        path_.ask_lights(walk, call.sample_index, all, light, call.kept.group_count);
        return;
    }
    path_.ask_lights(walk, call.sample_index, call.kept.is_asked, light, call.kept.group_count);
    if (call.kept.moved != nullptr)
        block.lit_again_count =
            path_.ask_again(walk, call.sample_index, call.kept.is_asked, call.kept.moved->boxes(), light);
}

void SurfacePass::trace_block(const Call& call, SurfaceBlock& block) const {
    thread_local Catch caught;
    const bool keeps_points = call.kept.form == SurfaceForm::Points;
    const bool keeps_samples = call.kept.form == SurfaceForm::Samples;
    SurfaceWalk& walk = keeps_points ? block.walk : caught.walk;
    SurfaceLight& light = keeps_points ? block.light : caught.light;
    const std::size_t pixel_count = block.pixel_count();
    const auto pack = [&] {
        for (std::size_t pixel = 0; pixel < pixel_count; ++pixel)
            block.samples.push(caught.samples[pixel], call.kept.parts);
    };
    const bool was_walked =
        block.is_walked && !(call.kept.moved != nullptr && call.kept.moved->may_show_in(block.pixels));
    block.is_walked = was_walked; // a walk may be stopped on the way
    block.was_kept = was_walked;
    block.lit_again_count = 0;
    if (was_walked) {
        caught.is_caught.fill(1);
        for (std::size_t pixel = 0; pixel < pixel_count; ++pixel)
            caught.samples[pixel] = block.samples.get(pixel, call.kept.parts);
    } else {
        walk_block(call, block, caught, walk);
        if (keeps_points) {
            walk.shrink_to_fit();
            pack();
        }
    }
    if (call.kept.is_lit && !(was_walked && keeps_samples)) {
        call.progress.poll();
        ask_lights(call, block, walk, light);
        path_.add_light(walk, light, caught.samples);
        if (call.kept.indirect != nullptr)
            call.kept.indirect->add(walk, call.sample_index, caught.samples, call.kept.group_count, call.progress);
    }
    if (!was_walked && keeps_samples)
        pack();
    block.is_walked = true;
    for (std::uint32_t y = block.pixels.y0; y < block.pixels.y1; ++y)
        for (std::uint32_t x = block.pixels.x0; x < block.pixels.x1; ++x)
            if (const std::size_t pixel = block.index_of(x, y); caught.is_caught[pixel] != 0)
                call.deliver(pixel_at(x, y), caught.samples[pixel],
                             call.kept.data != nullptr ? &caught.data[pixel] : nullptr);
}

std::vector<SurfaceBlock> SurfacePass::blocks_of(const Rows& rows) const {
    std::vector<SurfaceBlock> blocks;
    const std::uint32_t end_y = region_.y0 + rows.end_row;
    for (std::uint32_t y = region_.y0 + rows.first_row, next_y = 0; y < end_y; y = next_y) {
        next_y = std::min(rounded_down(y, square_px) + square_px, end_y);
        for (std::uint32_t x = region_.x0, next_x = 0; x < region_.x1; x = next_x) {
            next_x = std::min(rounded_down(x, block_width_px) + block_width_px, region_.x1);
            blocks.emplace_back().pixels = {x, y, next_x, next_y};
        }
    }
    return blocks;
}

/// Rows of the picture out of the rows of blocks side by side. One thread looks at rows of blocks alone, not at pixels.
void SurfacePass::append(std::span<const SurfaceBlock> blocks, WaitingParts& waiting, const Progress& progress) {
    struct Slice {
        const SurfaceBlock* block;
        std::size_t first_pixel, to, to_pixel;
    };
    std::vector<Slice> slices;
    std::size_t to = waiting.rays.size(), to_pixel = waiting.first.size();
    for (auto row_begin = blocks.begin(); row_begin != blocks.end();) {
        const auto row_end = std::find_if(row_begin, blocks.end(), [&](const SurfaceBlock& block) {
            return block.pixels.y0 != row_begin->pixels.y0;
        });
        for (std::uint32_t y = row_begin->pixels.y0; y < row_begin->pixels.y1; ++y)
            for (auto block = row_begin; block != row_end; ++block) {
                const std::vector<std::uint32_t>& first = block->parts.first;
                const std::size_t first_pixel = block->index_of(block->pixels.x0, y);
                slices.push_back({&*block, first_pixel, to, to_pixel});
                to_pixel += block->width_px();
                to += first[first_pixel + block->width_px()] - first[first_pixel];
            }
        row_begin = row_end;
    }
    waiting.first.resize(to_pixel);
    waiting.rays.resize(to);
    waiting.weights.resize(to);
    parallel_for(
        slices.size(), progress,
        [&](std::size_t index) {
            const auto [block, first_pixel, destination, destination_pixel] = slices[index];
            const std::vector<std::uint32_t>& first = block->parts.first;
            const std::size_t begin = first[first_pixel];
            const std::size_t count = first[first_pixel + block->width_px()] - begin;
            for (std::size_t pixel = 0; pixel < block->width_px(); ++pixel)
                waiting.first[destination_pixel + pixel] =
                    static_cast<std::uint32_t>(destination + first[first_pixel + pixel + 1] - begin);
            std::copy_n(block->parts.rays.data() + begin, count, waiting.rays.data() + destination);
            std::copy_n(block->parts.weights.data() + begin, count, waiting.weights.data() + destination);
        },
        squares_per_block);
}

void SurfacePass::find_parts(const Rows& rows, WaitingParts& waiting, const Progress& progress) const {
    const std::vector<std::uint8_t> is_active(std::size_t{region_.y1 - region_.y0} * (region_.x1 - region_.x0), 1);
    std::vector<SurfaceBlock> blocks;
    trace(
        rows, is_active, {.form = SurfaceForm::Nothing, .parts = {}, .is_asked = {}, .is_lit = false}, blocks,
        [](std::size_t, const PathSample&, const PathData*) {}, waiting, progress);
}

void SurfacePass::trace(const Rows& rows, std::span<const std::uint8_t> is_active, const Kept& kept,
                        std::vector<SurfaceBlock>& blocks, const Deliver& deliver, WaitingParts& waiting,
                        const Progress& progress) const {
    if (blocks.empty())
        blocks = blocks_of(rows);
    const Call call{rows.sample_index, is_active, kept, deliver, progress};
    parallel_for(
        blocks.size(), progress, [&](std::size_t index) { trace_block(call, blocks[index]); }, 1);
    if (path_.config().collects_parts)
        append(blocks, waiting, progress);
}
} // namespace tyndall::render
