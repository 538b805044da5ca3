// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/hole_noise.hpp"
#include "core/errors.hpp"
#include "core/math.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

namespace tyndall::light_shafts {
using hole_noise::Lookup;
using hole_noise::Octave;
using hole_noise::Points;

static void validate(const HoleNoise& noise) {
    require_in(noise.scale_m, std::numeric_limits<float>::min(), 1e6f, "scale_m of holes");
    require(noise.octaves >= 1 && noise.octaves <= 12, "octaves of holes is ", noise.octaves, ", outside [1, 12]");
    require_in(noise.persistence, 0.0f, 1.0f, "persistence of holes");
    require_in(noise.probability, 0.0f, 1.0f, "probability of holes");
    require_in(noise.sway, 0.0f, 100.0f, "sway of holes");
    require(std::isfinite(noise.turn_rad), "turn_rad of holes is ", noise.turn_rad);
}

/// Random bits of a seed and a number: Wellons' 32-bit mixer.
static std::uint32_t mixed(std::uint32_t seed, std::uint32_t number) {
    std::uint32_t bits = seed * 0x9E3779B1u + number;
    bits = (bits ^ (bits >> 16)) * 0x7FEB352Du;
    bits = (bits ^ (bits >> 15)) * 0x846CA68Bu;
    return bits ^ (bits >> 16);
}

/// `stream` tells the mover's octaves from the others.
static std::vector<Octave> make_octaves(const HoleNoise& noise, std::size_t dimensions, std::uint32_t stream) {
    // Components within [-1, 1] are a gradient of length 1 on average when scaled by this.
    const double of_gradient = std::sqrt(3.0 / static_cast<double>(dimensions));
    double sum = 0.0, amplitude = 1.0, cell_per_m = 1.0 / double{noise.scale_m};
    std::vector<Octave> octaves(noise.octaves);
    for (std::uint32_t i = 0; i < noise.octaves; ++i) {
        Octave& octave = octaves[i];
        // No two lattices lie alike, nor along the light's axes: turned by a golden angle more each.
        const float angle = 0.6f + 2.3999632f * static_cast<float>(i);
        mat3 lattice = mat3(glm::rotate(mat4(1.0f), angle, vec3(0, 0, 1)));
        if (dimensions == 3)
            lattice = mat3(glm::rotate(mat4(1.0f), 0.8f + angle, glm::normalize(vec3(1, 2, 3)))) * lattice;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<glm::length_t>(axis);
            for (std::size_t c = 0; c < 3; ++c)
                octave.cell_per_m[axis][c] = lattice[static_cast<glm::length_t>(c)][a] * static_cast<float>(cell_per_m);
            octave.offset[axis] =
                static_cast<float>(mixed(noise.seed, 64 * stream + 4 * i + static_cast<std::uint32_t>(axis)) >> 16) /
                4096.0f;
        }
        octave.seed = mixed(noise.seed, 64 * stream + 4 * i + 3);
        octave.amplitude = static_cast<float>(amplitude);
        sum += amplitude;
        amplitude *= double{noise.persistence};
        cell_per_m *= 2.0;
    }
    // Half way between the corners all ways from them are half a cell along each axis, and the weights' sum is 1.
    float finer_reach = 0.0f;
    for (Octave& octave : std::views::reverse(octaves)) {
        const double largest_gradient = double{octave.amplitude} / sum * of_gradient;
        octave.amplitude = static_cast<float>(largest_gradient / 2147483648.0);
        octave.reach = static_cast<float>(1.0001 * largest_gradient * 0.5 * static_cast<double>(dimensions));
        octave.finer_reach = finer_reach;
        finer_reach += octave.reach;
    }
    return octaves;
}

