// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_matrix.hpp"
#include "core/parallel.hpp"
#include "light_shafts/light_map_fit_kernel.hpp"
#include <algorithm>
#include <utility>

namespace tyndall::light_shafts {
/// Kernels load whole vectors of weights.
static constexpr std::size_t weight_slack = 16;
/// So many dark lines between lit ones cost more than a new stretch.
static constexpr std::size_t dark_lines_to_split = 12;
/// Beyond the border a map goes on as there.
static constexpr float largest_row = 65535.0f;

void LightMapMatrix::Part::add_stretches(bool goes_along_y, std::uint32_t first_line, float across_at_first,
                                         float across_per_line, std::span<const float> line_weights) {
    const std::size_t count = line_weights.size() / channels;
    const auto across = [&](std::size_t line) { return across_at_first + static_cast<float>(line) * across_per_line; };
    const auto strip_of = [&](std::size_t line) {
        const auto row =
            goes_along_y ? first_line + line : static_cast<std::size_t>(std::clamp(across(line), 0.0f, largest_row));
        return static_cast<std::uint16_t>(row / rows_per_strip);
    };
    const auto is_dark = [&](std::size_t line) {
        const auto of_line = line_weights.subspan(line * channels, channels);
        return std::ranges::all_of(of_line, [](float weight) { return weight == 0.0f; });
    };
    std::size_t begin = 0;
    while (begin < count) {
        if (is_dark(begin)) {
            ++begin;
            continue;
        }
        const std::uint16_t strip = strip_of(begin);
        std::size_t end = begin + 1; // behind the last lit line
        for (std::size_t line = end; line < count && line - end < dark_lines_to_split && strip_of(line) == strip;
             ++line)
            if (!is_dark(line))
                end = line + 1;
        stretches.push_back({.ray = ray_count,
                             .first_weight = static_cast<std::uint32_t>(weights.size() / channels),
                             .across_at_first = across(begin),
                             .across_per_line = across_per_line,
                             .first_line = static_cast<std::uint16_t>(first_line + begin),
                             .count = static_cast<std::uint16_t>(end - begin),
                             .strip = strip,
                             .goes_along_y = goes_along_y});
        weights.insert(weights.end(), line_weights.begin() + static_cast<std::ptrdiff_t>(begin * channels),
                       line_weights.begin() + static_cast<std::ptrdiff_t>(end * channels));
        begin = end;
    }
}

void LightMapMatrix::Part::merge_channels() {
    if (channels == 1)
        return;
    for (std::size_t at = 0; at < weights.size(); at += 4)
        if (weights[at] != weights[at + 1] || weights[at] != weights[at + 2])
            return;
    for (std::size_t line = 0; line < weights.size() / 4; ++line)
        weights[line] = weights[4 * line];
    weights.resize(weights.size() / 4);
    channels = 1;
}

void LightMapMatrix::Part::split_channels() {
    if (channels == 4)
        return;
    std::vector<float> split;
    for (const float weight : weights)
        split.insert(split.end(), {weight, weight, weight, 0.0f});
    weights = std::move(split);
    channels = 4;
}

LightMapMatrix::LightMapMatrix(std::uint32_t resolution, bool is_coloured, std::vector<Part> parts,
                               const Progress& progress)
    : resolution_(resolution), is_coloured_(is_coloured) {
    const std::size_t strip_count = (resolution + rows_per_strip - 1) / rows_per_strip, channels = is_coloured ? 4 : 1;
    struct Place {
        std::size_t stretch = 0, weight = 0;
    };
    std::vector<Place> place(strip_count * parts.size()); // where each part begins in each strip
    std::vector<std::uint32_t> first_ray(1);
    for (std::size_t part = 0; part < parts.size(); ++part) {
        first_ray.push_back(first_ray.back() + parts[part].ray_count);
        for (RowStretch& stretch : parts[part].stretches) {
            stretch.strip = std::min(stretch.strip, static_cast<std::uint16_t>(strip_count - 1));
            Place& counts = place[stretch.strip * parts.size() + part];
            ++counts.stretch;
            counts.weight += stretch.count;
        }
    }
    Place total;
    for (std::size_t index = 0; index < place.size(); ++index) {
        if (index % parts.size() == 0)
            first_of_strip_.push_back(static_cast<std::uint32_t>(total.stretch));
        const Place counts = std::exchange(place[index], total);
        total.stretch += counts.stretch;
        total.weight += counts.weight;
    }
    require(total.weight <= UINT32_MAX, "the strokes' rays cross too many texels: fewer stroke pixels or a smaller "
                                        "resolution are needed");
    first_of_strip_.push_back(static_cast<std::uint32_t>(total.stretch));
    stretches_.resize(total.stretch);
    weights_.resize((total.weight + weight_slack) * channels);
    first_of_ray_.assign(first_ray.back() + 1, 0);
    white_.assign(first_ray.back(), vec4(0.0f));
    parallel_for(
        parts.size(), progress,
        [&](std::size_t part) {
            for (RowStretch stretch : parts[part].stretches) {
                Place& next = place[stretch.strip * parts.size() + part];
                const auto weight =
                    parts[part].weights.begin() + static_cast<std::ptrdiff_t>(stretch.first_weight * channels);
                std::copy_n(weight, stretch.count * channels,
                            weights_.begin() + static_cast<std::ptrdiff_t>(next.weight * channels));
                stretch.ray += first_ray[part];
                stretch.first_weight = static_cast<std::uint32_t>(next.weight);
                ++first_of_ray_[stretch.ray + 1];
                for (std::size_t line = 0; line < stretch.count; ++line)
                    for (int channel = 0; channel < 3; ++channel)
                        white_[stretch.ray][channel] +=
                            *(weight + static_cast<std::ptrdiff_t>(
                                           is_coloured ? 4 * line + static_cast<std::size_t>(channel) : line));
                stretches_[next.stretch++] = stretch;
                next.weight += stretch.count;
            }
            parts[part] = {};
        },
        1);
    for (std::size_t ray = 0; ray < ray_count(); ++ray)
        first_of_ray_[ray + 1] += first_of_ray_[ray];
    of_ray_.resize(stretches_.size());
    std::vector<std::uint32_t> next(first_of_ray_.begin(), first_of_ray_.end() - 1);
    for (std::uint32_t index = 0; index < stretches_.size(); ++index)
        of_ray_[next[stretches_[index].ray]++] = index;
}

std::size_t LightMapMatrix::byte_count() const {
    return weights_.size() * sizeof(float) + stretches_.size() * (sizeof(RowStretch) + sizeof(std::uint32_t)) +
           first_of_ray_.size() * sizeof(std::uint32_t);
}

void LightMapMatrix::multiply(std::span<const vec4> texels, std::span<vec4> radiance, Scratch& scratch,
                              const Progress& progress) const {
    require(texels.size() == texel_count() && radiance.size() == ray_count(), "light map: ", texels.size(),
            " texels and ", radiance.size(), " rays for a matrix of ", texel_count(), " and ", ray_count());
    const light_map_kernel::Weights weights{weights_.data(), is_coloured_, resolution_, pitch()};
    scratch.resize(stretches_.size());
    parallel_for(
        stretches_.size(), progress,
        [&](std::size_t index) { scratch[index] = light_map_kernel::read(weights, stretches_[index], texels.data()); },
        1024);
    parallel_for(
        ray_count(), progress,
        [&](std::size_t ray) {
            vec4 sum(0.0f);
            for (std::uint32_t index = first_of_ray_[ray]; index < first_of_ray_[ray + 1]; ++index)
                sum += scratch[of_ray_[index]];
            radiance[ray] = sum;
        },
        4096);
}

template <typename Add>
void LightMapMatrix::for_strips(std::span<vec4> texels, const Progress& progress, const Add& add) const {
    require(texels.size() == texel_count(), "light map: ", texels.size(), " texels for a matrix of ", texel_count());
    parallel_blocks(texels.size(), std::size_t{1} << 14, progress, [&](std::size_t begin, std::size_t end) {
        std::fill(texels.begin() + static_cast<std::ptrdiff_t>(begin),
                  texels.begin() + static_cast<std::ptrdiff_t>(end), vec4(0.0f));
    });
    const std::size_t strip_count = first_of_strip_.size() - 1;
    // A stretch along x reaches into the first row of the next strip: every other strip at a time.
    for (const std::size_t parity : {0u, 1u})
        parallel_for((strip_count + 1 - parity) / 2, progress,
                     [&](std::size_t half) {
                         const std::size_t strip = 2 * half + parity;
                         for (std::uint32_t index = first_of_strip_[strip]; index < first_of_strip_[strip + 1]; ++index)
                             add(stretches_[index]);
                     },
                     1);
}

void LightMapMatrix::multiply_transposed(std::span<const vec4> radiance, std::span<vec4> texels,
                                         const Progress& progress) const {
    const light_map_kernel::Weights weights{weights_.data(), is_coloured_, resolution_, pitch()};
    for_strips(texels, progress, [&](const RowStretch& stretch) {
        light_map_kernel::add(weights, stretch, radiance[stretch.ray], false, texels.data());
    });
}

void LightMapMatrix::square_columns(std::span<const vec4> ray_weights, std::span<vec4> texels,
                                    const Progress& progress) const {
    const light_map_kernel::Weights weights{weights_.data(), is_coloured_, resolution_, pitch()};
    for_strips(texels, progress, [&](const RowStretch& stretch) {
        light_map_kernel::add(weights, stretch, ray_weights[stretch.ray], true, texels.data());
    });
}
} // namespace tyndall::light_shafts
