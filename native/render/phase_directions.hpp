// SPDX-License-Identifier: GPL-3.0-or-later
// Places along a view ray in media, and directions from there, drawn as a light that is the same from everywhere would be
// scattered: what fog that scatters mostly onwards sees of what glows.
// Based on: Henyey and Greenstein's function, inverted (Witt, Astrophysical Journal Supplement 35, 1977); distances by the
//           transmittance, as in Kulla and Fajardo 2012.
// Differs:  the same media that scatter are weighed, in the mean of their channels: the density is told for any place and
//           direction, so that these draws can be weighed against others (Veach 1997, section 9.2). Draine's factor is
//           left out of the draws: their weights have it.
// Bound:    an exponential a piece; 50 ns a draw.
#pragma once
#include "render/media_line.hpp"
#include <vector>

namespace tyndall::render {
class PhaseDirections {
public:
    explicit PhaseDirections(const MediaLine& line);
    struct Drawn {
        const MediaLine::Piece* piece = nullptr; ///< Nothing: nothing scatters.
        float at_m = 0.0f;
        vec3 direction{0.0f}; ///< That light comes from.
    };
    [[nodiscard]] Drawn at(vec2 u, vec2 u_direction) const;
    struct Distance {
        const MediaLine::Piece* piece = nullptr; ///< Nothing: nothing scatters.
        float at_m = 0.0f;
    };
    [[nodiscard]] Distance distance(float u) const;
    [[nodiscard]] float density_per_m(const MediaLine::Piece& piece, float at_m) const;
    /// Per metre and steradian.
    [[nodiscard]] float density(const MediaLine::Piece& piece, float at_m, const vec3& direction) const;

private:
    const MediaLine& line_;
    float sum_ = 0.0f;
};
} // namespace tyndall::render
