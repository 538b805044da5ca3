// SPDX-License-Identifier: GPL-3.0-or-later
// The texture of the air in one frame: what each part of a view ray in media is multiplied by, asked of its own ray, or of
// one ray per square of pixels and carried over to the others.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.3; Kopf et al., Joint Bilateral Upsampling, SIGGRAPH 2007.
// Differs:  a neighbour counts the less the farther away from the pixel's own surface its ray ends, and from a tenth
//           of the distance on not at all: sky and surfaces never mix, nor do two sides of a silhouette. Where no
//           neighbour agrees, or none is lit, the pixel asks its own ray.
//           The squares lie on a grid of the full frame; those that a region's pixels need beside it are traced, too:
//           a region is a crop of the full frame.
// Data flow, per pass: rays of the squares' middle pixels -> their texture -> per part of a pixel: 4 neighbours, 24 bytes each
//           -> the rays left over -> their texture.
// Bound:    one question per lit ray, or per square; 4 neighbours per pixel.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "render/carry_over_kernel.hpp"
#include "render/surface_pass.hpp"
#include "volume/air_texture.hpp"

namespace tyndall::render {
class FrameAir {
public:
    /// `camera` must outlive this. Makes the noise volume unless it is kept. `fills_dark`: rays that no light reaches
    /// have a texture, too, that of their whole length. Throws InvalidInput and Cancelled.
    FrameAir(const Heterogeneity& heterogeneity, const Camera& camera, const Region& region, bool fills_dark,
             const Progress& progress);

    /// The rays of the squares in a pass: `waiting` has those of the region, the others are traced as the pass was.
    void begin_pass(const ViewPath& path, const FilterSampler& filter, const SurfacePass::Config& config,
                    std::uint32_t sample_index, const WaitingParts& waiting, const Progress& progress);
    /// Light shafts have to be prepared for square_rays(), too.
    [[nodiscard]] bool sees_beside() const { return !margins_.empty(); }
    [[nodiscard]] std::span<const light_shafts::ViewRay> square_rays() const { return square_rays_; }
    /// What the squares' rays are multiplied by.
    void ask_squares(const light_shafts::Shafts& shafts, light_shafts::Turn turn, const Progress& progress);

    /// Of the pixels [first_pixel, end_pixel) of the region: what each of their parts in `waiting` is to be multiplied by;
    /// 1 where its `radiance` is 0, unless dark rays are filled. Spans begin with the first part of first_pixel.
    void find(const light_shafts::Shafts& shafts, light_shafts::Turn turn, const WaitingParts& waiting,
              std::size_t first_pixel, std::size_t end_pixel, std::span<const Rgb> radiance,
              std::span<float> heterogeneity, const Progress& progress);
    /// What asking took, and how many rays were asked, so far.
    void report(Statistics& statistics) const;

private:
    struct Margin {
        Region pixels;
        WaitingParts parts;
    };
    [[nodiscard]] std::uint32_t middle_px(std::uint32_t square, std::uint32_t frame_px) const;
    /// The square whose middle lies before a pixel's, along one axis, and the share of the one after it.
    [[nodiscard]] std::pair<std::uint32_t, float> square_before(std::uint32_t pixel, std::uint32_t first,
                                                                std::uint32_t end) const;
    [[nodiscard]] PixelsBetweenSquares between_squares(std::uint32_t x, std::uint32_t y) const;
    [[nodiscard]] float carried_over(std::uint32_t x, std::uint32_t y, float far_m) const;

    AirTexture air_, air_of_whole_ray_;
    const Camera& camera_;
    const Camera air_camera_; ///< Of what columns are seen by.
    Region region_;
    std::uint32_t upsampling_;
    bool fills_dark_;
    Region squares_; ///< That the region's pixels lie between.
    std::vector<Margin> margins_;
    std::vector<std::uint32_t> first_of_square_;
    std::vector<light_shafts::ViewRay> square_rays_;
    std::vector<float> square_far_m_, square_heterogeneity_; ///< And what vectors read beyond.
    bool has_one_each_ = false;                              ///< Each square one ray.
    std::shared_ptr<const light_shafts::PictureAir>
        picture_; ///< Of the pass, where it is looked up for all rays at once.
    std::size_t asked_count_ = 0;
    double seconds_ = 0.0;
};
} // namespace tyndall::render
