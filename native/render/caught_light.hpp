// SPDX-License-Identifier: GPL-3.0-or-later
// What a pixel sees of shadow catchers: not the light on them, but what of it all other things leave.
// Based on: Debevec, Rendering Synthetic Objects into Real Scenes, SIGGRAPH 1998 (differential rendering), as Cycles
//           divides: light among all things by light among catchers alone, per channel, each summed over the pixel; then
//           the mean of the channels, at most 1.
// Differs:  what is seen through the clear part of a catcher is in the picture as ever, and the world behind fog in front
//           of a catcher is dimmed by it once (Cycles: twice); a pixel that shows a catcher, another object and nothing
//           weighs each by its share.
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <cstdint>

namespace tyndall::render {
/// Where light along a camera ray goes.
enum class LightOf : std::uint8_t {
    Picture = 0,
    CatcherAmongAll = 1, ///< Of a catcher: among all things,
    CatcherAlone = 2,    ///< and among catchers alone, with no media.
};

/// Of a sample, or sums or means of samples.
struct CaughtLight {
    Rgb lit{0.0f};       ///< CatcherAmongAll.
    Rgb alone{0.0f};     ///< CatcherAlone.
    Rgb backdrop{0.0f};  ///< The world's light behind the catchers, where the film shows it.
    float weight = 0.0f; ///< Share of the pixel that catchers cover: what their rays had left there.

    CaughtLight& operator+=(const CaughtLight& other) {
        lit += other.lit;
        alone += other.alone;
        backdrop += other.backdrop;
        weight += other.weight;
        return *this;
    }
    /// Share of what lies behind the catchers that their shadows leave; more than 1 where others light them. 1 without one.
    [[nodiscard]] Rgb kept() const {
        if (!(weight > 0.0f))
            return Rgb(1.0f);
        Rgb ratio(1.0f); // also where no light comes: then nothing has taken any away
        for (int channel = 0; channel < 3; ++channel)
            if (alone[channel] != 0.0f)
                ratio[channel] = lit[channel] / alone[channel];
        return ratio;
    }
    /// As a picture shows it: without colour, and no light.
    [[nodiscard]] float kept_as_seen() const { return std::clamp(average(kept()), 0.0f, 1.0f); }
};
} // namespace tyndall::render
