// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors and matrices of the whole core: GLM, column vectors, right-handed, +Z up, metres.
// Names say the spaces, so that products cancel by eye: clip_from_camera * camera_from_world.
#pragma once
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <numbers>
#include <utility>

namespace tyndall {
using glm::dvec2;
using glm::dvec3;
using glm::ivec2;
using glm::mat3;
using glm::mat4;
using glm::uvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;

inline constexpr float pi = std::numbers::pi_v<float>;

/// A value per colour channel of Blender's scene-linear space (Rec. 709 primaries): a radiance, a coefficient, an albedo.
using Rgb = glm::vec3;
/// Mean of the channels.
[[nodiscard]] inline float average(const Rgb& value) { return (value.x + value.y + value.z) * (1.0f / 3.0f); }

/// The unit vector along `v`; `otherwise` where `v` has no length, or none that is a number.
template <typename Vector>
[[nodiscard]] inline Vector unit_or(const Vector& v, const Vector& otherwise) {
    const auto length = glm::length(v);
    return length > 0 && std::isfinite(length) ? v / length : otherwise;
}

/// Axis-aligned box; empty while any min exceeds its max.
struct Bounds3 {
    vec3 min{std::numeric_limits<float>::infinity()};
    vec3 max{-std::numeric_limits<float>::infinity()};

    void grow(const vec3& point) {
        min = glm::min(min, point);
        max = glm::max(max, point);
    }
    void grow(const Bounds3& other) {
        min = glm::min(min, other.min);
        max = glm::max(max, other.max);
    }
    [[nodiscard]] bool is_empty() const { return min.x > max.x || min.y > max.y || min.z > max.z; }
    [[nodiscard]] vec3 centre() const { return 0.5f * min + 0.5f * max; }
    /// Corner 0 to 7 has the high end of axis i where bit i is set.
    [[nodiscard]] vec3 corner(std::size_t index) const {
        return {(index & 1) != 0 ? max.x : min.x, (index & 2) != 0 ? max.y : min.y, (index & 4) != 0 ? max.z : min.z};
    }
    [[nodiscard]] float diagonal_m() const { return is_empty() ? 0.0f : glm::length(max - min); }
    [[nodiscard]] bool operator==(const Bounds3&) const = default;
};

/// Two unit vectors that complete the unit vector `axis` to a right-handed frame (tangent, bitangent, axis).
/// Based on: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017.
[[nodiscard]] inline std::pair<vec3, vec3> orthonormal_basis(const vec3& axis) {
    const float sign = std::copysign(1.0f, axis.z);
    const float a = -1.0f / (sign + axis.z);
    const float b = axis.x * axis.y * a;
    return {vec3(1.0f + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
            vec3(b, sign + axis.y * axis.y * a, -axis.y)};
}
} // namespace tyndall
