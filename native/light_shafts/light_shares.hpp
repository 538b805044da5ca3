// SPDX-License-Identifier: GPL-3.0-or-later
// How much of the frame's scattered light each light sample carries, so that each gets the resolution it is worth.
// Independent errors e of samples with shares w add up to sqrt(sum (w e)^2). A raster's cost rises with 1 / e^2; the
// cheapest way to a frame's error E is then e = E / sqrt(w) (Lagrange). A world of 64 dim directions beside a bright sun
// costs next to nothing, and n equal samples have sqrt(n) times the error each.
// Bound:    256 rays per sample, without visibility.
#pragma once
#include "light_shafts/local_scatter.hpp"
#include "light_shafts/scatter_pieces.hpp"
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// Luminance that each sample of a frame would scatter along evenly picked `rays` (finite, clipped to the media) if
/// nothing cast a shadow, adding samples one by one.
class LightShares {
public:
    LightShares(const Media& media, std::span<const ViewRay> rays);
    void add(const DirectionalScatter& light);
    void add(const LocalScatter& light);
    [[nodiscard]] std::size_t size() const { return luminance_.size(); }
    /// Share of sample i in the sum of all that were added, [0, 1].
    [[nodiscard]] float share(std::size_t sample) const;

private:
    std::vector<ViewRay> rays_;
    std::vector<std::uint32_t> first_segment_{0};
    std::vector<MediumSegment> segments_;
    LocalRays local_rays_; ///< The same, for lights at points.
    bool has_grids_ = false;
    MediumSteps steps_; ///< Where there are density grids, which dim none of the lights here.
    std::vector<double> luminance_;
    double sum_ = 0.0;
};

/// The relative error that a sample with this share may have in a frame of `error_target`; at most 0.3, above which rows
/// are too coarse for their errors to be independent.
[[nodiscard]] float error_of_share(float error_target, float share);
} // namespace tyndall::light_shafts
