// SPDX-License-Identifier: GPL-3.0-or-later
// Which pictures draw lights' shafts at random instead of asking rows: where rows would take many times as long as all else
// that the picture needs, for an error far below the noise that it has anyway.
// Based on: the time of a camera ray and its draws beside those of rows (light_shafts/rows_limit.hpp).
// Differs:  draws are sent_air.hpp's, a place on the ray and on a light each, whose noise falls with the samples. All
//           shafts are rows where something reads rows: edits, textures of the air, transfer functions, the pass of their
//           visibility.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "scene/media.hpp"

namespace tyndall::render {
/// Of lamps and of the world each, per camera ray of a picture of so many samples: where these are few, as many draws to a
/// pixel as of more, but for a coarse picture that is to come at once (light_shafts::Config::walks_maps).
[[nodiscard]] std::uint32_t shaft_draws(const light_shafts::Config& config, std::uint32_t pixel_samples);
/// For `ray_count` camera rays of a picture, all samples together. EXACT never draws.
[[nodiscard]] light_shafts::RowsLimit rows_limit(const Scene& scene, const Media& media,
                                                 const light_shafts::Config& config, double ray_count,
                                                 std::uint32_t pixel_samples);
} // namespace tyndall::render
