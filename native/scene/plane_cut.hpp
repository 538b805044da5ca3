// SPDX-License-Identifier: GPL-3.0-or-later
// The half-plane of a view ray and its light: coordinates in it, and where it cuts a triangle.
// Based on: the dual basis of (ray, light, normal), turned into an orthonormal one: x along the ray, y from the ray
//           towards the light, height above the plane.
// Differs:  coordinates along ray and light themselves are ill-conditioned where the two are nearly parallel. Here x, y
//           and height are as exact as the positions are, and y = 0 (the ray itself) is told apart from y > 0 (towards
//           the light) before anything is divided by the small angle.
#pragma once
#include "core/math.hpp"

namespace tyndall {
/// An affine coordinate of points p: dot(direction, p) + offset.
template <typename Float>
struct Covector {
    glm::vec<3, Float> direction;
    Float offset;
    [[nodiscard]] Float operator()(const glm::vec<3, Float>& point) const {
        return glm::dot(direction, point) + offset;
    }
};

/// Plane coordinates of points of one space. An affine map of the points keeps all three values: `in_object` below.
template <typename Float>
struct PlaneCoordinates {
    Covector<Float> height, x, y;

    /// The coordinates of object-space points. Nothing is inverted: a mirrored or flattened instance is no special case.
    [[nodiscard]] PlaneCoordinates in_object(const mat4& world_from_object) const {
        const glm::mat<3, 3, Float> linear{mat3(world_from_object)};
        const glm::vec<3, Float> translation{vec3(world_from_object[3])};
        const auto pulled_back = [&](const Covector<Float>& world) {
            return Covector<Float>{world.direction * linear, world(translation)};
        };
        return {pulled_back(height), pulled_back(x), pulled_back(y)};
    }
};

/// Plane of the ray and the unit direction towards the light. `sine` and `cosine` of the angle between ray and light
/// come back; where they are parallel, the light is tilted by 1e-6 rad, 0.1 mm sideways in 100 m.
struct DirectionalPlane {
    PlaneCoordinates<double> coordinates;
    double sine, cosine;
};
[[nodiscard]] DirectionalPlane plane_towards(const vec3& ray_origin, const vec3& ray_direction,
                                             const vec3& towards_light);

/// Plane of the ray and a light at a point, which has the coordinates (light_x, light_y), light_y > 0. A light on the
/// ray's line is moved off it by 1e-6 of its distance.
struct LocalPlane {
    PlaneCoordinates<double> coordinates;
    double light_x, light_y;
};
[[nodiscard]] LocalPlane plane_through(const vec3& ray_origin, const vec3& ray_direction, const vec3& light_position);

/// Where a plane cuts a triangle: from (x0, y0) to (x1, y1).
template <typename Float>
struct CutSegment {
    Float x0, y0, x1, y1;
};

/// False where the triangle lies on one side. Heights of 0 count as above, in every triangle alike, and an edge gives
/// two neighbours the same bits in either order of its ends: cuts of a closed mesh have no gaps.
template <typename Float>
[[nodiscard]] inline bool cut_triangle(const PlaneCoordinates<Float>& plane, const glm::vec<3, Float> (&corners)[3],
                                       CutSegment<Float>& cut) {
    Float height[3], x[3], y[3];
    int above = 0;
    for (int corner = 0; corner < 3; ++corner) {
        height[corner] = plane.height(corners[corner]);
        above |= (height[corner] >= Float{0}) << corner;
    }
    if (above == 0 || above == 7)
        return false;
    for (int corner = 0; corner < 3; ++corner)
        x[corner] = plane.x(corners[corner]), y[corner] = plane.y(corners[corner]);
    // The corner that is alone on its side; both cut edges start there.
    const int lone = above == 1 || above == 6 ? 0 : above == 2 || above == 5 ? 1 : 2;
    const int next = (lone + 1) % 3, last = (lone + 2) % 3;
    const auto between = [&](const Float(&value)[3], int other) {
        return (value[other] * height[lone] - value[lone] * height[other]) / (height[lone] - height[other]);
    };
    cut = {between(x, next), between(y, next), between(x, last), between(y, last)};
    return true;
}
} // namespace tyndall
