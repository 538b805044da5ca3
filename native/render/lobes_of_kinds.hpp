// SPDX-License-Identifier: GPL-3.0-or-later
// The lobes of a point that an emitter lights.
#pragma once
#include "render/light_paths.hpp"
#include "scene/lit_kinds.hpp"
#include <vector>

namespace tyndall::render {
[[nodiscard]] inline bool lights(const LitKinds& kinds, const Lobe& lobe) {
    switch (scatterer_of(lobe)) {
    case Scatterer::Diffuse:
        return kinds.diffuse;
    case Scatterer::Glossy:
        return kinds.glossy;
    default:
        return kinds.transmission;
    }
}

/// `room` must outlive what is made of it, as it is.
[[nodiscard]] inline LobeSet lobes_of_kinds(const LitKinds& kinds, const LobeSet& lobes, std::vector<Lobe>& room) {
    room.clear();
    for (const Lobe& lobe : lobes.lobes)
        if (lights(kinds, lobe))
            room.push_back(lobe);
    return {.lobes = room, .normal = lobes.normal, .outgoing = lobes.outgoing};
}
} // namespace tyndall::render
