// SPDX-License-Identifier: GPL-3.0-or-later
// The picture that a light has to throw so that its shafts look as somebody painted them, from any number of cameras.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.2, "Light Map Optimization"; Klehm et al., Property and Lighting
//           Manipulations for Static Volume Stylization Using a Painting Metaphor, TVCG 20(7), 2014.
// Differs:  the matrix is built once, not marched through in each step; the map is not negative; what no stroke sees stays
//           as it is. A light with a size is fitted as its centre: its blur is not undone.
// Data flow: strokes -> rays that end at the first surface -> what each sees lit -> focus of a sun's map -> matrix -> steps.
#pragma once
#include "light_shafts/light_map_fit_place.hpp"
#include "light_shafts/light_map_fit_solver.hpp"
#include "light_shafts/light_shafts.hpp"
#include <memory>

namespace tyndall::light_shafts {
/// A pixel that was painted.
struct StrokePixel {
    ViewRay ray;  ///< Up to the first surface.
    Rgb desired;  ///< What the light should be multiplied by, >= 0: 1 is its own colour.
    float weight; ///< How much it matters, > 0.
};
/// All of them that one camera sees.
struct Strokes {
    View view;
    std::vector<StrokePixel> pixels;
};

struct LightMapFitConfig {
    std::size_t light = 0;          ///< Into Scene::lights.
    std::uint32_t resolution = 512; ///< Texels per side, [16, 4096].
    float regularisation = 1e-3f;   ///< How much the map stays what it is, [0, 1e6]: see LightMapSolver.
    /// Rays within so many texels of each other read the same line of the map, [0, 1]; 0: each its own.
    float shared_texels = 0.15f;
    Config shafts;
};

class StrokeView; // light_map_fit_view.hpp

class LightMapFit {
public:
    /// Finds what the strokes see and builds the matrix. `current` is what the map stays close to, and its first guess;
    /// without texels: white. Where it has the resolution and covers what the strokes see, the fitted map has its place.
    /// Throws InvalidInput that names what is missing, and Cancelled.
    LightMapFit(const Scene& scene, const Media& media, std::span<const Strokes> strokes, const LightMap& current,
                const LightMapFitConfig& config, Progress& progress);
    LightMapFit(const LightMapFit&) = delete;
    LightMapFit& operator=(const LightMapFit&) = delete;
    ~LightMapFit();

    /// Takes at most so many steps; false: the map is as good as it gets. After Cancelled it is that of the last whole step.
    bool iterate(std::uint32_t step_count, Progress& progress);
    [[nodiscard]] LightMap map() const;
    [[nodiscard]] const LightMapPlace& place() const { return place_; }
    /// Of the first map and after each step.
    [[nodiscard]] std::span<const FitStep> history() const { return solver_->history(); }
    [[nodiscard]] const LightMapMatrix& matrix() const { return *matrix_; }
    /// Which pixel each ray of the matrix is of, counted over all strokes.
    [[nodiscard]] std::span<const std::uint32_t> pixel_of_ray() const { return pixel_of_ray_; }
    [[nodiscard]] const Statistics& statistics() const { return statistics_; }

private:
    void build_for_sun(std::span<const StrokeView> views, const Media& media, const Light& sun, const LightMap& current,
                       const LightMapFitConfig& config, const Progress& progress);
    void build_for_lamp(std::span<const StrokeView> views, const Media& media, const Light& lamp,
                        const LightMapFitConfig& config, const Progress& progress);

    Statistics statistics_;
    LightMapPlace place_;
    std::vector<std::uint32_t> pixel_of_ray_;
    std::unique_ptr<const LightMapMatrix> matrix_;
    std::unique_ptr<LightMapSolver> solver_;
};
} // namespace tyndall::light_shafts
