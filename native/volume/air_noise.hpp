// SPDX-License-Identifier: GPL-3.0-or-later
// Perlin noise in a periodic cube, with its mip pyramid: what the air is textured with.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.3 and eq. 5.5; Perlin 2002, "Improving noise", the quintic fade.
// Differs:  5.5 as printed has no frequency in it: this is the sum of p^i P(2^i q) over the sum of p^i, three deviations of
//           which fill [0, 1], so that its contrast is the same whatever the octaves. Lattices have whole numbers of cells in
//           the cube: it tiles space. Components of gradients are evenly distributed, whose second moments, all that a
//           mean along a ray shows, know no direction. Mip levels are box-filtered; each is told with the mean that its
//           8 bits have, so that N / mean(N) keeps the light to rounding at every level.
// Bound:    1.15 bytes per texel, and 8 more at each level that steps are fine enough for; 5 operations per texel and
//           octave: along a row between two corners the noise is one cubic in the fade, whose coefficients are shared
//           by the row's texels.
#pragma once
#include "core/progress.hpp"
#include "volume/air_noise_kernel.hpp"
#include "volume/heterogeneity.hpp"
#include <array>
#include <atomic>
#include <mutex>
#include <span>
#include <vector>

namespace tyndall {
class AirNoiseVolume {
public:
    /// Cells of the coarsest octave along a side of the cube, which is so many times scale_m long.
    static constexpr std::uint32_t cells_per_side = 8;

    /// `noise.scale_m` is not part of it. Throws InvalidInput, which names the culprit, and Cancelled.
    AirNoiseVolume(const AirNoise& noise, const Progress& progress);

    [[nodiscard]] bool is_of(const AirNoise& noise) const;
    [[nodiscard]] std::uint32_t level_count() const { return static_cast<std::uint32_t>(levels_.size()); }
    /// Texels along a side.
    [[nodiscard]] std::uint32_t side(std::uint32_t level) const { return noise_.resolution >> level; }
    /// x fastest; texel i of n lies at (i + 0.5) / n of the cube.
    [[nodiscard]] std::span<const std::uint8_t> texels(std::uint32_t level) const { return levels_[level].texels; }
    /// Levels from this one to the coarsest, as the loops read them; what was not asked for yet is packed first. Safe from
    /// any thread.
    [[nodiscard]] std::span<const air_noise::PackedLevel> packed(std::uint32_t finest_level) const;
    [[nodiscard]] const std::uint64_t* corners() const { return corners_.get(); }
    /// In texels' units, [0, 255]; 1 of a noise without any value.
    [[nodiscard]] float mean(std::uint32_t level) const { return levels_[level].mean; }
    /// N / mean(N) between texels, trilinear; `place` in cubes, whatever its whole part.
    [[nodiscard]] float relative_at(const dvec3& place, std::uint32_t level) const;

private:
    struct Level {
        std::vector<std::uint8_t> texels;
        float mean = 1.0f;
    };
    void pack(std::uint32_t level) const;

    static constexpr std::size_t most_levels = 10;
    AirNoise noise_;
    std::vector<Level> levels_;
    std::vector<air_noise::PackedLevel> packed_; ///< Finest first.
    std::unique_ptr<std::uint64_t[]> corners_;   ///< Coarsest first; pages that are not packed take no memory.
    mutable std::array<std::once_flag, most_levels> is_packed_;
    mutable std::atomic<std::uint32_t> finest_packed_ = most_levels; ///< All levels from it on are.
};

/// The volumes that were asked for last, for frames whose noise stays as it is. Safe from any thread.
class AirNoiseCache {
public:
    /// Throws as the volume's constructor does.
    [[nodiscard]] std::shared_ptr<const AirNoiseVolume> find_or_make(const AirNoise& noise, const Progress& progress);

private:
    static constexpr std::size_t capacity = 2; ///< A viewport and a render.
    std::mutex mutex_;
    std::vector<std::shared_ptr<const AirNoiseVolume>> volumes_; ///< The last one comes first.
};
} // namespace tyndall
