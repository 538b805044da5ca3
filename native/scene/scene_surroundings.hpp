// SPDX-License-Identifier: GPL-3.0-or-later
// What a hit's program may ask of the scene around it.
// Based on: blender/cycles v4.5.0, measured in 3.4, 4.5 and 5.0: what casts shadows hides, however much light it lets pass.
// Differs:  what has no surface at all, as a fog box, hides nothing: it is not in the trees; in Cycles it does.
#pragma once
#include "scene/scene.hpp"
#include "shading/surroundings.hpp"

namespace tyndall {
/// All of it has to outlive the program's run.
class SceneSurroundings final : public Surroundings {
public:
    SceneSurroundings(const Scene& scene, const AskingRay& asking, const ShadingPoint& point, const Hit& hit)
        : scene_(scene), asking_(asking), point_(point), hit_(hit) {}

    [[nodiscard]] std::size_t open_count(std::span<const vec3> directions, float reach_m, Among among) const override;
    void meet_own(const vec3& origin, const vec3& unit_direction, float reach_m,
                  std::vector<OwnSurface>& met) const override;
    [[nodiscard]] vec2 pair(std::uint32_t index, std::uint32_t count, std::uint32_t purpose) const override;
    [[nodiscard]] vec2 own_pair(std::uint32_t index, std::uint32_t purpose) const override;

private:
    const Scene& scene_;
    const AskingRay& asking_;
    const ShadingPoint& point_;
    const Hit& hit_;
};
} // namespace tyndall
