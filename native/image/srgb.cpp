// SPDX-License-Identifier: GPL-3.0-or-later
#include "image/srgb.hpp"
#include <array>
#include <cmath>

namespace tyndall {
static double curve(double encoded) {
    return encoded < 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

static constexpr int cell_count = 1024;
static const std::array<float, cell_count + 2> table = [] {
    std::array<float, cell_count + 2> values{}; // 1 is within: white is frequent
    for (int cell = 0; cell <= cell_count + 1; ++cell)
        values[static_cast<std::size_t>(cell)] = static_cast<float>(curve(static_cast<double>(cell) / cell_count));
    return values;
}();

float linear_from_srgb(float encoded) {
    const float position = encoded * cell_count;
    if (!(position >= 0.0f && position <= cell_count)) // beyond the table, or a NaN
        return static_cast<float>(curve(encoded));
    const auto cell = static_cast<std::size_t>(position);
    return table[cell] + (position - static_cast<float>(cell)) * (table[cell + 1] - table[cell]);
}

float srgb_from_linear(float linear) {
    return linear < 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}
} // namespace tyndall
