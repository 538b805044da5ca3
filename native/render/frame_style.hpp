// SPDX-License-Identifier: GPL-3.0-or-later
// The transfer functions of one frame while it renders: what its samples meet, and the picture that they make of it.
#pragma once
#include "render/asked_rays.hpp"
#include "render/frame.hpp"
#include "render/ray_parameters.hpp"
#include "render/styled_shafts.hpp"

namespace tyndall::render {
class FrameStyle {
public:
    /// `config`, which has functions, and `camera` must outlive this; width and height are the region's. Throws InvalidInput.
    FrameStyle(const Scene& scene, const Camera& camera, const FrameConfig& config, std::uint32_t width_px,
               std::uint32_t height_px);

    [[nodiscard]] const RayParameters& parameters() const { return parameters_; }
    /// The surface of a pixel's current sample. Threads may see and add different pixels.
    void see(std::size_t pixel, const PathSample& sample) { seen_[pixel] = parameters_.seen(sample); }
    /// The light shafts before it; `place_px` is the pixel's centre in the full frame.
    void add(std::size_t pixel, vec2 place_px, const SeenShafts& shafts);
    /// Fits what is fitted to the frame's light shafts, and finds out where the points are that constraints follow.
    void see_shafts(const ViewPath& path, const light_shafts::Shafts& shafts, const Progress& progress);
    /// What the functions make of the film so far.
    [[nodiscard]] Film apply(Film film, const Progress& progress) const;

private:
    const Camera& camera_;
    const FrameConfig& config_;
    RayParameters parameters_;
    StyledShafts shafts_;
    std::vector<SeenSurface> seen_; ///< Per pixel, of its current sample.
    std::vector<PlacedPoint> points_;
};
} // namespace tyndall::render
