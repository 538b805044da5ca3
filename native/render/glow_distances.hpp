// SPDX-License-Identifier: GPL-3.0-or-later
// Where along a view ray in media the light of one triangle, or of one lamp, is scattered towards the camera: distances
// drawn about as often as that is bright.
// Based on: Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in Participating Media, EGSR 2012:
//           distances that are spread evenly over the angle under which a light sees them.
// Differs:  not one of equi-angular and transmittance sampling, nor both weighed, but their product and more: the ray is
//           cut at even angles, where media begin, and where they have taken even shares of the light; each cell has the
//           brightness of its middle (glow_cells.hpp), with the phase function, what the triangle covers of the sky there,
//           and what even fog takes on both ways. Within a cell angles are even. A share of the draws is spread over all
//           angles: what the middles overlook is seldom, not never.
// Bound:    2 to 17 cells a draw in even fog, 5 ns each, and as much again.
#pragma once
#include "render/glow_cells.hpp"

namespace tyndall::render {
class GlowDistances {
public:
    struct Distance {
        float at_m = 0.0f;
        const MediaLine::Piece* piece = nullptr;
        float pdf_per_m = 0.0f; ///< 0: there is none.
    };
    /// `light_side`: media that dim light on its way to the line; nothing: none.
    GlowDistances(const MediaLine& line, const EmissiveTriangle& triangle, const Media* light_side);
    /// Distances between which a lamp shines on a line.
    struct Reach {
        float near_m, far_m;
    };
    /// Of a lamp of about this radius, as if it shone all around within its reach.
    GlowDistances(const MediaLine& line, const vec3& lamp, float radius_m, const Reach& reach, const Media* light_side);
    /// By a number in [0, 1). Of the latest cells of this thread alone.
    [[nodiscard]] Distance at(float u) const;
    /// With which at() returns a distance in a piece.
    [[nodiscard]] float density_per_m(const MediaLine::Piece& piece, float at_m) const;

private:
    static constexpr float blind_share = 0.05f; ///< Of the draws, spread over all angles.
    void cut(float area_m2, const Reach& reach, const Media* light_side);
    void append_cells(float first_x, float last_x);
    /// At the ends of the line and where it is nearest.
    void find_light_side(const Media& media, float near_m, float far_m);
    /// How often a cell is drawn.
    [[nodiscard]] float share_of(std::size_t cell) const {
        return share_per_weight_ * cells_.weight(cell) + share_per_rad_ * cells_.angle_rad(cell);
    }
    [[nodiscard]] static GlowCells& kept_cells();

    const MediaLine& line_;
    GlowBesideLine glow_;
    GlowCells& cells_;
    float share_per_weight_ = 0.0f, share_per_rad_ = 0.0f;
};
} // namespace tyndall::render
