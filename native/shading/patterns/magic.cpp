// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/patterns/magic.hpp"
#include <numbers>

namespace tyndall::patterns {
namespace {
/// Which coordinate a level replaces: by `sign` times the sine or cosine of the three coordinates' signed sum.
struct Level {
    int target;
    bool is_cosine;
    float sign, x, y, z;
};
constexpr Level levels[] = {
    {1, true, -1, 1, -1, 1},  {0, true, 1, 1, -1, -1},  {2, false, 1, -1, -1, -1}, {0, true, -1, -1, 1, -1},
    {1, false, -1, -1, 1, 1}, {1, true, -1, -1, 1, 1},  {0, true, 1, 1, 1, 1},     {2, false, 1, 1, 1, -1},
    {0, true, -1, -1, -1, 1}, {1, false, -1, 1, -1, 1},
};
} // namespace

Rgb magic(const vec3& vector, float scale, float distortion, int depth) {
    constexpr float turn = 2.0f * std::numbers::pi_v<float>;
    const vec3 at(std::fmod(vector.x, turn), std::fmod(vector.y, turn), std::fmod(vector.z, turn));
    vec3 p(std::sin((at.x + at.y + at.z) * 5.0f * scale), std::cos((-at.x + at.y - at.z) * 5.0f * scale),
           -std::cos((-at.x - at.y + at.z) * 5.0f * scale));
    if (depth > 0)
        p *= distortion;
    for (int level = 0; level < depth && level < 10; ++level) {
        const Level& by = levels[level];
        const float sum = by.x * p.x + by.y * p.y + by.z * p.z;
        p[by.target] = by.sign * (by.is_cosine ? std::cos(sum) : std::sin(sum)) * distortion;
    }
    if (distortion != 0.0f)
        p /= 2.0f * distortion;
    return 0.5f - p;
}
} // namespace tyndall::patterns
