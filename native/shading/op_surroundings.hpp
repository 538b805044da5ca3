// SPDX-License-Identifier: GPL-3.0-or-later
// Operations that trace rays from the point: Blender's Ambient Occlusion and Bevel.
// Based on: blender/cycles v3.4.0, v4.5.0 and v5.0.0, src/kernel/svm/{ao,bevel}.h: what they estimate. Bevel's probes: King,
//           Kulla, Conty, Fajardo, BSSRDF Importance Sampling, SIGGRAPH Talks 2013.
// Differs:  well distributed over all samples of a pixel, by Sobol' points; a probe takes all surfaces that it meets, not
//           four of them by chance.
// Bound:    a ray per sample, 16 at a time (occlusion); a Bevel's are traced one by one.
#pragma once
#include "shading/operands.hpp"
#include "shading/program_point.hpp"

namespace tyndall {
struct Material;
/// SurfaceOp::option of Code::AmbientOcclusion; flags. python/tyndall/surface_inputs.py has the same numbers.
struct OcclusionOptions {
    static constexpr std::uint8_t inside = 1;     ///< Rays go into the surface.
    static constexpr std::uint8_t only_local = 2; ///< Only the point's own object hides anything.
    static constexpr std::uint8_t all = inside | only_local;
};

/// Code::AmbientOcclusion: of the directions around the normal `b`, by their cosine, the share that is open as far as the
/// distance `a`. SurfaceOp::selector is the number of rays. 1 where no ray may be traced.
[[nodiscard]] float open_share(const SurfaceOp& op, const ProgramPoint& point, const Operands& in);
/// Code::Bevel: the mean of the object's normals within the radius `a`, moved by as much as `b` differs from the point's
/// own normal. SurfaceOp::selector is the number of probes. `b` where no ray may be traced, and for rays that gather light.
[[nodiscard]] vec3 rounded_normal(const SurfaceOp& op, const ProgramPoint& point, const Operands& in);

/// Whether rays of its program may meet other objects.
[[nodiscard]] bool asks_for_others(const Material& material);
} // namespace tyndall
