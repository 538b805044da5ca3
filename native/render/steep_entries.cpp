// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/steep_entries.hpp"
#include "core/parallel.hpp"
#include "transfer_functions/compose.hpp"
#include <algorithm>
#include <array>
#include <cmath>

namespace tyndall::render {
// Of a pixel's side, from its middle: each row and each column of a 4 x 4 grid once.
static constexpr std::array<vec2, 4> quarters{
    {{-0.125f, -0.375f}, {0.375f, -0.125f}, {0.125f, 0.375f}, {-0.375f, 0.125f}}};
static constexpr std::size_t entries_per_block = 1 << 13;

double depth_difference(float a_m, float b_m) {
    constexpr double sky_m = 1e10;
    const double a = a_m == 0.0f ? sky_m : a_m, b = b_m == 0.0f ? sky_m : b_m;
    return std::abs(a - b) / std::max(a, b);
}

static float limited(float before, float after) {
    if (before * after <= 0.0f)
        return 0.0f;
    return std::abs(before) < std::abs(after) ? before : after;
}

namespace {
class Slopes {
public:
    Slopes(const UnstyledFilm::Entries& entries, std::span<const float> depth_m, std::uint32_t width,
           std::size_t pixel_count)
        : entries_(entries), depth_m_(depth_m), width_(width), first_(pixel_count + 1, 0) {
        for (const std::uint32_t pixel : entries.pixel)
            ++first_[pixel + 1];
        for (std::size_t pixel = 0; pixel < pixel_count; ++pixel)
            first_[pixel + 1] += first_[pixel];
    }
    /// Change of a function's parameters from one pixel to the next, to the right and upwards.
    [[nodiscard]] std::array<vec2, 2> of(std::size_t entry, std::size_t function) const {
        const std::size_t x = entries_.pixel[entry] % width_;
        return {x > 0 && x + 1 < width_ ? slope(entry, function, 1) : vec2(0.0f), slope(entry, function, width_)};
    }
    [[nodiscard]] bool is_steep(std::size_t entry) const {
        constexpr float texel = 1.0f / static_cast<float>(transfer_functions::default_size);
        for (std::size_t function = 0; function < entries_.parameters.size(); ++function)
            for (const vec2& change : of(entry, function))
                if (std::max(std::abs(change.x), std::abs(change.y)) > texel)
                    return true;
        return false;
    }

private:
    /// The neighbour's entry of the same surface; nothing beside the picture, or where it sees another surface.
    [[nodiscard]] const vec2* neighbour(std::size_t entry, std::size_t function, std::ptrdiff_t offset) const {
        const std::ptrdiff_t pixel = static_cast<std::ptrdiff_t>(entries_.pixel[entry]) + offset;
        if (pixel < 0 || pixel + 1 >= static_cast<std::ptrdiff_t>(first_.size()))
            return nullptr;
        const auto at = static_cast<std::size_t>(pixel);
        for (std::size_t other = first_[at]; other < first_[at + 1]; ++other)
            if (depth_difference(depth_m_[other], depth_m_[entry]) < same_surface)
                return &entries_.parameters[function][other];
        return nullptr;
    }
    [[nodiscard]] vec2 slope(std::size_t entry, std::size_t function, std::size_t step) const {
        const vec2* before = neighbour(entry, function, -static_cast<std::ptrdiff_t>(step));
        const vec2* after = neighbour(entry, function, static_cast<std::ptrdiff_t>(step));
        if (!before || !after)
            return vec2(0.0f);
        const vec2 here = entries_.parameters[function][entry];
        return {limited(here.x - before->x, after->x - here.x), limited(here.y - before->y, after->y - here.y)};
    }

    const UnstyledFilm::Entries& entries_;
    std::span<const float> depth_m_;
    std::size_t width_;
    std::vector<std::uint32_t> first_; ///< Entry of each pixel.
};
} // namespace

UnstyledFilm::Entries split_steep(UnstyledFilm::Entries entries, std::span<const float> depth_m, std::uint32_t width,
                                  std::size_t pixel_count, const Progress& progress) {
    const std::size_t count = entries.pixel.size();
    const Slopes slopes(entries, depth_m, width, pixel_count);
    std::vector<std::uint32_t> target(count + 1, 0);
    parallel_for(
        count, progress, [&](std::size_t entry) { target[entry + 1] = slopes.is_steep(entry) ? quarters.size() : 1; },
        entries_per_block);
    for (std::size_t entry = 0; entry < count; ++entry)
        target[entry + 1] += target[entry];
    if (target.back() == count)
        return entries;
    UnstyledFilm::Entries split{
        .pixel = std::vector<std::uint32_t>(target.back()),
        .radiance = std::vector<Rgb>(target.back()),
        .share = std::vector<float>(target.back()),
        .parameters = std::vector<std::vector<vec2>>(entries.parameters.size(), std::vector<vec2>(target.back())),
        .heterogeneity = std::vector<float>(entries.heterogeneity.empty() ? 0 : target.back())};
    parallel_for(
        count, progress,
        [&](std::size_t entry) {
            const std::size_t parts = target[entry + 1] - target[entry];
            const float part = 1.0f / static_cast<float>(parts);
            for (std::size_t quarter = 0; quarter < parts; ++quarter) {
                const std::size_t to = target[entry] + quarter;
                split.pixel[to] = entries.pixel[entry];
                split.radiance[to] = entries.radiance[entry] * part;
                split.share[to] = entries.share[entry] * part;
                if (!entries.heterogeneity.empty())
                    split.heterogeneity[to] = entries.heterogeneity[entry];
            }
            for (std::size_t function = 0; function < entries.parameters.size(); ++function) {
                const std::array<vec2, 2> slope = parts > 1 ? slopes.of(entry, function) : std::array<vec2, 2>{};
                for (std::size_t quarter = 0; quarter < parts; ++quarter)
                    split.parameters[function][target[entry] + quarter] =
                        entries.parameters[function][entry] +
                        (parts > 1 ? quarters[quarter].x * slope[0] + quarters[quarter].y * slope[1] : vec2(0.0f));
            }
        },
        entries_per_block);
    return split;
}
} // namespace tyndall::render
