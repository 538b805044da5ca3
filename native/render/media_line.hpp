// SPDX-License-Identifier: GPL-3.0-or-later
// A part of a view ray in its media, piece by piece: what it scatters at a place, and how much of that the camera sees.
// Differs:  of density grids a piece has the mean density, to choose places by; what is said of a place is exact.
// Bound:    a piece per homogeneous segment, and per step among the density of grids; see medium_steps.hpp.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "scene/medium_steps.hpp"
#include "shading/light_links.hpp"
#include <vector>

namespace tyndall::render {
class MediaLine {
public:
    /// A phase function and how much it scatters.
    struct Lobe {
        float sigma_s_per_m; ///< Mean of the channels.
        float asymmetry_g, draine_alpha;
    };
    struct Piece {
        float near_m, far_m;
        Rgb depth{0.0f}; ///< Optical depth before near_m.
        Rgb sigma_t_per_m{0.0f};
        std::uint32_t segment = 0; ///< Its homogeneous media.
        std::uint32_t first_lobe = 0, lobe_count = 0;
        float sigma_s_per_m = 0.0f; ///< Of all lobes.
        [[nodiscard]] Rgb depth_at(float at_m) const { return depth + sigma_t_per_m * (at_m - near_m); }
    };

    /// Finds the pieces of a part; the references must outlive what is asked afterwards.
    void assign(const Media& media, const light_shafts::ViewRay& part, const StepLimits& limits);
    [[nodiscard]] bool is_empty() const { return pieces_.empty(); }
    [[nodiscard]] const vec3& origin() const { return part_.origin; }
    [[nodiscard]] const vec3& direction() const { return part_.direction; }
    /// Near to far; gaps lie between some of them.
    [[nodiscard]] std::span<const Piece> pieces() const { return pieces_; }
    [[nodiscard]] std::span<const Lobe> lobes_of(const Piece& piece) const {
        return std::span(lobes_).subspan(piece.first_lobe, piece.lobe_count);
    }
    /// Some of it scatters mostly onwards or back.
    [[nodiscard]] bool has_peak() const { return has_peak_; }
    /// Of all of it, mean of the channels.
    [[nodiscard]] float sigma_t_per_m() const { return sigma_t_per_m_; }
    /// Distances between which the media take equal shares of the light, near to far; few where they take little of it.
    [[nodiscard]] std::span<const float> equal_losses_m() const { return equal_losses_m_; }

    /// Share of what is scattered there that reaches the part's beginning.
    [[nodiscard]] Rgb transmittance(const Piece& piece, float at_m) const;
    /// Scattered there towards the camera, per metre and steradian, of light from a direction; only by media that
    /// an emitter lights.
    [[nodiscard]] Rgb scatter_per_m_sr(const Piece& piece, float at_m, const vec3& to_light,
                                       const LightLinks* links) const;

private:
    void append(const MediumSegment& segment, std::uint32_t index, const MediumStep* step);
    void append_lobes(std::uint16_t medium, float density);
    void divide_losses();

    const Media* media_ = nullptr;
    light_shafts::ViewRay part_{};
    float sigma_t_per_m_ = 0.0f;
    bool has_peak_ = false;
    std::vector<MediumSegment> segments_;
    MediumSteps steps_; ///< Where there are density grids.
    std::vector<Piece> pieces_;
    std::vector<Lobe> lobes_;
    std::vector<float> equal_losses_m_;
};
} // namespace tyndall::render
