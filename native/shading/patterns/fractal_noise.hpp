// SPDX-License-Identifier: GPL-3.0-or-later
// Octaves of gradient noise, put together in five ways.
// Based on: Musgrave, in Ebert et al., Texturing and Modeling, 3rd ed. 2003, chapter 16: fBm, multifractal, hybrid
//           multifractal, ridged multifractal, hetero terrain.
// Differs:  how strong an octave is, is told by a factor per octave (the book's lacunarity^-H); octaves need not be
//           whole: the last one counts by its share, but in the ridged one, which has none. Where Cycles starts sums
//           and weights, and after how many octaves each ends, differs between its Noise node and 3.4's Musgrave
//           node.
// Bound:    octave_count + 1 noises, all evaluated in one call.
#pragma once
#include "shading/patterns/gradient_noise.hpp"
#include <algorithm>
#include <array>

namespace tyndall::patterns {
enum class Fractal : std::uint8_t {
    Multifractal = 0,
    Fbm = 1,
    HybridMultifractal = 2,
    RidgedMultifractal = 3,
    HeteroTerrain = 4
};

struct Octaves {
    float detail = 0.0f; ///< [0, 15]: octaves less one, those of the Musgrave node less none.
    float factor = 0.5f; ///< Of each octave's strength to the one before it.
    float lacunarity = 2.0f;
    float offset = 0.0f, gain = 0.0f;
};
inline constexpr float most_detail = 15.0f;

/// Noises of a place ever finer, as many as may be asked for. Far from 0 rounding decides about an octave's place:
/// `multiplies_scale` has it multiply the scale, else the place itself.
template <int N>
class NoiseOctaves {
public:
    NoiseOctaves(Point<N> point, float lacunarity, int count, bool multiplies_scale = false) {
        std::array<Point<N>, 17> points;
        float scale = 1.0f;
        for (std::size_t octave = 0; octave < static_cast<std::size_t>(count); ++octave) {
            points[octave] = point * scale;
            if (multiplies_scale)
                scale *= lacunarity;
            else
                point *= lacunarity;
        }
        gradient_noise<N>(std::span<const Point<N>>(points.data(), static_cast<std::size_t>(count)), values_.data());
    }
    float operator[](int octave) const { return values_[static_cast<std::size_t>(octave)]; }

private:
    std::array<float, 17> values_;
};

/// Sum of the octaves, in about [-1, 1]; `is_normalized` brings it to about [0, 1], whatever the detail.
template <int N>
[[nodiscard]] float fbm(const Point<N>& point, const Octaves& octaves, bool is_normalized) {
    const int whole = static_cast<int>(octaves.detail) + 1;
    const float rest = octaves.detail - std::floor(octaves.detail);
    const NoiseOctaves<N> noise(point, octaves.lacunarity, whole + (rest != 0.0f), /*multiplies_scale=*/true);
    float sum = 0.0f, strength = 1.0f, all_strengths = 0.0f;
    for (int octave = 0; octave < whole; ++octave, strength *= octaves.factor) {
        sum += noise[octave] * strength;
        all_strengths += strength;
    }
    const auto scaled = [&](float value, float strengths) {
        return is_normalized ? 0.5f * value / strengths + 0.5f : value;
    };
    const float without_last = scaled(sum, all_strengths);
    if (rest == 0.0f)
        return without_last;
    const float with_last = scaled(sum + noise[whole] * strength, all_strengths + strength);
    return (1.0f - rest) * without_last + rest * with_last;
}

/// Those of the Noise node have `first_count` 1, of the Musgrave node 0.
template <int N>
[[nodiscard]] float fractal_noise(Fractal fractal, const Point<N>& point, const Octaves& octaves, int first_count) {
    const int whole = static_cast<int>(octaves.detail) + first_count;
    const float rest = octaves.detail - std::floor(octaves.detail), offset = octaves.offset, factor = octaves.factor;
    const bool starts_above = fractal == Fractal::RidgedMultifractal || fractal == Fractal::HeteroTerrain;
    const NoiseOctaves<N> noise(point, octaves.lacunarity, std::max(whole, starts_above ? 1 : 0) + (rest != 0.0f));
    float strength = 1.0f;
    switch (fractal) {
    case Fractal::Fbm: {
        float value = 0.0f;
        for (int octave = 0; octave < whole; ++octave, strength *= factor)
            value += noise[octave] * strength;
        return rest != 0.0f ? value + rest * noise[whole] * strength : value;
    }
    case Fractal::Multifractal: {
        float value = 1.0f;
        for (int octave = 0; octave < whole; ++octave, strength *= factor)
            value *= strength * noise[octave] + 1.0f;
        return rest != 0.0f ? value * (rest * strength * noise[whole] + 1.0f) : value;
    }
    case Fractal::HeteroTerrain: {
        float value = offset + noise[0];
        strength = factor;
        int octave = 1;
        for (; octave < whole; ++octave, strength *= factor)
            value += (noise[octave] + offset) * strength * value;
        return rest != 0.0f ? value + rest * (noise[octave] + offset) * strength * value : value;
    }
    case Fractal::HybridMultifractal: {
        float value = 0.0f, weight = 1.0f;
        int octave = 0;
        for (; octave < whole && weight > 0.001f; ++octave, strength *= factor) {
            const float signal = (noise[octave] + offset) * strength;
            weight = std::min(weight, 1.0f);
            value += weight * signal;
            weight *= octaves.gain * signal;
        }
        if (rest == 0.0f || !(weight > 0.001f))
            return value;
        return value + rest * std::min(weight, 1.0f) * ((noise[octave] + offset) * strength);
    }
    case Fractal::RidgedMultifractal: {
        const auto ridge = [&](int octave) {
            const float height = offset - std::abs(noise[octave]);
            return height * height;
        };
        float signal = ridge(0), value = signal;
        strength = factor;
        for (int octave = 1; octave < whole; ++octave, strength *= factor) {
            const float weight = std::clamp(signal * octaves.gain, 0.0f, 1.0f);
            signal = ridge(octave) * weight;
            value += signal * strength;
        }
        return value;
    }
    }
    return 0.0f;
}
} // namespace tyndall::patterns
