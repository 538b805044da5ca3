// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/styled_shafts.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "render/steep_entries.hpp"
#include "transfer_functions/apply.hpp"
#include "transfer_functions/compose.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::render {
using transfer_functions::WeightedFunction;

StyledShafts::StyledShafts(std::uint32_t width_px, std::uint32_t height_px, std::size_t function_count,
                           bool is_textured)
    : width_px_(width_px), function_count_(function_count), is_textured_(is_textured),
      sample_counts_(std::size_t{width_px} * height_px), cells_(sample_counts_.size() * cells_per_pixel),
      parameters_(cells_.size() * function_count) {}

std::size_t StyledShafts::cell_for(std::size_t pixel, float depth_m) const {
    const std::size_t first = pixel * cells_per_pixel;
    std::size_t nearest = first;
    double least = 2.0;
    for (std::size_t cell = first; cell < first + cells_per_pixel; ++cell) {
        if (cells_[cell].count == 0)
            return least < same_surface ? nearest : cell;
        const double difference = depth_difference(cells_[cell].depth_m, depth_m);
        if (difference < least)
            least = difference, nearest = cell;
    }
    return nearest;
}

void StyledShafts::add(std::size_t pixel, const SeenSurface& surface, const SeenShafts& shafts,
                       std::span<const vec2> parameters) {
    ++sample_counts_[pixel];
    if (!shafts.meets_medium)
        return;
    const std::size_t index = cell_for(pixel, surface.depth_m);
    Cell& cell = cells_[index];
    if (cell.count++ == 0)
        cell.depth_m = surface.depth_m;
    cell.radiance += shafts.radiance;
    cell.textured_light += average(shafts.textured_radiance);
    cell.heterogeneity += shafts.heterogeneity;
    for (std::size_t function = 0; function < function_count_; ++function)
        parameters_[index * function_count_ + function] += parameters[function];
}

UnstyledFilm::Entries StyledShafts::resolve(const Progress& progress) const {
    const std::size_t pixel_count = sample_counts_.size();
    std::vector<std::uint32_t> first(pixel_count + 1, 0);
    for (std::size_t pixel = 0; pixel < pixel_count; ++pixel) {
        std::uint32_t used = 0;
        while (used < cells_per_pixel && cells_[pixel * cells_per_pixel + used].count > 0)
            ++used;
        first[pixel + 1] = first[pixel] + used;
    }
    const std::size_t count = first.back();
    UnstyledFilm::Entries entries{.pixel = std::vector<std::uint32_t>(count),
                                  .radiance = std::vector<Rgb>(count),
                                  .share = std::vector<float>(count),
                                  .parameters =
                                      std::vector<std::vector<vec2>>(function_count_, std::vector<vec2>(count)),
                                  .heterogeneity = std::vector<float>(is_textured_ ? count : 0)};
    std::vector<float> depth_m(count);
    constexpr std::size_t pixels_per_block = 1 << 14;
    parallel_for(
        pixel_count, progress,
        [&](std::size_t pixel) {
            const float per_sample = 1.0f / static_cast<float>(std::max(1u, sample_counts_[pixel]));
            for (std::size_t entry = first[pixel]; entry < first[pixel + 1]; ++entry) {
                const std::size_t index = pixel * cells_per_pixel + (entry - first[pixel]);
                const Cell& cell = cells_[index];
                const auto cell_count = static_cast<float>(cell.count);
                entries.pixel[entry] = static_cast<std::uint32_t>(pixel);
                entries.radiance[entry] = cell.radiance * per_sample;
                entries.share[entry] = cell_count * per_sample;
                depth_m[entry] = cell.depth_m;
                if (const float light = average(cell.radiance); is_textured_)
                    entries.heterogeneity[entry] =
                        light > 0.0f ? cell.textured_light / light : cell.heterogeneity / cell_count;
                for (std::size_t function = 0; function < function_count_; ++function)
                    entries.parameters[function][entry] = parameters_[index * function_count_ + function] / cell_count;
            }
        },
        pixels_per_block);
    return split_steep(std::move(entries), depth_m, width_px_, pixel_count, progress);
}

