// SPDX-License-Identifier: GPL-3.0-or-later
// What a program may ask of what stands around its point: an interface, for what stands there is the scene's to know.
#pragma once
#include "shading/program_point.hpp"
#include <span>
#include <vector>

namespace tyndall {
/// What a line meets of the point's own object, in the scene's space.
struct OwnSurface {
    vec3 position;
    vec3 geometric_normal; ///< Unit, as the surface is wound, whatever side the line comes from.
    vec3 shading_normal;   ///< Unit, on the same side.
};

/// Lives while a program runs; in the scene's space.
class Surroundings {
public:
    enum class Among : std::uint8_t {
        All,      ///< That casts shadows.
        OwnObject ///< Of the point.
    };
    Surroundings() = default;
    Surroundings(const Surroundings&) = delete;
    Surroundings& operator=(const Surroundings&) = delete;

    /// How many of the rays that leave the point in these unit directions meet no surface within reach_m. What a surface
    /// lets pass does not count.
    [[nodiscard]] virtual std::size_t open_count(std::span<const vec3> directions, float reach_m,
                                                 Among among) const = 0;
    /// Appends what the ray meets of the point's own object, from either side, in any order.
    virtual void meet_own(const vec3& origin, const vec3& unit_direction, float reach_m,
                          std::vector<OwnSurface>& met) const = 0;
    /// The random pair `index` of the `count` of this sample, in [0, 1)^2; all samples of a pixel together are well
    /// distributed, and independent of those for another purpose.
    [[nodiscard]] virtual vec2 pair(std::uint32_t index, std::uint32_t count, std::uint32_t purpose) const = 0;
    /// The same of a sequence of this sample's own: what is found from a few pairs together is then found from all that a
    /// pixel could deal out, not from those that its samples share.
    [[nodiscard]] virtual vec2 own_pair(std::uint32_t index, std::uint32_t purpose) const = 0;

protected:
    ~Surroundings() = default;
};
} // namespace tyndall
