// SPDX-License-Identifier: GPL-3.0-or-later
// How many shadow rays of each light a camera ray is worth: the camera ray, its shading and its shafts cost as much as
// many shadow rays, and a pixel's noise may come from the light rather than from its surfaces' edges.
// Based on: splitting, Arvo and Kirk, Particle Transport and Image Synthesis, SIGGRAPH 1990; the number with the least
//           noise per time, see best_ray_counts.hpp.
// Differs:  one number per light and frame, from a pilot, for the least mean standard error of a pixel (edges with much
//           variance, which no shadow ray lessens, do not decide for all); fog hides noise, and its brightness is found by
//           a few rays; without fog, who asks for few samples wants them soon, so that rays are not doubled for the last
//           sixth of the noise, and more samples smooth edges, too; costs are guessed by how fine the geometry is: results
//           must not depend on the clock.
// Bound:    8 shadow rays per light and 4 camera rays, of 1,024 pixels: some 20 ms with 15 lights; and 64 rays through
//           the fog.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "render/indirect_light.hpp"
#include "render/pixel_filter.hpp"
#include "render/shared_irradiance.hpp"

namespace tyndall::render {
/// What the pilot found of a pixel, for what else its samples may be spent on.
struct PilotPixel {
    light_shafts::ViewRay part{}; ///< Of a ray up to its first surface, in or beside media.
    double brightness = 0.0;      ///< Without the light of meshes and media that glow in fog.
    double variance = 0.0;        ///< Of one sample.
};
struct PilotSamples {
    std::vector<PilotPixel> pixels; ///< None: there was no pilot.
    double cost = 0.0;              ///< Of one sample, in rays to the world.
    std::uint32_t longest_turn = 1; ///< See ShadowRayConfig.
};
struct ShadowRayCounts {
    std::vector<std::uint32_t> of_light; ///< Per light of DirectLight::light_count: a power of two up to 16.
    /// Per light: asked at every so many-th sample, for as many; a power of two.
    std::vector<std::uint32_t> turn_of_light;
    /// Alone, a pixel would need several rays of the world; with what its neighbours find, it needs as many as are here.
    bool is_world_shared = false;
    std::uint32_t of_bounce = 1; ///< Rays that gather the light of other surfaces.
    PilotSamples pilot = {};
};
/// Who asks for no more samples of a pixel wants them soon.
inline constexpr std::uint32_t few_samples = 16;
/// Noise counts relative to its pixel, but for pixels darker than this share of the frame's mean.
inline constexpr double darkest_share = 0.05;

struct ShadowRayConfig {
    bool may_share_world = false;   ///< Neighbours in one plane may share its light, see shared_irradiance.hpp.
    float voxel_detail_px = 0.0f;   ///< See FrameConfig.
    std::uint32_t longest_turn = 1; ///< Samples after which each light must have been asked; 1: at each.
    std::uint32_t pixel_samples = few_samples; ///< That are asked for.
    std::uint32_t seed = 0;
    bool has_fog_glow = false; ///< Which samples may be spent on, too: there is always a pilot.
};
/// `bounce`: nothing, or what gathers the light of other surfaces, which counts as one more light. Throws Cancelled.
[[nodiscard]] ShadowRayCounts count_shadow_rays(const Scene& scene, const Media& media, const DirectLight& light,
                                                const IndirectLight* bounce, const Camera& camera,
                                                const FilterSampler& filter, const ShadowRayConfig& config,
                                                const light_shafts::Config& shafts, Progress& progress);
} // namespace tyndall::render
