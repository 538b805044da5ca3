// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of the light map's matrix that view rays before a lamp have: a spot throws its map over its cone, a point light all
// around it. What a ray scatters between two lines of texels is integrated as the shafts are, with falloff, cone and shadows.
// Based on: Joseph 1982 (light_map_fit_matrix.hpp). A slide keeps straight lines straight, so that a ray is one chord of a
//           spot's map, and where it crosses line n is a quotient of linear functions of the distance.
// Differs:  around a point light a ray is a curve in longitude and latitude: it is cut into chords that lie within a tenth of a
//           texel of it, and crosses the seam.
// Bound:    local_scatter.hpp per line that a ray crosses: six points, in SIMD lanes.
#pragma once
#include "light_shafts/light_map_fit_matrix.hpp"
#include "light_shafts/local_scatter.hpp"
#include "scene/light_texture.hpp"

namespace tyndall::light_shafts {
/// Where a lamp throws the texels of a square map. Texel i has its centre at i; longitudes go on beyond the seam.
class ThrownMap {
public:
    /// Of a spot or a point light without a size.
    ThrownMap(const Light& lamp, std::uint32_t resolution);
    /// A straight piece of the map that a piece of a ray crosses.
    struct Chord {
        double begin, end; ///< On the ray, from the foot.
        bool goes_along_y; ///< It crosses rows of texels, not columns.
        double across_at_zero, across_per_line;
        glm::dvec4 along; ///< Position along it at x, in texels: (along.x + along.y x) / (along.z + along.w x).
        [[nodiscard]] double position(double x) const { return (along.x + along.y * x) / (along.z + along.w * x); }
        [[nodiscard]] double place_of(double line) const {
            return (along.x - line * along.z) / (line * along.w - along.y);
        }
    };
    /// Overwrites, in order: of the part [from.begin, from.end] of a ray.
    void find_chords(const ViewRay& ray, const RayFromFoot& from, std::vector<Chord>& chords) const;
    [[nodiscard]] bool is_around() const { return is_around_; }
    [[nodiscard]] std::uint32_t resolution() const { return resolution_; }

private:
    struct Curve;
    void append_chords(const Curve& curve, const dvec2& begin, double from_rad, double to_rad, int depth,
                       std::vector<Chord>& chords) const;

    vec3 position_;
    bool is_around_;
    std::uint32_t resolution_;
    glm::dmat3 map_from_way_; ///< Of the way from the lamp: to texels times depth, and depth; around: to its axes.
};

/// Makes rows, four weights per line. One per thread.
class LampRowMaker {
public:
    LampRowMaker(const LocalScatter& lamp, const Visibility* visibility, const ThrownMap& map)
        : lamp_(lamp), visibility_(visibility), map_(map) {}
    /// A row for each ray.
    void add_rows(const LocalRays& rays, LightMapMatrix::Part& part);

private:
    struct ChordOfRay {
        std::uint32_t ray;
        ThrownMap::Chord chord;
    };
    void add_chord(const ThrownMap::Chord& chord, std::span<const LocalPart> parts, LightMapMatrix::Part& part);

    const LocalScatter& lamp_;
    const Visibility* visibility_;
    const ThrownMap& map_;
    std::vector<ThrownMap::Chord> of_ray_;
    std::vector<ChordOfRay> chords_;
    std::vector<LocalPart> parts_;
    std::vector<float> positions_, amounts_, line_weights_;
};
} // namespace tyndall::light_shafts
