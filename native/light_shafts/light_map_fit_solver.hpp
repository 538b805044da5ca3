// SPDX-License-Identifier: GPL-3.0-or-later
// The map without negative texels whose rays come closest to what they should show: for each channel alone, least
//     sum of weight |T x - target|^2 over the rays + lambda |x - prior|^2 over the texels, x >= 0.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.2 (conjugate gradients on the normal equations); Dostal, Schoeberl,
//           Minimizing Quadratic Functions Subject to Bound Constraints with the Rate of Convergence and Finite
//           Termination, Computational Optimization and Applications 30, 2005 (when a texel may leave 0); Kruzik et al.,
//           Active Set Expansion Strategies in MPRGP Algorithm, Advances in Engineering Software 149, 2020 (the
//           projected conjugate gradient step).
// Differs:  the paper leaves the map free to become negative, and calls the solution unique: with fewer rays than texels it
//           is not, and what no ray sees must stay what it is, which the prior sees to. Gradients are divided by the
//           diagonal, so that texels that few rays see do not lag behind. A projected step goes only as far as the objective
//           falls, and a step that rounding spoils is not taken: the objective never rises. Its length is that of the last
//           step, as good as the right one at a product less.
// Bound:    a product with T and one with its transpose per step, one more with T where texels reach 0 for the first time;
//           13 passes over the texels that some ray sees, 16 bytes each.
#pragma once
#include "light_shafts/light_map_fit_matrix.hpp"
#include "light_shafts/light_map_fit_passes.hpp"
#include <array>

namespace tyndall::light_shafts {
/// What a step has reached, each as a share of what a white map's radiance would give.
struct FitStep {
    std::array<double, 3> objective; ///< Of each channel.
    double residual;                 ///< Weighted RMS of T x - target, all channels.
};

class LightMapSolver {
public:
    /// `matrix` must outlive this. target: radiance per ray; ray_weight >= 0, one per ray; `start` and `prior`: >= 0, one
    /// colour per texel. regularisation: lambda, of the mean diagonal of T'WT over the texels that are seen, >= 0.
    LightMapSolver(const LightMapMatrix& matrix, std::span<const vec4> target, std::span<const float> ray_weight,
                   MapTexels start, MapTexels prior, float regularisation);

    /// Takes a step. False: the map is as good as float32 lets it be, and nothing has changed.
    bool step();
    [[nodiscard]] const MapTexels& texels() const { return texels_; }
    /// Of the first map and after each step: no channel's objective ever rises.
    [[nodiscard]] std::span<const FitStep> history() const { return history_; }
    [[nodiscard]] std::size_t seen_texel_count() const { return seen_texel_count_; }

private:
    /// A number per channel; the last is not used.
    using Channels = glm::dvec4;
    struct Stretch {
        std::uint32_t begin, end;
    };
    /// As light_map_passes has them, over all seen texels.
    struct Along {
        Channels gradient{0.0}, square{0.0}, prior{0.0};
        vec4 limit{std::numeric_limits<float>::infinity()};
        Along& operator+=(const light_map_passes::Along& stretch);
        Along& operator+=(const Along& other);
    };
    struct Norms {
        Channels free{0.0}, held{0.0};
        Norms& operator+=(const light_map_passes::Norms& stretch);
        Norms& operator+=(const Norms& other);
    };
    template <typename Sum, typename Work>
    [[nodiscard]] Sum sum_over_seen(Sum zero, const Work& work) const;
    [[nodiscard]] Channels sum_over_rays(const std::vector<vec4>& radiance) const;
    [[nodiscard]] light_map_passes::Arrays arrays();
    void find_seen(const MapTexels& diagonal);
    /// Where the whole step would leave what is allowed: the step to the nearest map that is, and its sums.
    /// Shortens the length where the objective would rise at once.
    [[nodiscard]] Along project(vec4& length, const Along& along);
    /// To where the objective is least along it; 0 for a channel that is done.
    [[nodiscard]] vec4 length_of_step(const MapTexels& direction, const Along& along);
    /// Moves the texels of the map and finds the gradient there.
    [[nodiscard]] Norms move(const MapTexels& direction, const vec4& length);
    /// The next direction, and its sums: conjugate to the last one, or afresh, with the texels that would leave 0.
    void turn_after(const Norms& norms, const glm::bvec4& restarts);
    void record();

    const LightMapMatrix& matrix_;
    std::vector<vec4> ray_weights_, residual_, moved_; ///< Per ray: weight; target - T x; T times a direction.
    LightMapMatrix::Scratch scratch_;
    MapTexels texels_, prior_, gradient_, direction_, displacement_;
    MapTexels scale_; ///< 1 / (the diagonal of T'WT + lambda).
    float lambda_ = 0.0f;
    std::vector<Stretch> seen_; ///< Of texels.
    std::size_t seen_texel_count_ = 0;
    Channels white_square_{0.0}, fit_square_{0.0}, prior_square_{0.0}, free_square_{0.0};
    Along along_;
    vec4 guess_{0.0f}; ///< How long the next step might be.
    glm::bvec4 is_fresh_{true}, is_done_{false};
    std::vector<FitStep> history_;
};
} // namespace tyndall::light_shafts
