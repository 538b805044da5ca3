// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/cielab.hpp"
#include <algorithm>
#include <array>

namespace tyndall::voxel_dag {
static constexpr double epsilon = 216.0 / 24389.0, kappa = 24389.0 / 27.0; // where the cube root begins, as fractions
/// Rows: X, Y, Z of red, green and blue, D65. White is their sum, so that grey has no chroma.
static constexpr double xyz_from_rgb[3][3] = {
    {0.4124564, 0.3575761, 0.1804375}, {0.2126729, 0.7151522, 0.0721750}, {0.0193339, 0.1191920, 0.9503041}};
static constexpr double rgb_from_xyz[3][3] = {
    {3.2404542, -1.5371385, -0.4985314}, {-0.9692660, 1.8760108, 0.0415560}, {0.0556434, -0.2040259, 1.0572252}};

static const std::array<double, 256>& linear_of_byte() {
    static const std::array<double, 256> table = [] {
        std::array<double, 256> linear{};
        for (int byte = 0; byte < 256; ++byte) {
            const double value = byte / 255.0;
            linear[static_cast<std::size_t>(byte)] =
                value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
        }
        return linear;
    }();
    return table;
}
static double white(int row) { return xyz_from_rgb[row][0] + xyz_from_rgb[row][1] + xyz_from_rgb[row][2]; }

Lab lab_of(PackedColor color) {
    const std::array<double, 256>& linear = linear_of_byte();
    const double rgb[3] = {linear[color >> 16 & 255], linear[color >> 8 & 255], linear[color & 255]};
    double f[3];
    for (int row = 0; row < 3; ++row) {
        const double* const from = xyz_from_rgb[row];
        const double share = (from[0] * rgb[0] + from[1] * rgb[1] + from[2] * rgb[2]) / white(row);
        f[row] = share > epsilon ? std::cbrt(share) : (kappa * share + 16.0) / 116.0;
    }
    return {116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])};
}

PackedColor color_of(const Lab& lab) {
    const double fy = (lab.lightness + 16.0) / 116.0, f[3] = {fy + lab.a / 500.0, fy, fy - lab.b / 200.0};
    double xyz[3];
    for (int row = 0; row < 3; ++row) {
        const double cube = f[row] * f[row] * f[row];
        xyz[row] = white(row) * (cube > epsilon ? cube : (116.0 * f[row] - 16.0) / kappa);
    }
    PackedColor color = 0;
    for (const auto& from : rgb_from_xyz) {
        const double linear = std::clamp(from[0] * xyz[0] + from[1] * xyz[1] + from[2] * xyz[2], 0.0, 1.0);
        const double value = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
        color = color << 8 | static_cast<PackedColor>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
    }
    return color;
}

Cie94From::Cie94From(const Lab& original) : lab(original), chroma(std::hypot(original.a, original.b)) {
    const double in_chroma = 1.0 + 0.045 * chroma, in_hue = 1.0 + 0.015 * chroma;
    chroma_weight = 1.0 / (in_chroma * in_chroma);
    hue_weight = 1.0 / (in_hue * in_hue);
}
double Cie94From::squared(const Lab& other) const {
    const double lightness = lab.lightness - other.lightness, a = lab.a - other.a, b = lab.b - other.b;
    const double in_chroma = chroma - std::hypot(other.a, other.b);
    const double hue = std::max(0.0, a * a + b * b - in_chroma * in_chroma); // rounding takes it below 0
    return lightness * lightness + chroma_weight * in_chroma * in_chroma + hue_weight * hue;
}
double cie94(const Lab& original, const Lab& other) { return std::sqrt(Cie94From(original).squared(other)); }
} // namespace tyndall::voxel_dag
