// SPDX-License-Identifier: GPL-3.0-or-later
// What shades the air in place of strands and spheres that let a part of the light pass: opaque ones, as much narrower.
// Based on: stochastic transparency, Enderton, Sintorn, Shirley, Luebke, I3D 2010: on average an opaque share of a surface
//           stops what all of it lets through.
// Differs:  the share is no lot but a width, so that it has no noise; colours are lost. What is resolved shows it.
// Bound:    a copy of the strands, and the material's program once per point.
#pragma once
#include "core/progress.hpp"
#include <functional>
#include <memory>

namespace tyndall {
class Strands;

/// Which share of a strand's width, or of a sphere's disc, light finds opaque, by a segment and how far along it, [0, 1].
using OpaqueShare = std::function<float(std::uint32_t segment, float along)>;

/// Without maps; what is left with no width anywhere is left out, so that nothing may remain. Throws Cancelled.
[[nodiscard]] std::shared_ptr<const Strands> narrowed(const Strands& strands, const OpaqueShare& opaque_share,
                                                      const Progress& progress);
} // namespace tyndall