/// The value that `probability` of the noise lies below.
static float measure_threshold(const Lookup& lookup, const HoleNoise& noise, std::size_t dimensions) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    if (noise.probability <= 0.0f || noise.probability >= 1.0f)
        return noise.probability <= 0.0f ? -infinity : infinity;
    // Points of a Kronecker sequence (Roberts' R2 and R3) over 256 cells: most have a cell to themselves.
    constexpr std::size_t count = 16384;
    static constexpr double steps[2][3] = {{0.7548776662466927, 0.5698402909980532, 0.0},
                                           {0.8191725133961645, 0.6710436067037893, 0.5497004779019703}};
    std::vector<float> coordinates(count * dimensions), values(count);
    Points points{.columns = {}, .dimensions = dimensions, .count = count};
    for (std::size_t c = 0; c < dimensions; ++c) {
        float* column = coordinates.data() + c * count;
        points.columns[c] = column;
        double place = 0.5;
        for (std::size_t i = 0; i < count; ++i) {
            place += steps[dimensions - 2][c];
            place -= place >= 1.0 ? 1.0 : 0.0;
            column[i] = static_cast<float>((256.0 * place - 128.0) * double{noise.scale_m});
        }
    }
    Lookup still = lookup; // what moves it is independent of it, and does not change how often it has a value
    still.mover.clear();
    hole_noise::values_at(still, points, values.data());
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(noise.probability * static_cast<float>(count));
    std::nth_element(values.begin(), std::min(at, values.end() - 1), values.end());
    return *std::min(at, values.end() - 1);
}

static Lookup make_lookup(const HoleNoise& noise, std::size_t dimensions) {
    Lookup lookup;
    lookup.octaves = make_octaves(noise, dimensions, 0);
    if (noise.sway > 0.0f) {
        HoleNoise mover = noise;
        mover.octaves = std::min(noise.octaves, 2u);
        lookup.mover = make_octaves(mover, dimensions, 1);
    }
    lookup.cos_turn = static_cast<float>(std::cos(double{noise.turn_rad}));
    lookup.sin_turn = static_cast<float>(std::sin(double{noise.turn_rad}));
    const vec3 towards = dimensions == 2 ? vec3(0.8f, 0.6f, 0.0f) : vec3(0.64f, 0.48f, 0.6f);
    for (std::size_t c = 0; c < 3; ++c)
        lookup.move_m[c] = towards[static_cast<glm::length_t>(c)] * noise.sway * noise.scale_m;
    lookup.threshold = measure_threshold(lookup, noise, dimensions);
    return lookup;
}

static Points points_of(std::span<const float> x_m, std::span<const float> y_m) {
    return {.columns = {x_m.data(), y_m.data(), nullptr}, .dimensions = 2, .count = x_m.size()};
}
static Points points_of(std::span<const float> x_m, std::span<const float> y_m, std::span<const float> z_m) {
    return {.columns = {x_m.data(), y_m.data(), z_m.data()}, .dimensions = 3, .count = x_m.size()};
}

HoleNoiseField::HoleNoiseField(const HoleNoise& noise) {
    validate(noise);
    in_plane_ = make_lookup(noise, 2);
    in_space_ = make_lookup(noise, 3);
}
void HoleNoiseField::holes(std::span<const float> x_m, std::span<const float> y_m,
                           std::span<std::uint8_t> is_hole) const {
    hole_noise::holes_at(in_plane_, points_of(x_m, y_m), is_hole.data());
}
void HoleNoiseField::holes(std::span<const float> x_m, std::span<const float> y_m, std::span<const float> z_m,
                           std::span<std::uint8_t> is_hole) const {
    hole_noise::holes_at(in_space_, points_of(x_m, y_m, z_m), is_hole.data());
}
void HoleNoiseField::values(std::span<const float> x_m, std::span<const float> y_m, std::span<float> noise) const {
    hole_noise::values_at(in_plane_, points_of(x_m, y_m), noise.data());
}
void HoleNoiseField::values(std::span<const float> x_m, std::span<const float> y_m, std::span<const float> z_m,
                            std::span<float> noise) const {
    hole_noise::values_at(in_space_, points_of(x_m, y_m, z_m), noise.data());
}
} // namespace tyndall::light_shafts
