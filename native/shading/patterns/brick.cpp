// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/patterns/brick.hpp"
#include <algorithm>

namespace tyndall::patterns {
/// In [0, 1].
static float integer_noise(std::uint32_t key) {
    key = (key + 1013u) & 0x7fffffffu;
    key ^= key >> 13;
    const std::uint32_t mixed = (key * (key * key * 60493u + 19990303u) + 1376312589u) & 0x7fffffffu;
    return 0.5f * (static_cast<float>(mixed) / 1073741824.0f);
}
/// Of a quotient that may be of any size, or of nothing.
static std::int32_t whole(float value) {
    return std::abs(value) < 2147483000.0f ? static_cast<std::int32_t>(std::floor(value)) : 0;
}

Brick brick(const vec3& vector, const BrickConfig& config) {
    const vec3 at = vector * config.scale;
    const std::int32_t row = whole(at.y / config.row_height);
    float width = config.brick_width, start = 0.0f;
    if (config.offset_frequency != 0 && config.squash_frequency != 0) {
        if (row % config.squash_frequency == 0)
            width *= config.squash;
        if (row % config.offset_frequency == 0)
            start = width * config.offset;
    }
    const std::int32_t column = whole((at.x + start) / width);
    const float x = at.x + start - width * static_cast<float>(column);
    const float y = at.y - config.row_height * static_cast<float>(row);
    const std::uint32_t key = (static_cast<std::uint32_t>(row) << 16) + (static_cast<std::uint32_t>(column) & 0xffffu);
    Brick result{.tint = std::clamp(integer_noise(key) + config.bias, 0.0f, 1.0f), .mortar_share = 0.0f};
    const float to_edge = std::min(std::min(x, y), std::min(width - x, config.row_height - y));
    if (to_edge >= config.mortar_size)
        return result;
    result.mortar_share = 1.0f;
    const float depth = 1.0f - to_edge / config.mortar_size;
    if (config.mortar_smooth != 0.0f && depth < config.mortar_smooth) {
        const float t = std::clamp(depth / config.mortar_smooth, 0.0f, 1.0f);
        result.mortar_share = t * t * (3.0f - 2.0f * t);
    }
    return result;
}
} // namespace tyndall::patterns
