// SPDX-License-Identifier: GPL-3.0-or-later
#include "volume/air_noise.hpp"
#include "core/errors.hpp"
#include "core/huge_pages.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include <algorithm>
#include <bit>
#include <tbb/task_arena.h>

namespace tyndall {
namespace {
float fade(float t) { return t * t * t * (t * (6.0f * t - 15.0f) + 10.0f); }

/// Of one octave of gradients whose components are even within [-1, 1].
double octave_variance() {
    double fade2 = 0.0, fade2_offset2 = 0.0;
    constexpr int count = 1000;
    for (int i = 0; i < count; ++i) {
        const double t = (i + 0.5) / count, weight = 1.0 - t * t * t * (t * (6.0 * t - 15.0) + 10.0);
        fade2 += 2.0 * weight * weight / count;
        fade2_offset2 += 2.0 * weight * weight * t * t / count;
    }
    return fade2_offset2 * fade2 * fade2; // a component has variance 1/3, and there are three
}

struct Octave {
    std::uint32_t cells, texels_per_cell, seed; ///< Along a side; of a cell.
    float amplitude;
    std::vector<float> offset, fade; ///< Per texel of a cell.
};
std::vector<Octave> make_octaves(const AirNoise& noise) {
    std::vector<Octave> octaves;
    double variance = 0.0, amplitude = 1.0;
    for (std::uint32_t i = 0; i < noise.octaves; ++i) {
        const std::uint32_t cells = AirNoiseVolume::cells_per_side << i;
        if (2 * cells > noise.resolution)
            break;
        Octave octave{.cells = cells,
                      .texels_per_cell = noise.resolution / cells,
                      .seed = hash(noise.seed, i),
                      .amplitude = static_cast<float>(amplitude),
                      .offset = {},
                      .fade = {}};
        for (std::uint32_t texel = 0; texel < octave.texels_per_cell; ++texel) {
            octave.offset.push_back((static_cast<float>(texel) + 0.5f) / static_cast<float>(octave.texels_per_cell));
            octave.fade.push_back(fade(octave.offset.back()));
        }
        octaves.push_back(std::move(octave));
        variance += amplitude * amplitude;
        amplitude *= double{noise.persistence};
    }
    // At contrast 1 three deviations to either side of the middle fill [0, 255].
    const auto scale =
        static_cast<float>(127.5 / 3.0 * double{noise.contrast} / std::sqrt(variance * octave_variance()));
    for (Octave& octave : octaves)
        octave.amplitude *= scale;
    return octaves;
}

/// The gradients along a row of corners, the first of them again behind the last one.
struct GradientRow {
    std::vector<float> x, y, z;
    void assign(const Octave& octave, std::uint32_t corner_y, std::uint32_t corner_z) {
        for (std::vector<float>* const component : {&x, &y, &z})
            component->resize(octave.cells + 1);
        const std::uint32_t row = hash(octave.seed, corner_y % octave.cells, corner_z % octave.cells);
        for (std::uint32_t corner = 0; corner < octave.cells; ++corner) {
            const std::uint32_t bits = hash(row, corner), more = hash(bits);
            x[corner] = 2.0f * unit_float(bits) - 1.0f;
            y[corner] = 2.0f * unit_float(more) - 1.0f;
            z[corner] = 2.0f * unit_float(bits << 16 | more << 24 >> 16) - 1.0f;
        }
        for (std::vector<float>* const component : {&x, &y, &z})
            component->back() = component->front();
    }
};

/// A block of rows that are within one cell of the coarsest octave.
class RowBlock {
public:
    RowBlock(std::uint32_t resolution, std::uint32_t y, std::uint32_t z)
        : resolution_(resolution), side_(resolution / AirNoiseVolume::cells_per_side), y_(y), z_(z),
          values_(std::size_t{side_} * side_ * resolution, 127.5f) {}

