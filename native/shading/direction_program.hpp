// SPDX-License-Identifier: GPL-3.0-or-later
// A surface program whose points are directions: what a world's node tree is.
#pragma once
#include "core/progress.hpp"
#include "shading/program_point.hpp"
#include <span>

namespace tyndall {
/// Radiance is the material's emission. Its points lie one metre from the origin and face it, as Cycles has them; they
/// have no object, and their UV maps and attributes are 0.
class DirectionProgram {
public:
    /// Throws InvalidInput that names a material that cannot run.
    explicit DirectionProgram(Material material);

    /// `kind`: of the ray that looks there.
    [[nodiscard]] Rgb radiance(const vec3& unit_direction, RayKind kind) const;
    /// The same for many, in parallel. Throws Cancelled.
    void radiance(std::span<const vec3> unit_directions, RayKind kind, std::span<Rgb> values,
                  const Progress& progress) const;
    /// At the middles of the texels of an equirectangular image, see scene/world.hpp. Throws Cancelled.
    [[nodiscard]] std::vector<Rgb> image(std::uint32_t width, std::uint32_t height, RayKind kind,
                                         const Progress& progress) const;
    [[nodiscard]] const std::string& name() const { return material_.name; }

private:
    Material material_;
    std::vector<vec2> no_uvs_; ///< One for each UV map that is asked for.
};
} // namespace tyndall
