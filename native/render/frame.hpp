// SPDX-License-Identifier: GPL-3.0-or-later
// One frame: camera rays, direct light, media and light shafts, put together into a film.
// Data flow, per sample of all pixels: camera rays -> surfaces with their light -> parts of the rays that lie in media
//            -> light shafts on all of them at once -> film -> transfer functions.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "render/film.hpp"
#include "render/indirect_config.hpp"
#include "render/pixel_filter.hpp"
#include "render/surface_pass.hpp"
#include "scene/scene.hpp"
#include "transfer_functions/transfer_function.hpp"
#include "volume/heterogeneity.hpp"
#include <functional>
#include <memory>
#include <optional>

namespace tyndall::render {
class KeptLightTrees; // kept_light_trees.hpp
class KeptSurfaces;   // kept_surfaces.hpp

struct FrameConfig {
    std::uint32_t pixel_samples = 16; ///< [1, 65536]; 1: the pixel's centre, unfiltered.
    /// Which of them this frame takes, the others being other frames': of one scene, the mean of all such frames is the
    /// frame that takes all samples. That mean is of the time that a shutter is open where each sees a moment of its own.
    std::uint32_t first_sample = 0;
    std::uint32_t sample_count = 0; ///< From the first one on; 0: all that there are.
    PixelFilter pixel_filter = PixelFilter::BlackmanHarris;
    float filter_width_px = 1.5f; ///< As in Cycles, [0.01, 10].
    /// Pixels stop after a round of samples (4, or what divides the samples) when their standard error falls below this
    /// times the square root of their mean, as in Cycles; [0, 1], 0: every pixel takes all samples. Of this frame's.
    float noise_threshold = 0.0f;
    /// None: the full frame. A region's pixels have the full frame's values, but for what pixels share at its border.
    std::optional<Region> region;
    /// The region is a tile of a frame that others put together: its pixels are those of the full frame in what pixels
    /// share and in what is laid out for all rays, too, bit for bit. Costs the camera rays of the frame's first sample.
    bool is_tile = false;
    /// Camera rays meet cubes of voxels no wider than this, as so many of them as the voxels would stop, with the means of
    /// their colours and normals; [0, 64], 0: every voxel is met. Other rays meet every voxel.
    float voxel_detail_px = 0.0f;
    bool is_film_transparent = false;
    PassSet passes;
    /// Depth, position, normal, UV, motion and indices are of the first surface that lets no more pass than 1 less this;
    /// [0, 1], 0: of the first one there is.
    float pass_alpha_threshold = 0.5f;
    DataPassConfig data = {}; ///< With them, nothing is kept of surfaces; nor with light groups and light by its paths.
    /// Names of the scene's light groups, of which the film holds "Combined_…" apart, and with Pass::Shafts "Shafts_…", too.
    std::vector<std::string> light_groups = {};
    light_shafts::Config shafts; ///< Neighbours share the world's light on surfaces as they do strata.
    std::vector<transfer_functions::WeightedFunction> transfer_functions; ///< Applied to the light shafts.
    /// Into Scene::lights: whose visibility, lit parts and angle the functions are about. None: the strongest sun's that
    /// scatters; without one, the mean over all lights, and the angle to the strongest lamp.
    std::optional<std::uint32_t> reference_light = {};
    std::optional<Heterogeneity> heterogeneity = {}; ///< The air's texture; none: media scatter evenly.
    IndirectConfig indirect = {};
    /// What camera rays met in other frames; nothing: none of it is kept.
    std::shared_ptr<KeptSurfaces> kept_surfaces = {};
    std::shared_ptr<KeptLightTrees> kept_light_trees = {}; ///< Of other frames; nothing: they grow for this one.
    /// A pilot finds how many shadow rays each light is worth at a surface point; false: one.
    bool adapts_shadow_rays = true;
    /// It may find lights that are not worth a ray at every sample: they are asked at every second or fourth alone. What is
    /// shown on the way waits until each has had its turn.
    bool lights_take_turns = false;
    bool keeps_unstyled = false; ///< The film carries what a change of the functions' layers needs.
    std::uint32_t seed = 0;
    int thread_count = 0; ///< 0: all.

    [[nodiscard]] std::uint32_t taken_samples() const {
        return sample_count > 0 ? sample_count : pixel_samples - first_sample;
    }
};

/// What is rendered of a camera's frame. Throws InvalidInput that names the setting which is out of its range.
[[nodiscard]] Region checked_region(const FrameConfig& config, const Camera& camera);

/// Called with the picture so far: after its first band, then about twice a second. Of a tile, never.
using OnUpdate = std::function<void(Film)>;

/// Throws InvalidInput, which names the culprit, and Cancelled. The film's bits do not depend on the number of threads.
[[nodiscard]] Film render(const Scene& scene, const Media& media, const Camera& camera, const FrameConfig& config,
                          Progress& progress, const OnUpdate& on_update = {});
/// Finds the media first. Callers that render a scene again keep them.
[[nodiscard]] Film render(const Scene& scene, const Camera& camera, const FrameConfig& config, Progress& progress,
                          const OnUpdate& on_update = {});
} // namespace tyndall::render
