// SPDX-License-Identifier: GPL-3.0-or-later
// Where on view rays a local light can shine at all: inside its cone, in front of its horizon. Most rays of a frame miss
// the cone of a spot and need nothing else.
// Based on: ray against cone as a quadratic (Eberly, Intersection of a Line and a Cone, Geometric Tools 2000), measured
//           from the light's foot on the ray.
// Bound:    8 rays at a time in doubles (AVX-512): the foot may be a million times nearer than the ray's origin.
#pragma once
#include "light_shafts/local_rays.hpp"
#include "scene/softened_patch.hpp"
#include <array>
#include <vector>

namespace tyndall::light_shafts {
/// What shapes a local light, in the terms of the vector loops.
struct LocalShape {
    explicit LocalShape(const LightSample& light);
    [[nodiscard]] bool is_patch() const { return is_area || sphere_radius_m > 0.0; } ///< See softened_patch.hpp.
    dvec3 position;
    bool has_normal, is_soft, faces_receivers, has_cone, has_soft_edge;
    bool keeps_cosine; ///< Up to 3.x the spot's cosine stays a factor.
    bool is_area;      ///< Its lobe, with the cosine and the spread, is that of a point as far before it as softened.
    dvec3 normal;      ///< Cosine lobe of a stratum of a sphere; what an area light faces.
    dvec3 falloff_offset; ///< Of a stratum of a facing disc; see LightSample.
    double softening_m2;
    double sphere_radius_m; ///< Of a sphere of which it is a softened patch, or 0.
    double below_m = 0.0;   ///< How far below its plane a point of that sphere may be lit.
    bool has_cell;
    std::array<dvec3, 4> cell_normals{};  ///< Of the planes that bound the light's cell, inwards; zero: no plane.
    std::array<double, 4> cell_heights{}; ///< Of the light over them, metres.
    glm::dmat3 cone_from_world{1.0};      ///< To where the cone is tested, axis along +Z.
    double cos_half = 0.0, cos_inner = 0.0;
    double one_minus_cos_half = 0.0, per_smooth = 0.0; ///< 1 / width of the soft edge in cosine.
    double spread_cotangent = 0.0;                     ///< Area: of half its spread.
    AreaOutline outline{};                             ///< Area: of the whole light, from the patch.
    std::array<float, 6> twice_fan_m2{};               ///< Areas of the triangles from its first corner, doubled.
    double edge_width = 1.0;                           ///< See softened_patch.hpp.
};

/// Per ray, x being the distance along it from the light's foot. Columns are padded as those of LocalRays.
struct LocalSupport {
    enum Distance : std::uint8_t {
        LightX, ///< From the ray's origin to the foot.
        Begin,
        End, ///< What the light can shine on: Begin < End, or nothing.
        Inner0,
        Inner1, ///< Between them a soft edge has risen to 1; crossed or infinite where it does not. Of an area light: where
                ///< the ray is nearest to the lobe's axis, and where it comes into the lobe or leaves it.
        Body0,
        Body1,  ///< Of a patch of a sphere: where the ray comes into the sphere, and leaves it; or infinite.
        LightY, ///< Between light and foot; at least 1e-6 of the way from the ray's origin to the light.
        Normal0,
        NormalX, ///< normal . (point - position) at the foot, and per metre along the ray.
        DistanceCount
    };
    enum Term : std::uint8_t {
        SoftenedY, ///< sqrt(LightY^2 + softening).
        LightY2,
        ConeX,
        ConeY,
        ConeZ, ///< The foot in cone_from_world's space, from the light.
        ConeDx,
        ConeDy,
        ConeDz,  ///< The ray's direction there.
        NormalD, ///< normal . direction.
        Offset0,
        OffsetX, ///< 2 falloff_offset . (point - position) at the foot, and per metre.
        TermCount
    };
    std::array<std::vector<double>, DistanceCount> distance;
    std::array<std::vector<float>, TermCount> term;
    void resize(std::size_t ray_count);
};

void find_support(const LocalShape& shape, const LocalRays& rays, LocalSupport& support);
} // namespace tyndall::light_shafts
