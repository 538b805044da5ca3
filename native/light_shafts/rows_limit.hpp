// SPDX-License-Identifier: GPL-3.0-or-later
// Which lights' rows would take a picture longer than it wants to give: those of its lamps, or of the world, together; the
// world's, too, where they would not tell its light (forward_fog.hpp).
// Based on: the times of rows per triangle and of asking them per ray, measured in scenes of 400 to 3 million triangles, and
//           of those whose texels ask for cones and spheres. A hair's segment takes 0.02 to 0.6 us, by how much of it a row
//           shows, a triangle that lets a part of the light pass 0.3 us as a leaf and 9 as a sea's, and a voxel 0.2 to 0.4.
//           A ray asks a lamp's for 0.3 us, and among density grids for 1 to 7, by how fine its steps have to be.
//           Counts alone decide, so that the same scene gives the same picture.
// Differs:  a sun's rows, which stand for all of its light, are never left. With SHADOW_MAP, whose maps hold opaque triangles
//           for next to nothing, these do not count.
#pragma once
#include <cstddef>
#include <limits>

namespace tyndall {
class Media;
class Scene;
} // namespace tyndall

namespace tyndall::light_shafts {
struct Config; // light_shafts.hpp

struct RowsLimit {
    double most_s = std::numeric_limits<double>::infinity(); ///< Of a processor, for lamps and for the world each.
    double ray_count = 0.0;                                  ///< Rays that ask the rows, in all passes.
};
/// Lights whose rows would take longer.
struct LeftLights {
    bool lamps = false, world = false;
    [[nodiscard]] bool is_any() const { return lamps || world; }
};
/// Light samples with rows of their own.
struct RowsCounts {
    std::size_t lamps = 0, lamp_samples = 0, world_samples = 0;
};
/// By config.rows_limit.
[[nodiscard]] LeftLights find_left(const Scene& scene, const Media& media, const Config& config,
                                   const RowsCounts& counts);
} // namespace tyndall::light_shafts
