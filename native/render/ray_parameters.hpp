// SPDX-License-Identifier: GPL-3.0-or-later
// The parameters of view rays that transfer functions are defined over.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.2.
// Differs:  the paper has average visibility and linear depth; see transfer_functions::Axis. An axis whose range is fitted
//           takes it from a fixed grid of rays through the full frame, so that a region keeps the picture's colours.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "render/film.hpp"
#include "scene/scene.hpp"
#include "transfer_functions/transfer_function.hpp"
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace tyndall::render {
/// Raster positions of the rays that fitted ranges are taken from.
[[nodiscard]] std::vector<vec2> grid_places_px(const Camera& camera);

/// What a camera ray meets.
struct SeenSurface {
    float depth_m = 0.0f;  ///< Of PathSample; 0: the sky.
    float height_m = 0.0f; ///< World Z.
    float opacity = 0.0f;  ///< Of the media before it: 1 - transmittance, mean over the channels.
};
/// What the media along it scatter.
struct SeenShafts {
    bool meets_medium = false;
    Rgb radiance{0.0f};
    Rgb textured_radiance{0.0f}; ///< The same, of air with its texture.
    float heterogeneity = 1.0f;  ///< The texture alone: their mean ratio, or that of the parts where all is dark.
    float visibility = 0.0f;
    float lit_distance_m = 0.0f; ///< Mean over the lit points; 0: none is lit.
};

class RayParameters {
public:
    /// `functions` must outlive this.
    RayParameters(const Scene& scene, const Camera& camera,
                  std::span<const transfer_functions::WeightedFunction> functions,
                  std::optional<std::uint32_t> reference_light);

    [[nodiscard]] std::size_t function_count() const { return axes_.size(); }
    /// Whose visibility and lit parts are meant; none: the mean over all lights.
    [[nodiscard]] std::optional<std::uint32_t> visibility_light() const { return visibility_light_; }
    [[nodiscard]] bool asks_for(transfer_functions::Axis axis) const;
    [[nodiscard]] SeenSurface seen(const PathSample& sample) const;
    /// Of the ray through raster position `place_px` of the full frame, over the axes of a function.
    [[nodiscard]] vec2 at(std::size_t function, vec2 place_px, const SeenSurface& surface,
                          const SeenShafts& shafts) const;
    /// An axis of visibility takes its range from the frame: fit_visibility comes before at().
    [[nodiscard]] bool fits_visibility() const;
    void fit_visibility(std::vector<float> visibility_of_grid);

private:
    struct PlacedAxis {
        transfer_functions::Axis axis;
        float low, high; ///< What 0 and 1 are.
        bool waits_for_visibility;
        const Texture* mask;
    };
    [[nodiscard]] PlacedAxis place(const transfer_functions::ParameterAxis& axis);
    [[nodiscard]] float along(const PlacedAxis& axis, vec2 place_px, const SeenSurface& surface,
                              const SeenShafts& shafts) const;
    [[nodiscard]] float light_angle(vec2 place_px) const;
    void look_around();

    const Scene& scene_;
    const Camera& camera_;
    std::vector<std::array<PlacedAxis, 2>> axes_; ///< Per function.
    const Light* light_ = nullptr;                ///< That angles are measured from.
    std::optional<std::uint32_t> visibility_light_;
    std::vector<float> depths_m_, heights_m_; ///< Of the grid's surfaces, ascending; empty until an axis is fitted.
};

/// What a pixel gets of the parts of its ray, each with the share that lies in front of it. No heterogeneity: it is 1.
[[nodiscard]] SeenShafts sum_of_parts(std::span<const Rgb> weights, std::span<const Rgb> radiance,
                                      std::span<const float> visibility,
                                      std::span<const light_shafts::LitMoments> moments,
                                      std::span<const float> heterogeneity = {});
} // namespace tyndall::render
