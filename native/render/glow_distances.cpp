// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/glow_distances.hpp"
#include "volume/phase_function.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tyndall::render {
static constexpr int angle_count = 8;      ///< Cells of even angle along all of the line.
static constexpr float near_radii2 = 9.0f; ///< Squared distance, in radii, from which a triangle is as good as a point.
static constexpr float least_softness = 1e-4f; ///< Of the distance to a triangle: how near to it a line is at least.

/// Of a triangle as seen from the origin: Van Oosterom and Strackee 1983.
static float solid_angle_sr(const vec3& a, const vec3& b, const vec3& c) {
    const float length_a = glm::length(a), length_b = glm::length(b), length_c = glm::length(c);
    const float over = std::abs(glm::dot(a, glm::cross(b, c)));
    const float under = length_a * length_b * length_c + glm::dot(a, b) * length_c + glm::dot(a, c) * length_b +
                        glm::dot(b, c) * length_a;
    return 2.0f * std::atan2(over, under);
}

std::vector<GlowDistances::Cell>& GlowDistances::cells() {
    thread_local std::vector<Cell> kept;
    return kept;
}

GlowDistances::GlowDistances(const MediaLine& line, const EmissiveTriangle& triangle, const Media* light_side)
    : line_(line), triangle_(&triangle) {
    const auto& [a, b, c] = triangle.corners;
    centre_ = (a + b + c) * (1.0f / 3.0f);
    radius2_ = std::max(
        {glm::dot(a - centre_, a - centre_), glm::dot(b - centre_, b - centre_), glm::dot(c - centre_, c - centre_)});
    constexpr float unbounded = std::numeric_limits<float>::infinity();
    cut(triangle.area_m2, {-unbounded, unbounded}, light_side);
}

GlowDistances::GlowDistances(const MediaLine& line, const vec3& lamp, float radius_m, const Reach& reach,
                             const Media* light_side)
    : line_(line), triangle_(nullptr), centre_(lamp), radius2_(radius_m * radius_m) {
    cut(radius2_, reach, light_side);
}

void GlowDistances::cut(float area_m2, const Reach& reach, const Media* light_side) {
    const vec3 way = centre_ - line_.origin();
    foot_m_ = glm::dot(way, line_.direction());
    const vec3 off = way - foot_m_ * line_.direction();
    const float softness = least_softness * glm::length(way);
    off_m_ = std::sqrt(glm::dot(off, off) + 0.5f * area_m2 + softness * softness);
    cells().clear();
    const float near_m = std::max(line_.pieces().front().near_m, reach.near_m),
                far_m = std::min(line_.pieces().back().far_m, reach.far_m);
    if (!(near_m < far_m))
        return;
    if (light_side != nullptr)
        find_light_side(*light_side, near_m, far_m);
    // The tangent of a sum of angles, step by step: one arctangent at each end is all there is.
    const float first_x = (near_m - foot_m_) / off_m_, last_x = (far_m - foot_m_) / off_m_;
    const float step = std::tan(std::atan2(last_x - first_x, 1.0f + first_x * last_x) / angle_count);
    float angle_x = first_x;
    int angles_left = angle_count - 1;
    const auto next_angle = [&] {
        if (angles_left-- <= 0)
            return last_x;
        const float next = (angle_x + step) / (1.0f - angle_x * step);
        return next > angle_x ? std::min(next, last_x) : last_x;
    };
    angle_x = next_angle();
    auto loss = line_.equal_losses_m().begin();
    const auto loss_end = line_.equal_losses_m().end();
    for (const MediaLine::Piece& piece : line_.pieces()) {
        float x = (std::max(piece.near_m, near_m) - foot_m_) / off_m_;
        const float end_x = (std::min(piece.far_m, far_m) - foot_m_) / off_m_;
        while (x < end_x) {
            while (angle_x <= x && angle_x < last_x)
                angle_x = next_angle();
            while (loss != loss_end && *loss <= foot_m_ + off_m_ * x)
                ++loss;
            float to_x = end_x;
            if (angle_x > x)
                to_x = std::min(to_x, angle_x);
            if (loss != loss_end)
                if (const float loss_x = (*loss - foot_m_) / off_m_; loss_x > x)
                    to_x = std::min(to_x, loss_x);
            add_cell(piece, x, to_x);
            x = to_x;
        }
    }
}

