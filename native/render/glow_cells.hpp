// SPDX-License-Identifier: GPL-3.0-or-later
// Cells of a view ray in media, side by side, and how much of what glows each of them scatters towards the camera.
// Differs:  by the middles of cells, as many at once as a vector has lanes. A triangle that is near covers of the sky what
//           Van Oosterom and Strackee's formula (1983) says, to 1 %: the weights choose, and the choice is weighed.
// Bound:    40 ns for 16 cells of one medium with AVX-512.
#pragma once
#include "render/media_line.hpp"
#include "render/mesh_emitters.hpp"
#include <array>

namespace tyndall::render {
/// A triangle, or a lamp, beside a line.
struct GlowBesideLine {
    vec3 from_origin{0.0f};                     ///< From the line's origin to its middle.
    float radius2 = 0.0f;                       ///< Squared, around that.
    float foot_m = 0.0f, off_m = 1.0f;          ///< Where the line is nearest to it, and how near.
    const EmissiveTriangle* triangle = nullptr; ///< Nothing: a lamp.
    /// What dims its light on the way to the line, straight between three places.
    struct DepthFrom {
        float at_m = 0.0f;
        Rgb depth{0.0f}, per_m{0.0f};
    };
    std::array<DepthFrom, 2> light_side{}; ///< The second one from its place on.
    bool is_dimmed = false;
};

class GlowCells {
public:
    void clear();
    /// Tangents of the angles between which it lies, seen from the middle of what glows; in the order of the line.
    void append(const MediaLine::Piece& piece, float from_x, float to_x);
    /// Finds angles and weights; call it once, after all is appended.
    void weigh(const MediaLine& line, const GlowBesideLine& glow);

    [[nodiscard]] std::size_t size() const { return pieces_.size(); }
    [[nodiscard]] const MediaLine::Piece& piece(std::size_t cell) const { return *pieces_[cell]; }
    [[nodiscard]] float from_x(std::size_t cell) const { return from_x_[cell]; }
    [[nodiscard]] float to_x(std::size_t cell) const { return to_x_[cell]; }
    [[nodiscard]] float angle_rad(std::size_t cell) const { return angle_rad_[cell]; }
    /// The brightness of its middle times its length, up to a factor.
    [[nodiscard]] float weight(std::size_t cell) const { return weight_[cell]; }

private:
    std::vector<const MediaLine::Piece*> pieces_;
    std::vector<float> from_x_, to_x_, angle_rad_, weight_; ///< With room for a vector behind the last one.
};
} // namespace tyndall::render
