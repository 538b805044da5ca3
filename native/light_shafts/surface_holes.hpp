// SPDX-License-Identifier: GPL-3.0-or-later
// Holes that the edits of a light's occluders make for surfaces, too: floor and air then agree.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.1, where it is the shadow map that surfaces look up.
// Differs:  shadow rays are traced, without the objects that have a hole where the ray passes: no texel shows.
// Bound:    one look-up of the noise per edit and ray; rays through holes are traced alone.
#pragma once
#include "light_shafts/placed_edit.hpp"
#include <memory>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
class SurfaceHoles {
public:
    /// Nothing where no edit of the light is for surfaces. At most 63 edits. `scene` must outlive the result.
    [[nodiscard]] static std::unique_ptr<const SurfaceHoles> make(const Scene& scene, const Light& light);

    /// Of each shadow ray to the light what the scene, with the holes, lets through.
    void shadow_transmittances(std::span<const Ray> rays, std::span<Rgb> passing) const;

private:
    explicit SurfaceHoles(const Scene& scene) : scene_(scene) {}

    const Scene& scene_;
    std::vector<PlacedEdit> edits_;
    std::vector<std::uint64_t> bits_of_instance_; ///< A bit per edit that means it, and of what never blocks the light.
    std::uint64_t never_blocks_ = 0;              ///< That one; 0: all do.
};
} // namespace tyndall::light_shafts
