// SPDX-License-Identifier: GPL-3.0-or-later
// What of a scene stands elsewhere than in another one, and which rays that can concern.
// Differs:  nothing is told by what was changed: two descriptions are compared, and all that they have must be the same
//           but for transforms. What a ray meets then stays, unless it meets a box around where something stood or stands.
// Bound:    a comparison of 100 bytes per instance; per ray one test of a box, and of up to 8 more if it meets that.
#pragma once
#include "scene/scene.hpp"
#include <map>
#include <optional>

namespace tyndall {
/// Instances with transforms that they had and have no more.
using StoodAt = std::map<std::uint32_t, std::vector<mat4>>;

/// Instances of `after` that stand elsewhere than in `before`, with where they stood. Nothing where the scenes differ in
/// more, where one that moved bounds a medium, or where thousands did; nor where a material traces rays of its own, which
/// may meet what moved wherever the material is. Lights and worlds do not count.
[[nodiscard]] std::optional<StoodAt> moved_instances(const SceneDescription& before, const SceneDescription& after);

/// Around what moved, where it stood and where it stands; a little larger than what rounding may add.
class MovedBoxes {
public:
    static constexpr std::size_t most_boxes = 8;

    /// Those that stand where they stood did not move. `camera_position`: rays start there or on surfaces.
    MovedBoxes(const Scene& scene, const StoodAt& stood_at, const vec3& camera_position);
    [[nodiscard]] bool is_empty() const { return boxes_.empty(); }
    [[nodiscard]] std::span<const Bounds3> boxes() const { return boxes_; }
    /// False: what the ray meets in its range is what it met before.
    [[nodiscard]] bool may_meet(const Ray& ray) const;

private:
    std::vector<Bounds3> boxes_;
    Bounds3 around_; ///< All of them.
};
} // namespace tyndall