    void add(const Octave& octave) {
        const std::uint32_t cells = side_ / octave.texels_per_cell;
        for (std::uint32_t z = 0; z < cells; ++z)
            for (std::uint32_t y = 0; y < cells; ++y)
                add_cells(octave, y, z);
    }
    void store(std::span<std::uint8_t> texels) const {
        for (std::uint32_t z = 0; z < side_; ++z)
            for (std::uint32_t y = 0; y < side_; ++y) {
                const float* const from = &values_[std::size_t{z * side_ + y} * resolution_];
                std::uint8_t* const to =
                    &texels[(std::size_t{z_ * side_ + z} * resolution_ + y_ * side_ + y) * resolution_];
                for (std::uint32_t x = 0; x < resolution_; ++x)
                    to[x] = static_cast<std::uint8_t>(std::min(std::max(from[x], 0.0f), 255.0f) + 0.5f);
            }
    }

private:
    /// A row of cells, of which this is the one at (cell_y, cell_z) of the block.
    void add_cells(const Octave& octave, std::uint32_t cell_y, std::uint32_t cell_z) {
        const std::uint32_t texels = octave.texels_per_cell, per_block = side_ / texels;
        for (std::uint32_t corner = 0; corner < 4; ++corner)
            gradients_[corner].assign(octave, y_ * per_block + cell_y + corner % 2,
                                      z_ * per_block + cell_z + corner / 2);
        for (std::uint32_t z = 0; z < texels; ++z)
            for (std::uint32_t y = 0; y < texels; ++y) {
                find_corners(octave, y, z);
                const std::size_t row = std::size_t{cell_z * texels + z} * side_ + cell_y * texels + y;
                add_row(octave, &values_[row * resolution_]);
            }
    }
    /// What the corners of a row give along it, faded in y and z: value + slope * offset.
    void find_corners(const Octave& octave, std::uint32_t y, std::uint32_t z) {
        value_.assign(octave.cells + 1, 0.0f);
        slope_.assign(octave.cells + 1, 0.0f);
        for (std::uint32_t corner = 0; corner < 4; ++corner) {
            const bool upper_y = corner % 2 == 1, upper_z = corner / 2 == 1;
            const float weight = octave.amplitude * (upper_y ? octave.fade[y] : 1.0f - octave.fade[y]) *
                                 (upper_z ? octave.fade[z] : 1.0f - octave.fade[z]);
            const float along_y = weight * (octave.offset[y] - (upper_y ? 1.0f : 0.0f));
            const float along_z = weight * (octave.offset[z] - (upper_z ? 1.0f : 0.0f));
            const GradientRow& gradient = gradients_[corner];
            for (std::size_t at = 0; at <= octave.cells; ++at) {
                value_[at] += along_y * gradient.y[at] + along_z * gradient.z[at];
                slope_[at] += weight * gradient.x[at];
            }
        }
    }
    void add_row(const Octave& octave, float* values) const {
        const std::size_t texels = octave.texels_per_cell;
        for (std::size_t cell = 0; cell < octave.cells; ++cell, values += texels) {
            const float value = value_[cell], slope = slope_[cell];
            const float value_after = value_[cell + 1] - slope_[cell + 1], slope_after = slope_[cell + 1];
            for (std::size_t x = 0; x < texels; ++x) {
                const float before = value + slope * octave.offset[x];
                const float after = value_after + slope_after * octave.offset[x];
                values[x] += before + octave.fade[x] * (after - before);
            }
        }
    }

