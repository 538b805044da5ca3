// SPDX-License-Identifier: GPL-3.0-or-later
// Based on: Arvo 1995, figure 2; the solid angle by Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983.
#include "render/mesh_emitters.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::render {
/// Below it, places are spread over the area: their distances differ by little, and doubles would lose digits.
static constexpr double least_wide_sr = 1e-3;

namespace {
struct SeenTriangle {
    dvec3 a, b, c; ///< Unit, from the point.
    double solid_angle_sr;

    SeenTriangle(const std::array<vec3, 3>& corners, const vec3& from)
        : a(glm::normalize(dvec3(corners[0]) - dvec3(from))), b(glm::normalize(dvec3(corners[1]) - dvec3(from))),
          c(glm::normalize(dvec3(corners[2]) - dvec3(from))) {
        const double volume = std::abs(glm::dot(a, glm::cross(b, c)));
        const double sum = 1.0 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a);
        solid_angle_sr = 2.0 * std::atan2(volume, sum);
    }
    [[nodiscard]] bool is_wide() const { return solid_angle_sr > least_wide_sr && solid_angle_sr < 6.28; }

    [[nodiscard]] dvec3 direction(vec2 u) const {
        const auto angle_at = [](const dvec3& at, const dvec3& p, const dvec3& q) {
            const dvec3 x = p - glm::dot(p, at) * at, y = q - glm::dot(q, at) * at;
            return std::atan2(glm::length(glm::cross(x, y)), glm::dot(x, y));
        };
        const double alpha = angle_at(a, b, c), part = double{u.x} * solid_angle_sr;
        const double s = std::sin(part - alpha), t = std::cos(part - alpha);
        const double cos_alpha = std::cos(alpha), sin_alpha = std::sin(alpha), cos_c = glm::dot(a, b);
        const double p = t - cos_alpha, q = s + sin_alpha * cos_c;
        const double over = (q * t - p * s) * cos_alpha - q, under = (q * s + p * t) * sin_alpha;
        const double along = std::abs(under) > 0.0 ? std::clamp(over / under, -1.0, 1.0) : 1.0;
        const auto towards = [](const dvec3& of, const dvec3& from_unit) {
            const dvec3 across = of - glm::dot(of, from_unit) * from_unit;
            const double length = glm::length(across);
            return length > 0.0 ? across / length : dvec3(0.0);
        };
        const dvec3 on_edge = along * a + std::sqrt(std::max(0.0, 1.0 - along * along)) * towards(c, a);
        const double z = 1.0 - double{u.y} * (1.0 - glm::dot(on_edge, b));
        return z * b + std::sqrt(std::max(0.0, 1.0 - z * z)) * towards(on_edge, b);
    }
};
} // namespace

/// Of a place that is spread over the area.
static float pdf_of_area(const std::array<vec3, 3>& corners, const vec3& from, const vec3& place) {
    const vec3 way = place - from;
    const float distance2 = glm::dot(way, way);
    const vec3 twice_area = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const float projected = 0.5f * std::abs(glm::dot(twice_area, way)) / std::sqrt(distance2);
    return projected > 0.0f ? distance2 / projected : 0.0f;
}

TrianglePoint triangle_point(const std::array<vec3, 3>& corners, const vec3& from, vec2 u) {
    const SeenTriangle seen(corners, from);
    if (!seen.is_wide()) {
        const float root = std::sqrt(u.x);
        const vec2 at(root * (1.0f - u.y), root * u.y);
        const vec3 position = corners[0] + at.x * (corners[1] - corners[0]) + at.y * (corners[2] - corners[0]);
        return {position, at, pdf_of_area(corners, from, position)};
    }
    const dvec3 direction = seen.direction(u);
    const dvec3 origin = dvec3(from) - dvec3(corners[0]);
    const dvec3 first(corners[1] - corners[0]), second(corners[2] - corners[0]);
    const dvec3 across = glm::cross(direction, second);
    const double determinant = glm::dot(first, across);
    if (!(std::abs(determinant) > 0.0))
        return {};
    const double x = glm::dot(origin, across) / determinant,
                 y = glm::dot(direction, glm::cross(origin, first)) / determinant;
    const vec2 at(static_cast<float>(std::clamp(x, 0.0, 1.0)),
                  static_cast<float>(std::clamp(y, 0.0, 1.0 - std::clamp(x, 0.0, 1.0))));
    return {corners[0] + at.x * (corners[1] - corners[0]) + at.y * (corners[2] - corners[0]), at,
            static_cast<float>(1.0 / seen.solid_angle_sr)};
}

float triangle_pdf_per_sr(const std::array<vec3, 3>& corners, const vec3& from, const vec3& place) {
    const SeenTriangle seen(corners, from);
    return seen.is_wide() ? static_cast<float>(1.0 / seen.solid_angle_sr) : pdf_of_area(corners, from, place);
}
} // namespace tyndall::render
