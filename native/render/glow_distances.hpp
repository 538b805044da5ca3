// SPDX-License-Identifier: GPL-3.0-or-later
// Where along a view ray in media the light of one triangle, or of one lamp, is scattered towards the camera: distances
// drawn about as often as that is bright.
// Based on: Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in Participating Media, EGSR 2012:
//           distances that are spread evenly over the angle under which a light sees them.
// Differs:  not one of equi-angular and transmittance sampling, nor both weighed, but their product and more: the ray is
//           cut at even angles, where media begin, and where they have taken even shares of the light; each cell has the
//           brightness of its middle, with the phase function, what the triangle covers of the sky there, and what even
//           fog takes on both ways. Within a cell angles are even. A share of the draws is
//           spread over all angles: what the middles overlook is seldom, not never.
// Bound:    some 20 cells a draw, 20 ns each.
#pragma once
#include "render/media_line.hpp"
#include "render/mesh_emitters.hpp"
#include <array>

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
    struct Cell {
        float from_x, to_x; ///< Tangents of the angles between which it lies.
        float angle_rad, weight;
        const MediaLine::Piece* piece;
    };
    void cut(float area_m2, const Reach& reach, const Media* light_side);
    /// How often a cell is drawn.
    [[nodiscard]] float share_of(const Cell& cell) const {
        const float by_weight = weight_sum_ > 0.0f ? (1.0f - blind_share) / weight_sum_ : 0.0f;
        const float by_angle = (weight_sum_ > 0.0f ? blind_share : 1.0f) / angle_sum_rad_;
        return by_weight * cell.weight + by_angle * cell.angle_rad;
    }
    void add_cell(const MediaLine::Piece& piece, float from_x, float to_x);
    [[nodiscard]] float seen_sr(const vec3& point, const vec3& way, float distance2) const;
    [[nodiscard]] float brightness(const MediaLine::Piece& piece, float at_m) const;
    /// At the ends of the line and where it is nearest; straight between these.
    void find_light_side(const Media& media, float near_m, float far_m);
    [[nodiscard]] Rgb light_side_depth(float at_m) const;
    [[nodiscard]] static std::vector<Cell>& cells();

    const MediaLine& line_;
    const EmissiveTriangle* triangle_; ///< Nothing: a lamp.
    struct LightSide {
        float at_m = 0.0f;
        Rgb depth{0.0f};
    };
    std::array<LightSide, 3> light_side_{};
    bool has_light_side_ = false;
    vec3 centre_;
    float radius2_, foot_m_, off_m_; ///< Of what glows; where the line is nearest to it, and how near.
    float weight_sum_ = 0.0f, angle_sum_rad_ = 0.0f;
};
} // namespace tyndall::render
