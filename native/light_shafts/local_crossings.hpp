// SPDX-License-Identifier: GPL-3.0-or-later
// Boundaries of media between a view ray and a local light.
// Bound:    a fog box that holds both: none, by two tests of a point. A box that holds the ray: its face with the least
//           share of the way, of 3. Another box: at most 6 lines in the plane of ray and light. A mesh: one per triangle
//           that the plane cuts.
#pragma once
#include "light_shafts/local_rays.hpp"
#include "scene/media.hpp"
#include "scene/plane_cut.hpp"
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// A plane between the light and a part of the ray, met at the share n / d of the way from the ray to the light.
struct LocalCrossing {
    double near_m, far_m; ///< Where on the ray the light casts it.
    dvec2 n, d;           ///< At the ray's origin, and per metre along it.
    dvec3 signed_sigma_t; ///< Positive where the way to the light leaves the medium.
};

/// The boundaries of a scene's media as one light sees them.
class LightSideBoundaries {
public:
    LightSideBoundaries(const Media& media, const vec3& light_position);
    /// Nothing lies between the light and this part of a ray: all boundaries are boxes that hold both.
    [[nodiscard]] bool is_clear(const LocalRays& rays, std::size_t index, const ViewRay& part) const;
    /// Appends what lies between the light and the ray.
    void append_crossings(const ViewRay& ray, std::vector<LocalCrossing>& crossings) const;

private:
    struct Boundary {
        const MediumBoundary* boundary;
        dvec3 light_in_object;
        dvec3 sigma_t;
        bool holds_light; ///< A box that does.
    };
    static void append_box_crossings(const Boundary& boundary, const ViewRay& ray,
                                     std::vector<LocalCrossing>& crossings);
    void append_cut_crossings(const Boundary& boundary, const ViewRay& ray, const LocalPlane& plane,
                              std::vector<LocalCrossing>& crossings) const;

    const Media& media_;
    vec3 light_position_;
    std::vector<Boundary> boundaries_;
    bool all_hold_light_ = true;
};
} // namespace tyndall::light_shafts
