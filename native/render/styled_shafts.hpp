// SPDX-License-Identifier: GPL-3.0-or-later
// The light that media scatter, kept apart from the rest of a picture with the parameters of its rays, so that transfer
// functions recolour it, and recolour it again without a ray.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.2.
// Differs:  the paper looks a function up once per pixel. Where a pixel sees a branch before the sky, the mean of their
//           depths is neither's, and its colour belongs to neither: a fringe. And samples of soft lights hold noise, which
//           a function with edges turns into bias. So each pixel has two cells, of surfaces at different depths: samples
//           are averaged within a cell, cells are looked up.
//           Where the air has a texture, functions colour the light of even air, and their colours keep the texture.
// Data flow: per sample 1 radiance and 1 or 2 parameters into a cell (44 bytes, 2 cells); per lookup 20 bytes in, 12 out.
#pragma once
#include "core/progress.hpp"
#include "render/film.hpp"
#include "render/ray_parameters.hpp"
#include "transfer_functions/transfer_function.hpp"
#include <memory>
#include <span>
#include <vector>

namespace tyndall::render {
/// A point of the scene that constraints stand for, and where its view ray is in each function.
struct PlacedPoint {
    vec3 point;
    std::vector<vec2> parameters; ///< Per function.
};

/// A picture with the light shafts' cells beside it: all that a change of the functions' layers needs.
struct UnstyledFilm {
    Film film; ///< As it is without transfer functions.
    struct Entries {
        std::vector<std::uint32_t> pixel;
        std::vector<Rgb> radiance;                 ///< Its part of the pixel's.
        std::vector<float> share;                  ///< Of the pixel's samples.
        std::vector<std::vector<vec2>> parameters; ///< Per function.
        std::vector<float> heterogeneity;          ///< Of the air, which its colour keeps; empty: 1.
    } entries;                                     ///< Those of a pixel lie side by side, pixels rise.
    std::vector<PlacedPoint> points;
};

/// Collects the samples of a frame. Pixels are independent: threads may add to different ones.
class StyledShafts {
public:
    /// `is_textured`: samples have a heterogeneity other than 1.
    StyledShafts(std::uint32_t width_px, std::uint32_t height_px, std::size_t function_count, bool is_textured = false);
    /// One per pixel and pass; `parameters`, one per function, are not read where the ray meets no medium.
    void add(std::size_t pixel, const SeenSurface& surface, const SeenShafts& shafts, std::span<const vec2> parameters);
    [[nodiscard]] UnstyledFilm::Entries resolve(const Progress& progress) const;

private:
    struct Cell {
        std::uint32_t count = 0;
        float depth_m = 0.0f; ///< Of the first sample's surface; 0: the sky.
        Rgb radiance{0.0f};
        float textured_light = 0.0f, heterogeneity = 0.0f; ///< Mean channel of the textured radiance; sums.
    };
    static constexpr std::size_t cells_per_pixel = 2;
    [[nodiscard]] std::size_t cell_for(std::size_t pixel, float depth_m) const;

    std::uint32_t width_px_;
    std::size_t function_count_;
    bool is_textured_;
    std::vector<std::uint32_t> sample_counts_;
    std::vector<Cell> cells_;
    std::vector<vec2> parameters_; ///< Sums, per cell and function.
};

/// The picture with the functions applied to its light shafts: in Combined, and in Shafts where that is a pass.
/// Constraints with a point that the film knows are placed there; others stay at their position. The functions have the
/// axes of those that the film was rendered with; InvalidInput unless they are as many. Throws Cancelled.
[[nodiscard]] Film styled(const UnstyledFilm& unstyled, std::vector<transfer_functions::WeightedFunction> functions,
                          const Progress& progress);
} // namespace tyndall::render
