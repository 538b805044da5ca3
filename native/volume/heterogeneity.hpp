// SPDX-License-Identifier: GPL-3.0-or-later
// The texture of the air: how much more or less than a homogeneous medium each point scatters.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.3.
// Differs:  the noise N is divided by its mean, so that it neither darkens nor brightens the air; the paper's blend of N,
//           about 0.5 on average, with 1 darkens. Painted values are relative to the ones that hold everywhere: a slider
//           still moves all of the picture, and the border of the painted box does not show.
#pragma once
#include "core/math.hpp"
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace tyndall {
class AirNoiseCache; // air_noise.hpp

/// Perlin noise in a periodic cube of resolution^3 texels that tiles space.
struct AirNoise {
    float scale_m = 1.0f;           ///< Size of its largest features, (0, 1e6].
    std::uint32_t octaves = 5;      ///< [1, 8]; those finer than 2 texels are left out.
    float persistence = 0.5f;       ///< Weight of an octave relative to the one before, [0, 1].
    float contrast = 1.0f;          ///< 1: three deviations fill [0, 1]; higher ones cut what is beyond, [0, 10].
    std::uint32_t resolution = 256; ///< A power of two, [16, 512].
    std::uint32_t seed = 0;
};

/// Values over the unit cube, x fastest: sample i of n lies at (i + 0.5) / n. Empty: nothing is painted.
struct PaintedVolume {
    std::array<std::uint32_t, 3> size{};
    std::vector<float> values;
    [[nodiscard]] bool is_empty() const { return values.empty(); }
};

/// What is painted in a box of the air. Immutable, so that frames share it.
class PaintedAir {
public:
    /// Amounts are added, [-1, 1], levels, too, [-8, 8], intensities multiplied, [0, 1000]. Throws InvalidInput, which
    /// names the volume.
    PaintedAir(PaintedVolume amount, PaintedVolume level, PaintedVolume intensity);

    [[nodiscard]] const PaintedVolume& amount() const { return amount_; }
    [[nodiscard]] const PaintedVolume& level() const { return level_; }
    [[nodiscard]] const PaintedVolume& intensity() const { return intensity_; }
    [[nodiscard]] bool adds_amount() const { return adds_amount_; }             ///< Anywhere.
    [[nodiscard]] bool changes_level() const { return changes_level_; }         ///< Anywhere.
    [[nodiscard]] bool changes_intensity() const { return changes_intensity_; } ///< Anywhere.

private:
    PaintedVolume amount_, level_, intensity_;
    bool adds_amount_, changes_level_, changes_intensity_;
};

/// What a point x scatters relative to a homogeneous medium:
///     I(x) (a(x) N(x - moved_m, f(x)) / mean(N) + 1 - a(x)),
///     a = clamp(amount + painted, 0, 1), f = max(level + painted, 0), I = intensity * painted.
struct Heterogeneity {
    enum class Weighting : std::uint8_t {
        LitParts = 0, ///< Mean over what is lit of a ray, as it scatters.
        WholeRay = 1, ///< Over its length in media, as the paper has it.
    };
    AirNoise noise = {};
    dvec3 moved_m{0.0};     ///< How far the wind has carried the noise, in the scene's space.
    float amount = 1.0f;    ///< [0, 1]; 0: homogeneous.
    float level = 0.0f;     ///< Mip level of the noise, [0, 8]; higher ones are smoother.
    float intensity = 1.0f; ///< [0, 1000].
    Weighting weighting = Weighting::LitParts;
    std::uint32_t step_count = 64; ///< Per ray, [1, 4096].
    std::uint32_t upsampling = 1;  ///< Pixels per side that share a ray's texture, guided by depth: 1, 2, 4, 8 or 16.
    mat4 unit_from_scene{1.0f};    ///< Of the painted box; outside of it nothing is painted.
    std::shared_ptr<const PaintedAir> painted = {}; ///< Nothing: nothing is painted.
    std::shared_ptr<AirNoiseCache> kept_noise = {}; ///< Of other frames; nothing: the frame makes its own.
};

/// Throws InvalidInput, which names what is out of its range.
void require_usable(const AirNoise& noise);
void require_usable(const Heterogeneity& heterogeneity);
/// It is 1 everywhere: a picture has the bits of one without it.
[[nodiscard]] bool is_neutral(const Heterogeneity& heterogeneity);
} // namespace tyndall
