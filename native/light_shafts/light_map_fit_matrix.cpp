// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_matrix.hpp"
#include "core/parallel.hpp"
#include "light_shafts/light_map_fit_kernel.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace tyndall::light_shafts {
/// Kernels load whole vectors of weights.
static constexpr std::size_t weight_slack = 16;
/// So many dark lines between lit ones cost more than a new stretch.
static constexpr std::size_t dark_lines_to_split = 12;
/// Of the largest weight: one less than fits, as a rounded sum may take one more.
static constexpr float most_units = 65534.0f;
static constexpr float least_unit = 1e-35f; // has a reciprocal
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

/// By how much two stretches lie apart, at most, from line `first` to line `last`.
static float distance_of(const RowStretch& a, const RowStretch& b, int first, int last) {
    const auto across = [](const RowStretch& stretch, int line) {
        return stretch.across_at_first + static_cast<float>(line - stretch.first_line) * stretch.across_per_line;
    };
    return std::max(std::abs(across(a, first) - across(b, first)), std::abs(across(a, last) - across(b, last)));
}

void LightMapMatrix::append_lines(std::span<const RowStretch> stretches, float shared_texels) {
    const auto last_of = [](const RowStretch& stretch) { return stretch.first_line + stretch.count - 1; };
    for (std::size_t begin = 0, end = 0; begin < stretches.size(); begin = end) {
        const RowStretch& guide = stretches[begin];
        int first = guide.first_line, last = last_of(guide);
        for (++end; end < stretches.size(); ++end) {
            const int with_first = std::min<int>(first, stretches[end].first_line),
                      with_last = std::max(last, last_of(stretches[end]));
            if (stretches[end].goes_along_y != guide.goes_along_y ||
                !(distance_of(guide, stretches[end], with_first, with_last) <= shared_texels))
                break;
            first = with_first, last = with_last;
        }
        // That in the middle is nearest to all, as they go from one side to the other.
        const auto own = stretches.subspan(begin, end - begin);
        const RowStretch& middle = own[own.size() / 2];
        const bool is_near = std::ranges::all_of(own, [&](const RowStretch& stretch) {
            return distance_of(middle, stretch, stretch.first_line, last_of(stretch)) <= shared_texels;
        });
        const RowStretch& line = is_near ? middle : guide;
        lines_.push_back({.across_at_first =
                              line.across_at_first + static_cast<float>(first - line.first_line) * line.across_per_line,
                          .across_per_line = line.across_per_line,
                          .first_reader = static_cast<std::uint32_t>(readers_.size()),
                          .first_line = static_cast<std::uint16_t>(first),
                          .count = static_cast<std::uint16_t>(last - first + 1),
                          .goes_along_y = line.goes_along_y});
        for (const RowStretch& stretch : own)
            readers_.push_back({.ray = stretch.ray,
                                .first_weight = stretch.first_weight,
                                .offset = static_cast<std::uint16_t>(stretch.first_line - first),
                                .count = stretch.count,
                                .weight_unit = stretch.weight_unit});
    }
}

/// Of one channel: the rounded sum up to a weight less that before it, so that sums stay and what is dark stays dark. Returns
/// the sum in units.
static double round_weights(std::span<const float> weights, std::size_t channel, std::size_t channels, float per_unit,
                            std::uint16_t* rounded) {
    double sum = 0.5;
    std::int64_t before = 0;
    for (std::size_t at = channel; at < weights.size(); at += channels) {
        sum += weights[at] > 0.0f ? weights[at] * per_unit : 0.0f;
        const auto now = static_cast<std::int64_t>(sum);
        rounded[at] = static_cast<std::uint16_t>(now - before);
        before = now;
    }
    return sum - 0.5;
}