/// Moves the constraints that stand for points of the scene to where these are in the function.
static void place_constraints(const UnstyledFilm& unstyled, std::vector<WeightedFunction>& functions) {
    for (std::size_t index = 0; index < functions.size(); ++index)
        for (transfer_functions::Layer& layer : functions[index].function.layers)
            for (transfer_functions::Constraint& constraint : layer.constraints)
                for (const PlacedPoint& placed : unstyled.points)
                    if (constraint.point == placed.point)
                        constraint.position = placed.parameters[index];
}

/// A function, composed, and what is done with its colours.
struct PreparedFunction {
    transfer_functions::ComposedFunction composed;
    transfer_functions::Application application;
    std::size_t index; ///< Of the parameters.
};

/// Adds to the planes what the functions make of the entries [begin, end), which hold all of their pixels.
static void restyle(const UnstyledFilm::Entries& entries, std::span<const PreparedFunction> functions,
                    std::span<Plane* const> planes, std::size_t begin, std::size_t end, const Progress& progress) {
    std::vector<Rgb> change(end - begin,
                            Rgb(0.0f)); // not of the thread: it may take another block while this one waits
    const auto part_of = [&](const auto& values) { return std::span(values).subspan(begin, end - begin); };
    for (const auto& [composed, application, index] : functions)
        transfer_functions::apply(composed, application, part_of(entries.parameters[index]), part_of(entries.radiance),
                                  part_of(entries.share), change, progress);
    if (!entries.heterogeneity.empty())
        for (std::size_t entry = begin; entry < end; ++entry)
            change[entry - begin] *= entries.heterogeneity[entry];
    for (Plane* const plane : planes) {
        const std::size_t channel_count = layout(plane->pass).channel_count;
        for (std::size_t entry = begin; entry < end; ++entry) {
            float* const values = &plane->values[entries.pixel[entry] * channel_count];
            for (int channel = 0; channel < 3; ++channel)
                values[channel] += change[entry - begin][channel];
        }
    }
}

Film styled(const UnstyledFilm& unstyled, std::vector<WeightedFunction> functions, const Progress& progress) {
    require(functions.size() == unstyled.entries.parameters.size(), "the picture was kept for ",
            unstyled.entries.parameters.size(), " transfer functions, not ", functions.size());
    Film film = unstyled.film;
    place_constraints(unstyled, functions);
    std::vector<PreparedFunction> prepared;
    for (std::size_t index = 0; index < functions.size(); ++index) {
        const auto& [function, weight] = functions[index];
        transfer_functions::ComposedFunction composed =
            transfer_functions::compose(function, transfer_functions::default_size, progress);
        if (weight != 0.0f && !composed.is_neutral())
            prepared.push_back({std::move(composed), {function.use, function.strength, weight}, index});
    }
    if (prepared.empty())
        return film;
    std::vector<Plane*> planes;
    for (Plane& plane : film.planes)
        if (plane.pass == Pass::Combined || plane.pass == Pass::Shafts)
            planes.push_back(&plane);
    const UnstyledFilm::Entries& entries = unstyled.entries;
    constexpr std::size_t entries_per_block = 1 << 13; // their change stays in the second-level cache
    parallel_blocks(entries.pixel.size(), entries_per_block, progress, [&](std::size_t begin, std::size_t end) {
        // A block has every entry of its pixels but those that the block before has begun.
        while (begin > 0 && begin < end && entries.pixel[begin] == entries.pixel[begin - 1])
            ++begin;
        while (end < entries.pixel.size() && entries.pixel[end] == entries.pixel[end - 1])
            ++end;
        restyle(entries, prepared, planes, begin, end, progress);
    });
    return film;
}
} // namespace tyndall::render
