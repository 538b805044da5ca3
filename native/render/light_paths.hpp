// SPDX-License-Identifier: GPL-3.0-or-later
// Light by the surface that sent it to the camera: what the passes Diffuse, Glossy and Transmission, direct and indirect,
// and Environment hold, from which compositors put a picture together anew.
// Based on: Cycles, film/light_passes.h: the first surface that scatters a camera's ray tells, whatever comes behind it;
//           direct is what has met no other. What glows, is seen straight and lies in media has passes of its own.
// Differs:  light is not divided by its colour here: films that are averaged or put together of tiles could not be, then.
//           Lobes of one kind are lit apart from the others', so that a picture's noise is that of other rays.
// Bound:    108 bytes per sample of a block; a point of a surface for each kind of its lobes. Nothing where nobody asks.
#pragma once
#include "shading/lobes/lobe_set.hpp"
#include "shading/material.hpp"
#include <array>
#include <cstdint>
#include <span>

namespace tyndall::render {
/// What sends light on. None: it comes straight.
enum class Scatterer : std::uint8_t { Diffuse = 0, Glossy = 1, Transmission = 2, None = 3 };
inline constexpr std::size_t scatterer_count = 3;
/// As Cycles sorts closures: all of a Principled Hair BSDF is gloss.
[[nodiscard]] Scatterer scatterer_of(const Lobe& lobe);

/// By which light comes to the camera: what sent it last, and whether nothing else had before.
struct LightWay {
    Scatterer by = Scatterer::None;
    bool is_direct = true;
};

/// Of a camera's ray; all of it is in its radiance, too.
struct LightPaths {
    std::array<Rgb, scatterer_count> direct{}, indirect{}; ///< By what sent it.
    Rgb environment{0.0f};
    Rgb glossy_colour{0.0f}, transmission_colour{0.0f}; ///< Of even light, what surfaces send back and on.

    void add(const LightWay& way, const Rgb& light) {
        if (way.by != Scatterer::None)
            (way.is_direct ? direct : indirect)[static_cast<std::size_t>(way.by)] += light;
    }
};

/// Share of even light that one of the set's lobes sends back.
[[nodiscard]] Rgb lobe_albedo(const LobeSet& lobes, const Lobe& lobe);
/// Adds the colours of a surface that a camera's ray meets with `throughput`. `bent`: those of Lobe::Kind::Bent.
void see_colours(const SurfaceClosures& closures, const LobeSet& lobes, std::span<const Lobe> bent,
                 const Rgb& throughput, LightPaths& paths);
} // namespace tyndall::render
