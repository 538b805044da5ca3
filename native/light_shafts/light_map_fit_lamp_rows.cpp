// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_lamp_rows.hpp"
#include "light_shafts/light_map_fit_rows.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::light_shafts {
namespace {
constexpr double most_from_curve_texels = 0.1;
constexpr int first_chords = 4, most_halvings = 8;

/// Positions along a chord from its ends and its middle, if it goes one way.
glm::dvec4 through(const dvec3& x, const dvec3& position) {
    // x is 0 at the middle, and so is position; then position = s x / (1 + t x).
    const double a = x[0] - x[1], b = x[2] - x[1], u = position[0] - position[1], v = position[2] - position[1];
    if (!(u * v < 0.0)) { // as straight as can be
        const double per_m = (position[2] - position[0]) / (x[2] - x[0]);
        return {position[0] - per_m * x[0], per_m, 1.0, 0.0};
    }
    // s a - t a u = u and s b - t b v = v
    const double determinant = a * b * (u - v);
    const double s = (a - b) * u * v / determinant, t = (a * v - b * u) / determinant;
    return {position[1] * (1.0 - t * x[1]) - s * x[1], position[1] * t + s, 1.0 - t * x[1], t};
}

ThrownMap::Chord chord_between(double begin, double end, const dvec2& from, const dvec2& to) {
    const dvec2 way = to - from;
    const int axis = std::abs(way.y) > std::abs(way.x) ? 1 : 0;
    const double slope =
        way[axis] != 0.0 ? way[1 - axis] / way[axis] : 0.0; // straight into the lamp: it stays where it is
    return {.begin = begin,
            .end = end,
            .goes_along_y = axis == 1,
            .across_at_zero = from[1 - axis] - slope * from[axis],
            .across_per_line = slope,
            .along = {}};
}
} // namespace

/// A ray in the map of a point light, by the angle from its foot as the light sees it.
struct ThrownMap::Curve {
    dvec3 at_foot, per_m; ///< Along the map's axes.
    double light_m, texels;

    [[nodiscard]] double x(double angle_rad) const { return light_m * std::tan(angle_rad); }
    /// On that turn around the light which is nearest to another texel.
    [[nodiscard]] dvec2 texel(double angle_rad, const dvec2& near) const {
        const dvec3 way = std::cos(angle_rad) * at_foot + std::sin(angle_rad) * light_m * per_m;
        constexpr double per_turn = 0.5 * std::numbers::inv_pi;
        dvec2 at(0.5 - per_turn * std::atan2(way.x, way.y),
                 0.5 + 2.0 * per_turn * std::atan2(way.z, glm::length(dvec2(way))));
        at = at * texels - 0.5;
        at.x += texels * std::round((near.x - at.x) / texels);
        return at;
    }
};

ThrownMap::ThrownMap(const Light& lamp, std::uint32_t resolution)
    : position_(lamp.position), is_around_(lamp.kind == LightKind::Point), resolution_(resolution) {
    const LightTexture thrown = thrown_by(lamp);
    map_from_way_ = glm::dmat3(thrown.axes_from_world);
    if (is_around_)
        return;
    const double side = resolution;
    const glm::dmat3 texels_from_uv(side, 0.0, 0.0, 0.0, side, 0.0, -0.5, -0.5, 1.0);
    map_from_way_ = texels_from_uv * glm::dmat3(thrown.uv_from_projected) * glm::dmat3(mat3(thrown.place_from_axes)) *
                    map_from_way_;
}

void ThrownMap::append_chords(const Curve& curve, const dvec2& begin, double from_rad, double to_rad, int depth,
                              std::vector<Chord>& chords) const {
    const auto at = [&](double share) { return std::lerp(from_rad, to_rad, share); };
    const dvec2 quarter = curve.texel(at(0.25), begin), middle = curve.texel(at(0.5), quarter),
                three_quarters = curve.texel(at(0.75), middle), end = curve.texel(to_rad, three_quarters);
    Chord chord = chord_between(curve.x(from_rad), curve.x(to_rad), begin, end);
    const int axis = chord.goes_along_y ? 1 : 0;
    chord.along = through({chord.begin, curve.x(at(0.5)), chord.end}, {begin[axis], middle[axis], end[axis]});
    const auto deviation = [&](double share, const dvec2& texel) {
        const double along = chord.position(curve.x(at(share)));
        return std::max(std::abs(along - texel[axis]),
                        std::abs(chord.across_at_zero + chord.across_per_line * texel[axis] - texel[1 - axis]));
    };
    const double worst = std::max({deviation(0.25, quarter), deviation(0.5, middle), deviation(0.75, three_quarters)});
    if (depth == most_halvings || worst < most_from_curve_texels) {
        chords.push_back(chord);
        return;
    }
    append_chords(curve, begin, from_rad, at(0.5), depth + 1, chords);
    append_chords(curve, middle, at(0.5), to_rad, depth + 1, chords);
}

