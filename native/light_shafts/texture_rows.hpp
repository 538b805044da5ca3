// SPDX-License-Identifier: GPL-3.0-or-later
// A picture across light that falls in parallel, as the rays of one view read it: all rays in a plane with the light's
// direction cross the picture along one line, so that running integrals along a fan of such lines answer every ray.
// Based on: Baran et al., A Hierarchical Volumetric Shadow Algorithm for Single Scattering, SIGGRAPH Asia 2010 (epipolar
//           rectification); Crow, Summed-Area Tables, SIGGRAPH 1984; integration by parts.
// Differs:  a lit part of a ray scatters the integral of an exponential times the colour: w1 B - (w1 - w0) mean(P), where P
//           is the running integral of the colour and B what it gains. P is smooth however rough the picture is, and
//           Simpson's rule finds its mean. Scaled so that a white picture gives the closed form, to float precision.
// Bound:    3 exponentials and 2 look-ups of two lines per 0.15 optical depths of a lit part, however many texels it
//           crosses. Lines are at most most_lines, with most_samples each, and are made when a ray first asks for them;
//           where the picture is finer they hold its means over squares as wide as their spacing.
#pragma once
#include "light_shafts/visibility.hpp"
#include "scene/light_texture.hpp"
#include <algorithm>
#include <limits>
#include <mutex>
#include <optional>

namespace tyndall::light_shafts {
class TextureRows {
public:
    static constexpr std::uint32_t most_lines = 6144, most_samples = 2048;

    /// `rays`: some that will be asked, clipped to the media. The light must outlive this.
    TextureRows(const Light& light, const View& view, std::span<const ViewRay> rays);

    /// What the lit parts of a ray of the view scatter, W/(m^2 sr); nothing: the lines do not reach it. Safe from any
    /// thread.
    [[nodiscard]] std::optional<Rgb> scattered(const ViewRay& ray, std::span<const ScatterPiece> pieces,
                                               std::span<const LitInterval> lit) const;

private:
    struct Line {
        std::once_flag once;
        std::vector<Rgb> running; ///< Integral of the colour from the line's begin to each sample, in texels.
    };
    /// How a ray crosses the picture, in texels.
    struct Crossing {
        float line;         ///< Radians from the reference, or texels across.
        float at_zero;      ///< Of the ray's origin along the line.
        float texels_per_m; ///< Along the line.
    };
    struct Range {
        float least = std::numeric_limits<float>::infinity(), most = -std::numeric_limits<float>::infinity();
        void grow(float value) { least = std::min(least, value), most = std::max(most, value); }
    };
    struct Extent {
        Range lines, texels;
    };
    [[nodiscard]] Extent extent_of(std::span<const ViewRay> rays);
    [[nodiscard]] Range picture_along() const;
    [[nodiscard]] Crossing crossing_of(const ViewRay& ray) const;
    [[nodiscard]] const std::vector<Rgb>& line(std::uint32_t index) const;
    [[nodiscard]] vec2 texel_at(const vec3& point) const { return placement_.uv(point) * size_; }

    const LightTexture& texture_;
    PlanarPlacement placement_;
    vec2 size_;
    bool is_parallel_;
    vec2 start_{0.0f};                              ///< Texels: where the lines of a perspective view meet.
    float reference_rad_ = 0.0f;                    ///< Their angles are measured from it.
    vec2 along_{1, 0};                              ///< Of parallel lines.
    float first_line_ = 0.0f, line_step_ = 1.0f;    ///< As Crossing::line.
    float begin_ = 0.0f, end_ = 0.0f, step_ = 1.0f; ///< Texels along each line.
    std::uint32_t line_count_ = 0, sample_count_ = 0;
    bool is_dark_outside_; ///< Beside the picture there is no light: lines end there, rays need not.
    mutable std::vector<Line> lines_;
};
} // namespace tyndall::light_shafts
