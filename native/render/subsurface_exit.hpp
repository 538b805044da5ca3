// SPDX-License-Identifier: GPL-3.0-or-later
// Where light that is seen at a surface came in: below it, at another place of the same object. What is found is a surface
// point that waits for light as any other does, as if it was white and diffuse.
// Differs from Cycles: of the light there, which Cycles asks one lamp for, or draws, all that DirectLight asks counts, and
//           the rays of 16 pixels' exits go in packets.
#pragma once
#include "render/surface_point.hpp"
#include "shading/lobes/lobe.hpp"
#include <array>
#include <span>

namespace tyndall::render {
/// A view ray on a surface that scatters below it.
struct SubsurfaceEntry {
    const Scene& scene;
    const SurfacePoint& point; ///< On the viewer's side.
    const Lobe& lobe;          ///< Of Kind::Subsurface.
    vec3 outgoing;             ///< Unit, to the viewer.
    float footprint_m;         ///< What a pixel covers there.
    ProgramRandom random;      ///< Its own.
};
struct SubsurfaceExit {
    SurfacePoint point;
    vec3 own_normal; ///< Unit, around which light counts; zero: the point's.
    Rgb weight;      ///< Of white diffuse light there, that reaches the viewer.
};
/// Several, which count together: no more than channels.
template <typename Exit>
struct Exits {
    std::array<Exit, 3> each;
    std::size_t count = 0;
    [[nodiscard]] std::span<const Exit> all() const { return std::span(each).first(count); }
};
/// Drawn at random; none: no light comes this way. What one in a mesh that is open or leaks finds is bounded, too.
[[nodiscard]] Exits<SubsurfaceExit> subsurface_exits(const SubsurfaceEntry& entry);

/// The two kinds of SubsurfaceMethod, of subsurface_exit.cpp alone: a ray that meets the exit from outside.
struct FoundExit {
    Ray from_outside;
    Hit hit;
    Rgb weight;
};
using FoundExits = Exits<FoundExit>;
[[nodiscard]] FoundExits walk_below(const SubsurfaceEntry& entry);
[[nodiscard]] FoundExits exit_by_profile(const SubsurfaceEntry& entry);
} // namespace tyndall::render
