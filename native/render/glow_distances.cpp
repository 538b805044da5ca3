// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/glow_distances.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tyndall::render {
static constexpr float widest_cell_rad = std::numbers::pi_v<float> / 8.0f;
static constexpr float least_softness = 1e-4f; ///< Of the distance to a triangle: how near to it a line is at least.

GlowCells& GlowDistances::kept_cells() {
    thread_local GlowCells kept;
    return kept;
}

GlowDistances::GlowDistances(const MediaLine& line, const EmissiveTriangle& triangle, const Media* light_side)
    : line_(line), cells_(kept_cells()) {
    const auto& [a, b, c] = triangle.corners;
    const vec3 centre = (a + b + c) * (1.0f / 3.0f);
    glow_.from_origin = centre - line.origin();
    glow_.radius2 = std::max(
        {glm::dot(a - centre, a - centre), glm::dot(b - centre, b - centre), glm::dot(c - centre, c - centre)});
    glow_.triangle = &triangle;
    constexpr float unbounded = std::numeric_limits<float>::infinity();
    cut(triangle.area_m2, {-unbounded, unbounded}, light_side);
}

GlowDistances::GlowDistances(const MediaLine& line, const vec3& lamp, float radius_m, const Reach& reach,
                             const Media* light_side)
    : line_(line), cells_(kept_cells()) {
    glow_.from_origin = lamp - line.origin();
    glow_.radius2 = radius_m * radius_m;
    cut(glow_.radius2, reach, light_side);
}

void GlowDistances::cut(float area_m2, const Reach& reach, const Media* light_side) {
    glow_.foot_m = glm::dot(glow_.from_origin, line_.direction());
    const vec3 off = glow_.from_origin - glow_.foot_m * line_.direction();
    const float softness = least_softness * glm::length(glow_.from_origin);
    glow_.off_m = std::sqrt(glm::dot(off, off) + 0.5f * area_m2 + softness * softness);
    cells_.clear();
    const float near_m = std::max(line_.pieces().front().near_m, reach.near_m),
                far_m = std::min(line_.pieces().back().far_m, reach.far_m);
    if (!(near_m < far_m))
        return;
    if (light_side != nullptr)
        find_light_side(*light_side, near_m, far_m);
    append_cells((near_m - glow_.foot_m) / glow_.off_m, (far_m - glow_.foot_m) / glow_.off_m);
    cells_.weigh(line_, glow_);
    float weight_sum = 0.0f, angle_sum_rad = 0.0f;
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
        weight_sum += cells_.weight(cell);
        angle_sum_rad += cells_.angle_rad(cell);
    }
    share_per_weight_ = weight_sum > 0.0f ? (1.0f - blind_share) / weight_sum : 0.0f;
    if (angle_sum_rad > 0.0f)
        share_per_rad_ = (weight_sum > 0.0f ? blind_share : 1.0f) / angle_sum_rad;
}

void GlowDistances::append_cells(float first_x, float last_x) {
    const float foot_m = glow_.foot_m, off_m = glow_.off_m;
    // The tangent of a sum of angles, step by step: one arctangent of all is all there is.
    const float angle_rad = std::atan2(last_x - first_x, 1.0f + first_x * last_x);
    int angles_left = std::max(1, static_cast<int>(std::ceil(angle_rad / widest_cell_rad)));
    const float step = std::tan(angle_rad / static_cast<float>(angles_left));
    float angle_x = first_x;
    const auto next_angle = [&] {
        if (--angles_left <= 0)
            return last_x;
        const float next = (angle_x + step) / (1.0f - angle_x * step);
        return next > angle_x ? std::min(next, last_x) : last_x;
    };
    angle_x = next_angle();
    auto loss = line_.equal_losses_m().begin();
    const auto loss_end = line_.equal_losses_m().end();
    for (const MediaLine::Piece& piece : line_.pieces()) {
        float x = std::max((piece.near_m - foot_m) / off_m, first_x);
        const float end_x = std::min((piece.far_m - foot_m) / off_m, last_x);
        while (x < end_x) {
            while (angle_x <= x && angle_x < last_x)
                angle_x = next_angle();
            while (loss != loss_end && *loss <= foot_m + off_m * x)
                ++loss;
            float to_x = end_x;
            if (angle_x > x)
                to_x = std::min(to_x, angle_x);
            if (loss != loss_end)
                if (const float loss_x = (*loss - foot_m) / off_m; loss_x > x)
                    to_x = std::min(to_x, loss_x);
            cells_.append(piece, x, to_x);
            x = to_x;
        }
    }
}

void GlowDistances::find_light_side(const Media& media, float near_m, float far_m) {
    const std::array at_m{near_m, std::clamp(glow_.foot_m, near_m, far_m), far_m};
    std::array<Rgb, 3> depths{};
    for (std::size_t index = 0; index < at_m.size(); ++index) {
        const vec3 way = glow_.from_origin - at_m[index] * line_.direction();
        const float distance_m = glm::length(way);
        depths[index] = distance_m > 0.0f
                            ? media.homogeneous_depth({.origin = line_.origin() + at_m[index] * line_.direction(),
                                                       .direction = way / distance_m,
                                                       .near_m = 0.0f,
                                                       .far_m = distance_m})
                            : Rgb(0.0f);
    }
    for (std::size_t index = 0; index < 2; ++index) {
        const float length_m = at_m[index + 1] - at_m[index];
        glow_.light_side[index] = {at_m[index], depths[index],
                                   length_m > 0.0f ? (depths[index + 1] - depths[index]) / length_m : Rgb(0.0f)};
    }
    glow_.is_dimmed = true;
}

GlowDistances::Distance GlowDistances::at(float u) const {
    float before = 0.0f, share = 0.0f;
    std::size_t chosen = cells_.size();
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
        const float of_cell = share_of(cell);
        if (!(of_cell > 0.0f))
            continue;
        if (chosen != cells_.size() && u < before + share)
            break;
        before += share;
        share = of_cell;
        chosen = cell; // the last one takes what rounding leaves
    }
    if (chosen == cells_.size())
        return {};
    const float part = std::clamp((u - before) / share, 0.0f, 0x1.fffffep-1f), angle_rad = cells_.angle_rad(chosen);
    const float along = std::tan(part * angle_rad), from_x = cells_.from_x(chosen);
    const float x = std::clamp((from_x + along) / (1.0f - from_x * along), from_x, cells_.to_x(chosen));
    const MediaLine::Piece& piece = cells_.piece(chosen);
    const float at_m = std::clamp(glow_.foot_m + glow_.off_m * x, piece.near_m, piece.far_m);
    return {at_m, &piece, share / (angle_rad * glow_.off_m * (1.0f + x * x))};
}

float GlowDistances::density_per_m(const MediaLine::Piece& piece, float at_m) const {
    const float x = (at_m - glow_.foot_m) / glow_.off_m;
    std::size_t found = cells_.size();
    for (std::size_t cell = 0; cell < cells_.size(); ++cell)
        if (&cells_.piece(cell) == &piece && cells_.angle_rad(cell) > 0.0f) {
            found = cell;
            if (x <= cells_.to_x(cell))
                break;
        }
    return found == cells_.size() ? 0.0f : share_of(found) / (cells_.angle_rad(found) * glow_.off_m * (1.0f + x * x));
}
} // namespace tyndall::render
