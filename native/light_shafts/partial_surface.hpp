// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles that let a part of the light pass, as rows hold them: at each light line a yes or a no.
// Based on: Wyman and McGuire, Hashed Alpha Testing, 2017; Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020.
// Differs:  the threshold that a transmittance must exceed is a hash of the triangle, the slice and the light, but even
//           along the lines: of 2^k neighbours each has its own 2^-k of [0, 1). Triangles draw independently of one
//           another, so that layers multiply.
// Error:    none on average. A ray that crosses n lines behind one triangle of constant transmittance is off by some 1 / n;
//           behind many small ones, or several layers, by up to 0.5 / sqrt(n) (noise). Slices and light samples average
//           it further. Where the transmittance is 0 or 1, nothing is drawn and nothing is noisy.
#pragma once
#include "light_shafts/occluders.hpp"

namespace tyndall::light_shafts {
/// The light that rows are filled for, and what it meets.
struct PartialShading {
    /// `frame_seed`: other seeds, and other lights, draw independently.
    PartialShading(std::span<const PartialOccluderInstance> instances, const LightSample& light,
                   std::uint32_t frame_seed);

    std::span<const PartialOccluderInstance> instances;
    const LightSample& light;
    std::uint32_t seed;
    int channel = 0; ///< Of the transmittance.
    std::int32_t first_slice =
        0; ///< What slices are counted from: where rows begin elsewhere, the same ones draw alike.
};

/// One triangle in one slice.
struct PartialSurface {
    const PartialOccluderMesh::Slot* slot = nullptr;
    std::uint32_t triangle = 0; ///< Of the scene's mesh.
    std::uint32_t instance = 0; ///< Of the scene.
    std::uint32_t slice = 0, seed = 0;
    int channel = 0;
    bool is_backface = false;
    const PartialOccluderInstance* placed = nullptr; ///< What programs read more of; nothing: they read nothing.
    const LightSample* light = nullptr;
    vec2 uv{0.0f}, uv_run[2]{}; ///< In the deciding image: at the first corner, and what the two others add.

    /// At a point with these weights of the second and the third corner.
    [[nodiscard]] float transmittance(const vec2& weights) const;
    /// Nothing passes at this light line, where the transmittance is such.
    [[nodiscard]] bool stops(float transmittance, std::int32_t line) const;
};
/// `instance` is an index into shading.instances.
[[nodiscard]] PartialSurface partial_surface(const PartialShading& shading, std::uint32_t instance,
                                             std::uint32_t triangle, std::int32_t slice);
} // namespace tyndall::light_shafts
