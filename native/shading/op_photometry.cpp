// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_photometry.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tyndall {
namespace {
constexpr float most_angles = 1e5f;

/// The angles and columns of a table.
struct Table {
    std::span<const vec4> across, down, columns;

    explicit Table(std::span<const vec4> values) {
        const auto h = static_cast<std::size_t>(values[0].x), v = static_cast<std::size_t>(values[0].y);
        across = values.subspan(1, h);
        down = values.subspan(1 + h, v);
        columns = values.subspan(1 + h + v);
    }
};

bool is_rising(std::span<const vec4> angles) {
    return std::ranges::is_sorted(angles, std::ranges::less_equal{}, &vec4::x);
}

/// Between which two angles another one lies, and how far along; nothing outside of them.
struct Place {
    std::size_t index = 0;
    float share = 0.0f;
    bool is_inside = false;
};
Place place_of(float angle, std::span<const vec4> angles) {
    if (!(angle >= angles.front().x && angle < angles.back().x))
        return {};
    const auto next = std::ranges::upper_bound(angles, angle, {}, &vec4::x);
    const float before = std::prev(next)->x;
    return {static_cast<std::size_t>(next - angles.begin()) - 1, (angle - before) / (next->x - before), true};
}

/// From the second of four values, evenly apart, to the third.
float curve(const vec4& values, float share) {
    const auto [a, b, c, d] = std::array{values.x, values.y, values.z, values.w};
    return b + 0.5f * share * (c - a + share * (2.0f * a - 5.0f * b + 4.0f * c - d + share * (3.0f * (b - c) + d - a)));
}
} // namespace

bool is_photometry(std::span<const vec4> table) {
    if (table.empty() || !(table[0].x >= 2.0f && table[0].x < most_angles) ||
        !(table[0].y >= 2.0f && table[0].y < most_angles))
        return false;
    const auto h = static_cast<std::size_t>(table[0].x), v = static_cast<std::size_t>(table[0].y);
    if (table.size() != 1 + h + v + (h + 2) * (v - 1))
        return false;
    const Table read(table);
    return is_rising(read.across) && is_rising(read.down);
}

float photometric_value(std::span<const vec4> table, const vec3& vector) {
    const vec3 unit = unit_or(vector, vec3(0.0f));
    const Table read(table);
    const Place down = place_of(std::acos(std::clamp(-unit.z, -1.0f, 1.0f)), read.down);
    const Place across = place_of(std::atan2(unit.x, unit.y) + std::numbers::pi_v<float>, read.across);
    if (!down.is_inside || !across.is_inside)
        return 0.0f;
    vec4 columns;
    for (int column = 0; column < 4; ++column)
        columns[column] =
            curve(read.columns[(across.index + static_cast<std::size_t>(column)) * (read.down.size() - 1) + down.index],
                  down.share);
    return std::max(curve(columns, across.share), 0.0f);
}
} // namespace tyndall
