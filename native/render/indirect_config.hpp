// SPDX-License-Identifier: GPL-3.0-or-later
// What surfaces see of one another and of the world, beyond light that reaches them straight: options, all off.
#pragma once
#include <cstdint>
#include <limits>

namespace tyndall::render {
struct IndirectConfig {
    /// The world's light on surfaces is stopped by what stands within ambient_distance_m, and not by what is farther.
    bool has_ambient_occlusion = false;
    /// Of ambient occlusion and of its pass, which needs no has_ambient_occlusion; [0, 1e9], 0: any distance.
    float ambient_distance_m = 0.0f;
    std::uint32_t ambient_samples = 4; ///< Rays of the pass per surface point, [1, 1024].

    /// Surfaces catch the light of the lamps and the world on other surfaces, and what these emit: one diffuse bounce.
    bool has_bounce = false;
    std::uint32_t bounce_samples = 0; ///< Rays per surface point, [0, 1024]; 0: a pilot decides.

    std::uint32_t mirror_depth =
        0; ///< Mirrors that a camera ray follows, one after another, [0, 64]; 0: they are black.
    /// Surfaces that bend a camera ray, one after another, [0, 64]; 0: what bends is black. What these mirror counts among
    /// the mirrors, and is followed where they bend.
    std::uint32_t refraction_depth = 0;
    /// Camera rays go on from what they meet.
    [[nodiscard]] bool follows_rays() const { return mirror_depth > 0 || refraction_depth > 0; }

    /// How far surfaces look for what stops the world's light, and for surfaces whose light they catch.
    [[nodiscard]] float reach_m() const { return has_ambient_occlusion ? ambient_reach_m() : infinite_m; }
    /// The same for the pass.
    [[nodiscard]] float ambient_reach_m() const { return ambient_distance_m > 0.0f ? ambient_distance_m : infinite_m; }
    bool operator==(const IndirectConfig&) const = default;

private:
    static constexpr float infinite_m = std::numeric_limits<float>::infinity();
};

/// Throws InvalidInput that names the setting.
void require_usable(const IndirectConfig& config);
} // namespace tyndall::render
