// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/instance_places.hpp"
#include "scene/embree.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
bool is_regular(const mat4& matrix) {
    const glm::dmat3 linear{mat3(matrix)};
    const double axes = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
    return std::abs(glm::determinant(linear)) > 1e-12 * axes;
}

mat4 thickened(const mat4& scene_from_object) {
    const glm::dmat3 linear{mat3(scene_from_object)};
    if (is_regular(scene_from_object))
        return scene_from_object;
    // The columns of the adjugate of a matrix of rank 2 are what it sends to 0, its rows what no image has a share of.
    const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                               glm::cross(linear[0], linear[1]));
    const auto longest = [](const glm::dmat3& matrix) {
        const auto shorter = [](const dvec3& a, const dvec3& b) { return glm::dot(a, a) < glm::dot(b, b); };
        return std::max({matrix[0], matrix[1], matrix[2]}, shorter);
    };
    const dvec3 lost = longest(glm::transpose(cofactors)), normal = longest(cofactors);
    const double width = glm::length(longest(linear));
    if (!(glm::length(lost) > 1e-12 * width * width))
        return scene_from_object;
    const glm::dmat3 thick = linear + glm::outerProduct(glm::normalize(normal), 1e-6 * width * glm::normalize(lost));
    mat4 result{mat3(thick)};
    result[3] = scene_from_object[3];
    return result;
}

bool is_finite(const mat4& scene_from_object) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row)
            if (!(std::abs(scene_from_object[column][row]) < largest_coordinate_m)) // true for a NaN, too
                return false;
    return true;
}

/// Embree takes rays into the object's space, where they must not leave what it reckons with.
static constexpr double largest_in_object = 1.8e18, largest_inverse = 1e13;

static bool takes_rays(const mat4& scene_from_object) {
    const glm::dmat4 inverse = glm::inverse(glm::dmat4(scene_from_object));
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row)
            if (!(std::abs(inverse[column][row]) < (column < 3 ? largest_inverse : double{largest_coordinate_m})))
                return false;
    return true;
}

const char* reason_to_drop(const mat4& scene_from_object) {
    if (!is_finite(scene_from_object))
        return "its transform is not finite";
    if (!is_regular(scene_from_object))
        return "its transform leaves no more than a line of it (scales of 0)";
    if (!takes_rays(scene_from_object))
        return "it is too small for rays (scales below 1e-13)";
    return nullptr;
}

float reach_m(const mat4& object_from_scene) {
    double reach = double{largest_coordinate_m};
    for (int row = 0; row < 3; ++row) {
        double growth = 0.0;
        for (int column = 0; column < 3; ++column)
            growth += std::abs(double{object_from_scene[column][row]});
        reach = std::min(reach, (largest_in_object - std::abs(double{object_from_scene[3][row]})) / growth);
    }
    return static_cast<float>(reach);
}

mat4 inverse_of(const mat4& scene_from_object) { return mat4(glm::inverse(glm::dmat4(scene_from_object))); }
} // namespace tyndall