void GlowDistances::add_cell(const MediaLine::Piece& piece, float from_x, float to_x) {
    // Half of the angle between (1, from) and (1, to), by its tangent: an eighth of half a circle at most.
    const float half =
        (to_x - from_x) / (1.0f + from_x * to_x + std::sqrt((1.0f + from_x * from_x) * (1.0f + to_x * to_x)));
    if (!(half > 0.0f))
        return;
    const float half2 = half * half; // of the series, what is left out is below 1e-7
    const float angle_rad =
        2.0f * half * (1.0f - half2 * (1.0f / 3.0f - half2 * (0.2f - half2 * (1.0f / 7.0f - half2 / 9.0f))));
    const float middle_x = std::clamp((from_x + half) / (1.0f - from_x * half), from_x, to_x);
    const float weight = brightness(piece, foot_m_ + off_m_ * middle_x) * (1.0f + middle_x * middle_x) * angle_rad;
    cells().push_back({from_x, to_x, angle_rad, std::isfinite(weight) ? weight : 0.0f, &piece});
    weight_sum_ += cells().back().weight;
    angle_sum_rad_ += angle_rad;
}

/// What covers it of the sky at a point, or of a lamp as if it shone from there in all directions.
float GlowDistances::seen_sr(const vec3& point, const vec3& way, float distance2) const {
    if (triangle_ == nullptr)
        return 1.0f / (distance2 + radius2_);
    const auto& [a, b, c] = triangle_->corners;
    return distance2 < near_radii2 * radius2_
               ? solid_angle_sr(a - point, b - point, c - point)
               : triangle_->area_m2 * std::abs(glm::dot(triangle_->normal, way)) / (distance2 * std::sqrt(distance2));
}

float GlowDistances::brightness(const MediaLine::Piece& piece, float at_m) const {
    const vec3 point = line_.origin() + at_m * line_.direction(), way = centre_ - point;
    const float distance2 = glm::dot(way, way);
    if (!(distance2 > 0.0f))
        return 0.0f;
    const float cosine = glm::dot(way, line_.direction()) / std::sqrt(distance2); // back along both: 1 is straight on
    float scattered = 0.0f;
    for (const auto& [sigma_s_per_m, asymmetry_g, draine_alpha] : line_.lobes_of(piece))
        scattered += sigma_s_per_m * (asymmetry_g == 0.0f && draine_alpha == 0.0f
                                          ? 0.25f * std::numbers::inv_pi_v<float>
                                          : draine_per_sr(cosine, asymmetry_g, draine_alpha));
    const Rgb depth = piece.depth_at(at_m) + light_side_depth(at_m);
    const float passing = depth.x == depth.y && depth.y == depth.z ? std::exp(-depth.x) : average(glm::exp(-depth));
    return seen_sr(point, way, distance2) * scattered * passing;
}

void GlowDistances::find_light_side(const Media& media, float near_m, float far_m) {
    const std::array at_m{near_m, std::clamp(foot_m_, near_m, far_m), far_m};
    for (std::size_t index = 0; index < at_m.size(); ++index) {
        const vec3 point = line_.origin() + at_m[index] * line_.direction(), way = centre_ - point;
        const float distance_m = glm::length(way);
        light_side_[index] = {at_m[index], Rgb(0.0f)};
        if (distance_m > 0.0f)
            light_side_[index].depth = media.homogeneous_depth(
                {.origin = point, .direction = way / distance_m, .near_m = 0.0f, .far_m = distance_m});
    }
    has_light_side_ = true;
}

Rgb GlowDistances::light_side_depth(float at_m) const {
    if (!has_light_side_)
        return Rgb(0.0f);
    const std::size_t first = at_m < light_side_[1].at_m ? 0 : 1;
    const auto& from = light_side_[first];
    const auto& to = light_side_[first + 1];
    return to.at_m > from.at_m ? glm::mix(from.depth, to.depth, (at_m - from.at_m) / (to.at_m - from.at_m))
                               : from.depth;
}

GlowDistances::Distance GlowDistances::at(float u) const {
    if (cells().empty())
        return {};
    float before = 0.0f, share = 0.0f;
    const Cell* chosen = nullptr;
    for (const Cell& cell : cells()) {
        if (chosen != nullptr && u < before + share)
            break;
        before += share;
        share = share_of(cell);
        chosen = &cell; // the last one takes what rounding leaves
    }
    const float part = std::clamp((u - before) / share, 0.0f, 0x1.fffffep-1f);
    const float along = std::tan(part * chosen->angle_rad);
    const float x =
        std::clamp((chosen->from_x + along) / (1.0f - chosen->from_x * along), chosen->from_x, chosen->to_x);
    const float at_m = std::clamp(foot_m_ + off_m_ * x, chosen->piece->near_m, chosen->piece->far_m);
    return {at_m, chosen->piece, share / (chosen->angle_rad * off_m_ * (1.0f + x * x))};
}

float GlowDistances::density_per_m(const MediaLine::Piece& piece, float at_m) const {
    const float x = (at_m - foot_m_) / off_m_;
    const Cell* found = nullptr;
    for (const Cell& cell : cells())
        if (cell.piece == &piece) {
            found = &cell;
            if (x <= cell.to_x)
                break;
        }
    return found == nullptr ? 0.0f : share_of(*found) / (found->angle_rad * off_m_ * (1.0f + x * x));
}
} // namespace tyndall::render
