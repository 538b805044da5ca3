// SPDX-License-Identifier: GPL-3.0-or-later
// Where rays to the other side of a strand than was met leave it.
#pragma once
#include "scene/scene.hpp"

namespace tyndall {
/// Of a band, on its middle line's side that they go to, as far from it as where it was met: else those that are nearly
/// along it would cross that line, and meet the band again, which Cycles' rays leave out. Of all else, `spawn`: what
/// begins within a tube or sphere leaves it.
[[nodiscard]] SpawnPoint strand_spawn_point(const Scene& scene, const Hit& hit, const SpawnPoint& spawn);
} // namespace tyndall
