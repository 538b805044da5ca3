// SPDX-License-Identifier: GPL-3.0-or-later
// Boxes of media, and the mean of draws of the light that media scatter.
#pragma once
#include "core/random.hpp"
#include "render/fog_glow.hpp"
#include "support/scenes.hpp"

namespace tyndall::support {
/// A box of a medium, around a place.
inline Part box_of(std::int32_t medium, const vec3& centre, const vec3& half_size) {
    Part box{.mesh = cube(), .world_from_object = glm::scale(translation(centre), half_size)};
    box.material = {.name = "fog"};
    box.material.has_surface = false;
    box.material.medium_index = medium;
    return box;
}
struct DrawnMean {
    glm::dvec3 value{0.0}, sigma{0.0};
};
/// Of so many pixels that all see the same, with 64 draws each; `draw` appends what one of these finds.
template <typename Draw>
DrawnMean mean_of_draws(std::uint32_t pixels, const Draw& draw) {
    constexpr std::uint32_t draws = 64;
    std::vector<render::FogGlow::Found> found;
    DrawnMean mean;
    glm::dvec3 squares(0.0);
    for (std::uint32_t pixel = 0; pixel < pixels; ++pixel) {
        glm::dvec3 sum(0.0);
        for (std::uint32_t number = 0; number < draws; ++number) {
            found.clear();
            draw(render::FogGlow::Numbers{hash(pixel, 5u), number, 0}, found);
            for (const render::FogGlow::Found& one : found)
                sum += glm::dvec3(one.radiance) / double(draws);
        }
        mean.value += sum / double(pixels);
        squares += sum * sum / double(pixels);
    }
    mean.sigma = glm::sqrt(glm::max(squares - mean.value * mean.value, glm::dvec3(0.0)) / double(pixels - 1));
    return mean;
}
} // namespace tyndall::support
