// SPDX-License-Identifier: GPL-3.0-or-later
// Operations on normals: Blender's Fresnel, Layer Weight, Normal Map and Bump, and what closures make of a normal.
// Based on: Mikkelsen, Bump Mapping Unparametrized Surfaces on the GPU, 2010; blender/cycles v3.4.0 to v5.0.0,
//           src/kernel/svm/{fresnel,tex_coord,displace}.h and src/kernel/closure/bsdf_util.h.
// Differs:  up to 3.4 of two normals that could lift a reflection onto the surface Cycles looks for the nearer one; here
//           it is found as it is from 3.6 on.
#pragma once
#include "shading/operands.hpp"
#include "shading/program_point.hpp"

namespace tyndall {
/// SurfaceOp::option of Code::NormalMap; python/tyndall/surface_inputs.py has the same numbers.
enum class NormalSpace : std::uint8_t {
    Tangent = 0, ///< Of the colour `a`, by the strength `b`, on the tangent `c` (in the object), whose sign is `d`.
    Object = 1,  ///< Of the colour `a` by the strength `b`.
    World = 2,
    BlenderObject = 3, ///< With y and z the other way round.
    BlenderWorld = 4,
    Unit = 5,          ///< `a` of length 1, the shading normal for a zero vector.
    ValidSpecular = 6, ///< The same, turned so far that a mirror would not send the ray into the surface.
    Count = 7,
};
/// SurfaceOp::selector of Code::NormalMap, with NormalSpace::Tangent: up to 3.6 strength mixes normals afterwards.
inline constexpr std::uint8_t strength_mixes_normals = 1;

/// SurfaceOp::selector of Code::Bump; flags.
inline constexpr std::uint8_t bump_is_inverted = 1, bump_is_valid_specular = 2;

/// Code::Fresnel: share that is mirrored by an index of refraction `a` at the normal `b`.
[[nodiscard]] float fresnel_value(const ProgramPoint& point, const Operands& in);
/// Code::LayerWeight: of the blend `a` at the normal `b`; option 0: Fresnel, 1: facing.
[[nodiscard]] float layer_weight(const SurfaceOp& op, const ProgramPoint& point, const Operands& in);
/// The unit normal, turned towards the flat surface's so far that a mirror would not send the ray into the surface.
[[nodiscard]] vec3 valid_specular(const ProgramPoint& point, const vec3& normal);
/// Code::NormalMap.
[[nodiscard]] vec3 mapped_normal(const SurfaceOp& op, const ProgramPoint& point, const Operands& in);
/// Code::Bump: `a`, `b` and `c` are the heights at the point and beside it, `d` the strength, `e` the distance, `f` the
/// normal that is bent. value.x is how much of a pixel lies between the heights. Where no footprint is known, `f`.
[[nodiscard]] vec3 bumped_normal(const SurfaceOp& op, const ProgramPoint& point, const Operands& in);
} // namespace tyndall
