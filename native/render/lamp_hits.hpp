// SPDX-License-Identifier: GPL-3.0-or-later
// What a ray that was not aimed at a lamp finds of it: the other half of light_aim.hpp, for what lobes mirror.
#pragma once
#include "render/light_aim.hpp"
#include "shading/lobes/lobe_set.hpp"

namespace tyndall::render {
struct LampHit {
    float far_m = 0.0f;                 ///< Infinite towards a sun.
    float pdf_per_sr = 0.0f;            ///< With which LightAim::aim takes this direction; 0: the ray misses the lamp.
    float radiance_per_strength = 0.0f; ///< Without a spot's cone, 1/(m^2 sr), of a sun 1/sr.
};
/// From a point, in a unit direction; a lamp without a size, and one that the point is inside of, are never hit: aimed rays
/// alone tell what lobes mirror of these.
[[nodiscard]] LampHit lamp_hit(const LightAim::Form& form, const vec3& position, const vec3& direction);
/// False: rays aimed at the lamp are so much denser than directions that lobes draw, everywhere on it, that these would
/// hardly count beside those: then aimed rays alone tell what lobes mirror, too.
[[nodiscard]] bool lobes_may_find(const LightAim::Form& form, const vec3& position, float most_pdf_per_sr);
/// Of directions that lobes draw: nothing is denser, roughly. Broad sheens and cones are nowhere dense enough to count.
[[nodiscard]] float most_pdf_per_sr(const LobeSet& lobes);
/// Lobes that shine so narrowly that lights chosen without them are noisy: those that are broader are served as matte surfaces
/// are.
[[nodiscard]] bool are_sharp(const LobeSet& lobes);
} // namespace tyndall::render
