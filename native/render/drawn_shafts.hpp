// SPDX-License-Identifier: GPL-3.0-or-later
// Which lights' shafts a picture draws at random instead of asking rows: where rows would take many times as long as all
// else that the picture needs, for an error far below the noise that it has anyway.
// Based on: the times of rows per triangle and of asking them per ray, beside that of a camera ray and its draws, measured
//           in scenes of 400 to 3 million triangles. Counts alone decide, so that the same scene gives the same picture.
// Differs:  draws are sent_air.hpp's, a place on the ray and on a light each, whose noise falls with the samples. A sun's
//           shafts are rows in any case; so are all of them where something reads rows: edits, textures of the air,
//           transfer functions, the pass of their visibility, density grids.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "scene/media.hpp"

namespace tyndall::render {
struct DrawnShafts {
    /// Of each kind, per camera ray and sample.
    static constexpr std::uint32_t draws = 4;
    bool lamps = false, world = false;
    [[nodiscard]] bool is_any() const { return lamps || world; }
};

/// For a picture of `ray_count` camera rays, all samples together. EPIPOLAR alone draws, and never few samples: those of
/// a pixel have to average the draws.
[[nodiscard]] DrawnShafts choose_drawn(const Scene& scene, const Media& media, const light_shafts::Config& config,
                                       double ray_count);
} // namespace tyndall::render