void ThrownMap::find_chords(const ViewRay& ray, const RayFromFoot& from, std::vector<Chord>& chords) const {
    chords.clear();
    const dvec3 direction(ray.direction);
    const dvec3 at_foot = map_from_way_ * (dvec3(ray.origin) + from.foot_m * direction - dvec3(position_)),
                per_m = map_from_way_ * direction;
    if (is_around_) {
        const Curve curve{at_foot, per_m, from.light_m, static_cast<double>(resolution_)};
        const double begin_rad = std::atan2(from.begin, from.light_m), end_rad = std::atan2(from.end, from.light_m);
        dvec2 begin = curve.texel(begin_rad, dvec2(0.5 * curve.texels));
        for (int index = 0; index < first_chords; ++index) {
            const double from_rad = std::lerp(begin_rad, end_rad, index / static_cast<double>(first_chords)),
                         to_rad = std::lerp(begin_rad, end_rad, (index + 1) / static_cast<double>(first_chords));
            append_chords(curve, begin, from_rad, to_rad, 0, chords);
            begin = curve.texel(to_rad, begin);
        }
        return;
    }
    const auto texel = [&](double x) {
        const dvec3 at = at_foot + x * per_m;
        return dvec2(at) / at.z;
    };
    const dvec2 first = texel(from.begin), last = texel(from.end);
    Chord chord = chord_between(from.begin, from.end, first, last);
    const int axis = chord.goes_along_y ? 1 : 0;
    chord.along = {at_foot[axis], per_m[axis], at_foot.z, per_m.z};
    chords.push_back(chord);
}

void LampRowMaker::add_chord(const ThrownMap::Chord& chord, std::span<const LocalPart> parts,
                             LightMapMatrix::Part& part) {
    const double last = static_cast<double>(map_.resolution()) - 1.0;
    const bool goes_round = map_.is_around() && !chord.goes_along_y;
    positions_.clear(), amounts_.clear();
    for (const LocalPart& lit : parts) {
        const double middle = 0.5 * (chord.position(lit.begin) + chord.position(lit.end));
        positions_.push_back(static_cast<float>(goes_round ? middle : std::clamp(middle, 0.0, last)));
        amounts_.insert(amounts_.end(), {lit.radiance.x, lit.radiance.y, lit.radiance.z});
    }
    const int first = static_cast<int>(deal_out(positions_, amounts_, 3, line_weights_));
    // Beyond the seam the map begins again: a new stretch there.
    const int side = static_cast<int>(map_.resolution()), count = static_cast<int>(line_weights_.size() / 4);
    const auto turn_of = [&](int line) {
        if (!map_.is_around())
            return 0.0;
        const double longitude =
            chord.goes_along_y ? chord.across_at_zero + chord.across_per_line * line + 0.5 : static_cast<double>(line);
        return std::floor(longitude / side);
    };
    for (int begin = 0, end = 0; begin < count; begin = end) {
        const double turn = turn_of(first + begin);
        while (end < count && turn_of(first + end) == turn)
            ++end;
        const int line = first + begin;
        const double across = chord.across_at_zero + chord.across_per_line * line;
        const auto own = std::span(line_weights_)
                             .subspan(4 * static_cast<std::size_t>(begin), 4 * static_cast<std::size_t>(end - begin));
        part.add_stretches(chord.goes_along_y,
                           static_cast<std::uint32_t>(chord.goes_along_y ? line : line - static_cast<int>(turn) * side),
                           static_cast<float>(chord.goes_along_y ? across - turn * side : across),
                           static_cast<float>(chord.across_per_line), own);
    }
}

void LampRowMaker::add_rows(const LocalRays& rays, LightMapMatrix::Part& part) {
    part.channels = 4;
    chords_.clear(), parts_.clear();
    const double last = static_cast<double>(map_.resolution()) - 1.0;
    lamp_.append_parts(
        rays, visibility_,
        [&](const RayFromFoot& from, std::vector<double>& cuts) {
            map_.find_chords(rays.ray(from.ray), from, of_ray_);
            for (const ThrownMap::Chord& chord : of_ray_) {
                chords_.push_back({from.ray, chord});
                cuts.push_back(chord.end);
                auto [low, high] = std::minmax({chord.position(chord.begin), chord.position(chord.end)});
                if (!(map_.is_around() && !chord.goes_along_y))
                    low = std::max(low, 0.0), high = std::min(high, last);
                for (double line = std::ceil(low); line < high; line += 1.0)
                    cuts.push_back(chord.place_of(line));
            }
        },
        parts_);
    auto chord = chords_.begin();
    auto lit = parts_.begin();
    for (std::uint32_t ray = 0; ray < rays.size(); ++ray) {
        for (; chord != chords_.end() && chord->ray == ray; ++chord) {
            const bool is_last = chord + 1 == chords_.end() || (chord + 1)->ray != ray;
            const auto begin = lit;
            while (lit != parts_.end() && lit->ray == ray &&
                   (is_last || 0.5 * (double{lit->begin} + double{lit->end}) < chord->chord.end))
                ++lit;
            if (begin != lit)
                add_chord(chord->chord, {begin, lit}, part);
        }
        part.end_ray();
    }
}
} // namespace tyndall::light_shafts
