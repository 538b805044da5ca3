// SPDX-License-Identifier: GPL-3.0-or-later
// What the strokes of one camera see of a light whose map is fitted: the light itself, white and without a size. What a map is
// multiplied with comes later.
#pragma once
#include "light_shafts/light_map_fit.hpp"
#include "light_shafts/light_map_fit_rows.hpp"
#include "light_shafts/prepared_lights.hpp"

namespace tyndall::light_shafts {
/// The rays of strokes, clipped to the media, and the light ready for them.
class StrokeView {
public:
    static constexpr std::size_t rays_per_block = 256;

    StrokeView(const Scene& scene, const Media& media, const Strokes& strokes, const LightMapFitConfig& config,
               Statistics& statistics, Progress& progress);

    [[nodiscard]] std::size_t block_count() const { return (rays_.size() + rays_per_block - 1) / rays_per_block; }
    [[nodiscard]] std::span<const ViewRay> rays(std::size_t block) const;
    /// Of each of its rays, and one more: into segments().
    [[nodiscard]] std::span<const std::uint32_t> first_segments(std::size_t block) const;
    [[nodiscard]] std::span<const MediumSegment> segments() const { return segments_; }
    /// Nothing where no ray meets a medium.
    [[nodiscard]] const Beam* beam() const;

private:
    std::vector<ViewRay> rays_;
    std::vector<std::uint32_t> first_segment_{0};
    std::vector<MediumSegment> segments_;
    PreparedLights prepared_;
};

/// Consecutive rays of one view, with what they see of a sun.
struct SeenBlock {
    std::vector<ViewRay> rays;
    PieceRows pieces;
    LitRows lit;
    Focus focus;
    bool is_grey = true;
    [[nodiscard]] SeenRay at(std::size_t ray) const { return {rays[ray], pieces.of_ray(ray), lit.of_ray(ray)}; }
};
[[nodiscard]] std::vector<SeenBlock> see_sun(const StrokeView& view, const LightMapAxes& axes,
                                             const Progress& progress);
/// The rows of a lamp's map; a lamp throws it where it throws it, and needs no focus.
[[nodiscard]] std::vector<LightMapMatrix::Part> lamp_rows(const StrokeView& view, const Media& media, const Light& lamp,
                                                          std::uint32_t resolution, const Progress& progress);
} // namespace tyndall::light_shafts
