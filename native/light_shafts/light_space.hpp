// SPDX-License-Identifier: GPL-3.0-or-later
// Where the texels of a light's depth map lie in the light's own space, in which its noise and its masks are fixed: they
// stay where they are while the camera moves, and go with the light.
// Differs:  the paper's noise is fixed to the texels of its one sun's map (section 5.4.1). A lamp's is one of directions, in
//           three dimensions, so that the faces of a cube have no seams. The strata of a light with a size look from
//           different places: they meet in the plane, or on the sphere, through what is edited.
#pragma once
#include "light_shafts/depth_map.hpp"
#include "scene/light.hpp"
#include "scene/scene.hpp"

namespace tyndall::light_shafts {
class LightSpace {
public:
    /// `towards`: a point at whose depth the strata of a sun agree; `distance_m`: at which those of a lamp do.
    LightSpace(const Light& light, const vec3& towards, float distance_m);

    [[nodiscard]] bool is_flat() const { return is_flat_; }
    /// Axes across a stratum of a sun, as upright as the light's own.
    [[nodiscard]] std::pair<vec3, vec3> across(const vec3& towards_light) const;
    /// Of the texels of one row of a face: metres along the light's axes. Sun: x and y, z stays empty. Lamp: a point
    /// distance_m away.
    void place_row(const DepthMap& face, std::int32_t row, std::vector<float>& x, std::vector<float>& y,
                   std::vector<float>& z) const;
    /// The same of a shadow ray that ends on the light, or goes to a sun.
    [[nodiscard]] vec3 place_of(const Ray& ray) const;
    /// The value of a mask there.
    [[nodiscard]] float look_up(const LightMask& mask, const vec3& place_m) const;

private:
    /// From the origin: along a direction onto the plane.
    [[nodiscard]] vec3 on_plane(const vec3& p, const vec3& direction) const;

    bool is_flat_;
    LightKind kind_;
    float spot_half_angle_rad_;
    vec3 origin_, x_axis_, y_axis_, z_axis_; ///< z: towards a sun, and against a spot's beam.
    float depth_m_, distance_m_;             ///< Of the plane along z, from the origin; of the sphere.
};
} // namespace tyndall::light_shafts
