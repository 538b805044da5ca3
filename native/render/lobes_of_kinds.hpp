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

/// `lobes` themselves, or a set that lies in `room`, which must outlive it as it is.
[[nodiscard]] inline LobeSet lobes_of_kinds(const LitKinds& kinds, const LobeSet& lobes, std::vector<Lobe>& room) {
    if (kinds.are_all())
        return lobes;
    room.clear();
    for (const Lobe& lobe : lobes.lobes)
        if (lights(kinds, lobe))
            room.push_back(lobe);
    return {.lobes = room, .normal = lobes.normal, .outgoing = lobes.outgoing};
}
} // namespace tyndall::render
