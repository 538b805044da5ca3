// SPDX-License-Identifier: GPL-3.0-or-later
// Brute-force truth for shafts: a point of a view ray is lit iff no triangle of a soup lies between it and the light,
// asked triangle by triangle in double precision.
#pragma once
#include "light_shafts/visibility.hpp"
#include "support/forest.hpp"
#include <vector>

namespace tyndall::support {
/// Triangles of `edge_m` at random places in a ball.
inline TriangleSoup make_soup(std::size_t triangle_count, float ball_radius_m, float edge_m, const vec3& centre,
                              std::uint64_t seed) {
    SceneRandom random(seed);
    TriangleSoup soup;
    for (std::size_t t = 0; t < triangle_count; ++t) {
        const vec3 middle = centre + ball_radius_m * std::cbrt(random.uniform()) * random.direction();
        const auto first = static_cast<std::uint32_t>(soup.positions.size());
        for (int corner = 0; corner < 3; ++corner)
            soup.positions.push_back(middle + edge_m * random.direction());
        soup.triangles.push_back(uvec3(first, first + 1, first + 2));
    }
    return soup;
}

/// Crosses the open segment from `from` by `step` (1 is its end) the triangle? Moeller and Trumbore, 1997.
inline bool crosses(const TriangleSoup& soup, const uvec3& triangle, const dvec3& from, const dvec3& step) {
    const dvec3 a(soup.positions[triangle.x]), ab = dvec3(soup.positions[triangle.y]) - a,
                                               ac = dvec3(soup.positions[triangle.z]) - a;
    const dvec3 p = glm::cross(step, ac);
    const double determinant = glm::dot(ab, p);
    if (determinant == 0.0)
        return false;
    const dvec3 s = from - a, q = glm::cross(s, ab);
    const double u = glm::dot(s, p) / determinant, v = glm::dot(step, q) / determinant,
                 t = glm::dot(ac, q) / determinant;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < 1.0;
}

inline bool is_lit(const TriangleSoup& soup, const LightSample& light, const dvec3& point) {
    const dvec3 step = light.is_directional ? 1e6 * dvec3(light.towards_light) : dvec3(light.position) - point;
    for (const uvec3& triangle : soup.triangles)
        if (crosses(soup, triangle, point, step))
            return false;
    return true;
}

/// Lit length of the ray, by `steps` midpoints.
inline double marched_lit_length_m(const TriangleSoup& soup, const LightSample& light, const light_shafts::ViewRay& ray,
                                   int steps) {
    const double step_m = (double{ray.far_m} - double{ray.near_m}) / steps;
    int lit = 0;
    for (int i = 0; i < steps; ++i)
        lit += is_lit(soup, light, dvec3(ray.origin) + (ray.near_m + (i + 0.5) * step_m) * dvec3(ray.direction));
    return lit * step_m;
}
} // namespace tyndall::support