    std::uint32_t resolution_, side_, y_, z_;
    std::vector<float> values_;
    std::array<GradientRow, 4> gradients_;
    std::vector<float> value_, slope_;
};

std::vector<std::uint8_t> halved(std::span<const std::uint8_t> texels, std::uint32_t side, const Progress& progress) {
    const std::size_t half = side / 2;
    std::vector<std::uint8_t> result(half * half * half);
    parallel_for(
        half * half, progress,
        [&](std::size_t row) {
            const std::size_t z = row / half, y = row % half;
            const std::uint8_t* const from = &texels[(2 * z * side + 2 * y) * side];
            const std::size_t up = side, behind = std::size_t{side} * side;
            for (std::size_t x = 0; x < half; ++x) {
                const auto pair = [&](std::size_t at) { return unsigned{from[at]} + from[at + 1]; };
                const unsigned sum = pair(2 * x) + pair(2 * x + up) + pair(2 * x + behind) + pair(2 * x + behind + up);
                result[row * half + x] = static_cast<std::uint8_t>((sum + 4) / 8);
            }
        },
        64);
    return result;
}

float mean_of(std::span<const std::uint8_t> texels, const Progress& progress) {
    const auto sum = parallel_sum(texels.size(), 1 << 16, std::uint64_t{0}, progress, [&](std::size_t begin, auto end) {
        std::uint64_t part = 0;
        for (std::size_t at = begin; at < end; ++at)
            part += texels[at];
        return part;
    });
    return sum == 0 ? 1.0f : static_cast<float>(static_cast<double>(sum) / static_cast<double>(texels.size()));
}
} // namespace

AirNoiseVolume::AirNoiseVolume(const AirNoise& noise, const Progress& progress) : noise_(noise) {
    require_usable(noise);
    const std::uint32_t resolution = noise.resolution;
    std::vector<std::uint8_t> texels(std::size_t{resolution} * resolution * resolution);
    const std::vector<Octave> octaves = make_octaves(noise);
    parallel_for(
        std::size_t{cells_per_side} * cells_per_side, progress,
        [&](std::size_t index) {
            RowBlock block(resolution, static_cast<std::uint32_t>(index % cells_per_side),
                           static_cast<std::uint32_t>(index / cells_per_side));
            for (const Octave& octave : octaves)
                block.add(octave);
            block.store(texels);
        },
        1);
    for (std::uint32_t side = resolution;; side /= 2) {
        const float mean = mean_of(texels, progress);
        std::vector<std::uint8_t> next = side > 1 ? halved(texels, side, progress) : std::vector<std::uint8_t>();
        levels_.push_back({std::move(texels), mean});
        if (side == 1)
            break;
        texels = std::move(next);
    }
    std::uint32_t first = 0;
    for (std::uint32_t level = level_count(); level-- > 0; first += side(level) * side(level) * side(level))
        packed_.push_back({.first = first,
                           .side_bits = static_cast<std::uint32_t>(std::countr_zero(side(level))),
                           .scale = 1.0f / levels_[level].mean});
    std::ranges::reverse(packed_);
    corners_ = std::make_unique_for_overwrite<std::uint64_t[]>(first);
    prefer_huge_pages(corners_.get(), first * sizeof(std::uint64_t));
}

std::span<const air_noise::PackedLevel> AirNoiseVolume::packed(std::uint32_t finest_level) const {
    if (finest_level >= finest_packed_.load(std::memory_order_acquire))
        return packed_;
    for (std::uint32_t level = finest_level; level < level_count(); ++level)
        std::call_once(is_packed_[level], [&] {
            // A thread that waits for the others here must not begin what waits for this level, too.
            tbb::this_task_arena::isolate([&] { pack(level); });
        });
    std::uint32_t before = finest_packed_.load(std::memory_order_relaxed);
    while (finest_level < before &&
           !finest_packed_.compare_exchange_weak(before, finest_level, std::memory_order_release))
        ;
    return packed_;
}

void AirNoiseVolume::pack(std::uint32_t level) const {
    const std::size_t count = side(level);
    const std::span<const std::uint8_t> from = texels(level);
    std::uint64_t* const to = corners_.get() + packed_[level].first;
    parallel_for(
        count * count, Progress(),
        [&](std::size_t row) {
            const std::size_t z = row / count, y = row % count, above = (y + 1) % count, behind = (z + 1) % count;
            const std::array<const std::uint8_t*, 4> rows{
                &from[(z * count + y) * count], &from[(z * count + above) * count], &from[(behind * count + y) * count],
                &from[(behind * count + above) * count]};
            for (std::size_t x = 0; x < count; ++x) {
                const std::size_t right = (x + 1) % count;
                std::uint64_t cell = 0;
                for (std::size_t pair = 0; pair < 4; ++pair)
                    cell |= (std::uint64_t{rows[pair][x]} | std::uint64_t{rows[pair][right]} << 8) << (16 * pair);
                to[row * count + x] = cell;
            }
        },
        64);
}

bool AirNoiseVolume::is_of(const AirNoise& noise) const {
    return noise.octaves == noise_.octaves && noise.persistence == noise_.persistence &&
           noise.contrast == noise_.contrast && noise.resolution == noise_.resolution && noise.seed == noise_.seed;
}

std::shared_ptr<const AirNoiseVolume> AirNoiseCache::find_or_make(const AirNoise& noise, const Progress& progress) {
    {
        const std::scoped_lock lock(mutex_);
        const auto found = std::ranges::find_if(volumes_, [&](const auto& volume) { return volume->is_of(noise); });
        if (found != volumes_.end()) {
            std::rotate(volumes_.begin(), found, found + 1);
            return volumes_.front();
        }
    }
    auto made = std::make_shared<const AirNoiseVolume>(noise, progress);
    const std::scoped_lock lock(mutex_);
    volumes_.insert(volumes_.begin(), made);
    volumes_.resize(std::min(volumes_.size(), capacity));
    return made;
}

float AirNoiseVolume::relative_at(const dvec3& place, std::uint32_t level) const {
    const std::size_t count = side(level);
    std::array<std::array<std::size_t, 2>, 3> texel;
    std::array<std::array<float, 2>, 3> share;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double along = place[static_cast<glm::length_t>(axis)];
        const double at = (along - std::floor(along)) * static_cast<double>(count) - 0.5, before = std::floor(at);
        texel[axis][0] = static_cast<std::size_t>(before + static_cast<double>(count)) % count;
        texel[axis][1] = (texel[axis][0] + 1) % count;
        share[axis][1] = static_cast<float>(at - before);
        share[axis][0] = 1.0f - share[axis][1];
    }
    float sum = 0.0f;
    for (std::size_t z = 0; z < 2; ++z)
        for (std::size_t y = 0; y < 2; ++y)
            for (std::size_t x = 0; x < 2; ++x)
                sum += share[0][x] * share[1][y] * share[2][z] *
                       static_cast<float>(
                           levels_[level].texels[(texel[2][z] * count + texel[1][y]) * count + texel[0][x]]);
    return sum / levels_[level].mean;
}
} // namespace tyndall
