// SPDX-License-Identifier: GPL-3.0-or-later
// What a denoiser is shown beside the picture: colour, normal and distance of what each pixel shows, without its noise.
// Based on: Cycles, film/denoising_passes.h: features are those of the first surface that is not mostly sharp (mirror,
//           glass, what lets light pass), seen through what is; emission and world count as colour.
// Differs:  layers and mirrors are followed with their shares, not picked at random: features have no noise but that of
//           edges, and never those of what a diffuse bounce meets. A sample's colour ends at 1, where denoisers would
//           cut the mean. Gloss as sharp as a mirror that is not followed counts with its colour, as if it mirrored
//           white. Media count for nothing: shafts have no noise that wants a guide.
// Bound:    28 bytes per pixel; nothing is found where nobody asks.
#pragma once
#include "core/math.hpp"
#include "shading/lobes/lobe_set.hpp"
#include "shading/material.hpp"

namespace tyndall::render {
/// The mean over a pixel's samples is what passes hold.
struct DenoisingFeatures {
    Rgb albedo{0.0f};     ///< [0, 1] in each sample once it is added up.
    vec3 normal{0.0f};    ///< Camera space as Cycles has it: x right, y up, z away from the camera.
    float depth_m = 0.0f; ///< Way along the ray, mirrors included, times the share of it that is seen; 0: nothing.
};

/// How a ray looks for features; mirrored rays go on as copies.
struct FeatureSearch {
    Rgb through{1.0f};     ///< What sharp surfaces on its way leave of the features behind them.
    float share = 1.0f;    ///< Of the sample that comes this way: passing and mirrored rays divide it.
    float passed_m = 0.0f; ///< Where the ray has looked, along it.
    bool is_over = false;
};

/// What is left of a search in the directions that a sharp surface sends it: straight on, and where rays are sent.
struct FeatureSearches {
    FeatureSearch passing;
    FeatureSearch all_sent;    ///< As if all of what is sharp was sent one way.
    float sharp_weight = 0.0f; ///< Of what is sharp.
    /// Of a ray that is sent on, by its share of the light.
    [[nodiscard]] FeatureSearch sent(const Rgb& share) const;
};

/// Adds what a surface shows. `lobes` have its normal and the direction to the viewer; `bent` are those of Lobe::Kind::Bent.
/// Without `follows_mirrors` nothing is looked for in a mirror, nor behind what bends.
[[nodiscard]] FeatureSearches see_features(const FeatureSearch& search, float distance_m,
                                           const SurfaceClosures& closures, const LobeSet& lobes,
                                           std::span<const Lobe> bent, const mat4& world_from_camera,
                                           bool follows_mirrors, DenoisingFeatures& features);
/// Adds what the world shows behind everything.
void see_world_features(const FeatureSearch& search, const Rgb& radiance, DenoisingFeatures& features);
} // namespace tyndall::render
