// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/sheen.hpp"

namespace tyndall::sheen {
Shape shape(float roughness, float view_cosine) {
    constexpr float last = node_count - 1;
    const float row = std::clamp(roughness, least_roughness, 1.0f) * last,
                column = std::clamp(view_cosine, 0.0f, 1.0f) * last;
    const auto y = std::min(static_cast<std::size_t>(row), node_count - 2),
               x = std::min(static_cast<std::size_t>(column), node_count - 2);
    const float down = row - static_cast<float>(y), right = column - static_cast<float>(x);
    const auto between = [&](std::size_t number) {
        const auto in_row = [&](std::size_t index) {
            const auto before = static_cast<float>(table[index][x][number]),
                       after = static_cast<float>(table[index][x + 1][number]);
            return before + (after - before) * right;
        };
        const float upper = in_row(y);
        return (upper + (in_row(y + 1) - upper) * down) * 1e-5f;
    };
    constexpr float least_a = 1e-4f; // where nothing comes back there is none
    return {std::max(between(0), least_a), between(1), between(2)};
}
} // namespace tyndall::sheen