LightMapMatrix::LightMapMatrix(std::uint32_t resolution, bool is_coloured, std::vector<Part> parts,
                               const Progress& progress, float shared_texels)
    : resolution_(resolution), is_coloured_(is_coloured) {
    const std::size_t strip_count = (resolution + rows_per_strip - 1) / rows_per_strip, channels = is_coloured ? 4 : 1;
    struct Place {
        std::size_t stretch = 0, weight = 0;
    };
    std::vector<std::size_t> first_stretch;               // of each strip
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
            first_stretch.push_back(total.stretch);
        const Place counts = std::exchange(place[index], total);
        total.stretch += counts.stretch;
        total.weight += counts.weight;
    }
    require(total.weight <= UINT32_MAX, "the strokes' rays cross too many texels: fewer stroke pixels or a smaller "
                                        "resolution are needed");
    first_stretch.push_back(total.stretch);
    std::vector<RowStretch> stretches(total.stretch);
    weights_.resize((total.weight + weight_slack) * channels);
    first_of_ray_.assign(first_ray.back() + 1, 0);
    white_.assign(first_ray.back(), vec4(0.0f));
    parallel_for(
        parts.size(), progress,
        [&](std::size_t part) {
            for (RowStretch stretch : parts[part].stretches) {
                Place& next = place[stretch.strip * parts.size() + part];
                const auto own =
                    std::span(parts[part].weights).subspan(stretch.first_weight * channels, stretch.count * channels);
                stretch.weight_unit = std::max(std::ranges::max(own) / most_units, least_unit);
                vec4 sums(0.0f);
                for (std::size_t channel = 0; channel < channels; ++channel)
                    sums[static_cast<int>(channel)] = static_cast<float>(
                        stretch.weight_unit * round_weights(own, channel, channels, 1.0f / stretch.weight_unit,
                                                            &weights_[next.weight * channels]));
                stretch.ray += first_ray[part];
                stretch.first_weight = static_cast<std::uint32_t>(next.weight);
                ++first_of_ray_[stretch.ray + 1];
                white_[stretch.ray] += is_coloured ? sums : vec4(vec3(sums.x), 0.0f);
                stretches[next.stretch++] = stretch;
                next.weight += stretch.count;
            }
            parts[part] = {};
        },
        1);
    for (std::size_t ray = 0; ray < ray_count(); ++ray)
        first_of_ray_[ray + 1] += first_of_ray_[ray];
    of_ray_.resize(stretches.size());
    std::vector<std::uint32_t> next(first_of_ray_.begin(), first_of_ray_.end() - 1);
    for (std::uint32_t index = 0; index < stretches.size(); ++index)
        of_ray_[next[stretches[index].ray]++] = index;
    readers_.reserve(stretches.size());
    for (std::size_t strip = 0; strip < strip_count; ++strip) {
        first_of_strip_.push_back(static_cast<std::uint32_t>(lines_.size()));
        append_lines(
            std::span(stretches).subspan(first_stretch[strip], first_stretch[strip + 1] - first_stretch[strip]),
            shared_texels);
    }
    first_of_strip_.push_back(static_cast<std::uint32_t>(lines_.size()));
    lines_.emplace_back().first_reader = static_cast<std::uint32_t>(readers_.size());
}

std::span<const LineReader> LightMapMatrix::readers_of(std::size_t line) const {
    const std::uint32_t first = lines_[line].first_reader;
    return std::span(readers_).subspan(first, lines_[line + 1].first_reader - first);
}

std::size_t LightMapMatrix::sample_count() const {
    return std::accumulate(lines_.begin(), lines_.end(), std::size_t{0},
                           [](std::size_t sum, const MapLine& line) { return sum + line.count; });
}

std::size_t LightMapMatrix::byte_count() const {
    return weights_.size() * sizeof(std::uint16_t) + lines_.size() * sizeof(MapLine) +
           readers_.size() * (sizeof(LineReader) + sizeof(std::uint32_t)) +
           first_of_ray_.size() * sizeof(std::uint32_t);
}

void LightMapMatrix::multiply(std::span<const vec4> texels, std::span<vec4> radiance, Scratch& scratch,
                              const Progress& progress) const {
    require(texels.size() == texel_count() && radiance.size() == ray_count(), "light map: ", texels.size(),
            " texels and ", radiance.size(), " rays for a matrix of ", texel_count(), " and ", ray_count());
    const light_map_kernel::Weights weights{weights_.data(), is_coloured_, resolution_, pitch()};
    scratch.resize(readers_.size());
    parallel_for(
        lines_.size() - 1, progress,
        [&](std::size_t line) {
            light_map_kernel::read(weights, lines_[line], readers_of(line), texels.data(),
                                   scratch.data() + lines_[line].first_reader);
        },
        256);
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

void LightMapMatrix::add_to_texels(std::span<const vec4> ray_values, bool squares, std::span<vec4> texels,
                                   const Progress& progress) const {
    require(texels.size() == texel_count(), "light map: ", texels.size(), " texels for a matrix of ", texel_count());
    const light_map_kernel::Weights weights{weights_.data(), is_coloured_, resolution_, pitch()};
    parallel_blocks(texels.size(), std::size_t{1} << 14, progress, [&](std::size_t begin, std::size_t end) {
        std::fill(texels.begin() + static_cast<std::ptrdiff_t>(begin),
                  texels.begin() + static_cast<std::ptrdiff_t>(end), vec4(0.0f));
    });
    const std::size_t strip_count = first_of_strip_.size() - 1;
    // A line along x reaches into the strips beside its own: every other strip at a time.
    for (const std::size_t parity : {0u, 1u})
        parallel_for((strip_count + 1 - parity) / 2, progress,
                     [&](std::size_t half) {
                         const std::size_t strip = 2 * half + parity;
                         for (std::uint32_t line = first_of_strip_[strip]; line < first_of_strip_[strip + 1]; ++line)
                             light_map_kernel::add(weights, lines_[line], readers_of(line), ray_values.data(), squares,
                                                   texels.data());
                     },
                     1);
}

void LightMapMatrix::multiply_transposed(std::span<const vec4> radiance, std::span<vec4> texels,
                                         const Progress& progress) const {
    add_to_texels(radiance, false, texels, progress);
}

void LightMapMatrix::square_columns(std::span<const vec4> ray_weights, std::span<vec4> texels,
                                    const Progress& progress) const {
    add_to_texels(ray_weights, true, texels, progress);
}
} // namespace tyndall::light_shafts
