// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/turning_disc.hpp"
#include "core/sampling.hpp"
#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

namespace tyndall::light_shafts {
static constexpr float quarter_turn_rad = 0.5f * std::numbers::pi_v<float>;
/// Beside a spot's cone, farther than this from its edge, only points within a few radii see light of the disc.
static constexpr float margin_rad = 0.17f;

std::uint32_t cells_per_quarter(float error_target, float weight, std::uint32_t strata) {
    constexpr float error_of_one = 0.05f; // in a can; between two boards half a radius away 0.1, in a soup 0.01
    constexpr float most_parts = 40000.0f;
    const float wanted = std::ceil(std::sqrt(error_of_one * weight / error_target));
    const float affordable = std::floor(std::sqrt(most_parts / (6.0f * static_cast<float>(strata))));
    return static_cast<std::uint32_t>(std::clamp(std::min(wanted, affordable), 2.0f, 16.0f));
}

/// Uniform over all rotations.
/// Based on: Shoemake, Uniform Random Rotations, Graphics Gems III, 1992.
static mat3 random_rotation(const vec3& u) {
    const float a = std::sqrt(1.0f - u.x), b = std::sqrt(u.x);
    const float s = 4.0f * quarter_turn_rad * u.y, t = 4.0f * quarter_turn_rad * u.z;
    return glm::mat3_cast(glm::quat(b * std::cos(t), a * std::sin(s), a * std::cos(s), b * std::sin(t)));
}

/// A rectangle in the angles from a face's axis: columns of `face` are its x, y and axis.
static DiscCell rectangle(const vec3& apex, const mat3& face, const vec2& from_rad, const vec2& to_rad) {
    DiscCell cell{.directions = {.apex = apex}, .facing = {}};
    const vec3& axis = face[2];
    for (int i = 0; i < 2; ++i) {
        cell.directions.inwards[static_cast<std::size_t>(2 * i)] =
            std::cos(from_rad[i]) * face[i] - std::sin(from_rad[i]) * axis;
        cell.directions.inwards[static_cast<std::size_t>(2 * i + 1)] =
            std::sin(to_rad[i]) * axis - std::cos(to_rad[i]) * face[i];
    }
    const auto direction = [&](const vec2& share) {
        const vec2 slope = glm::tan(glm::mix(from_rad, to_rad, share));
        return std::pair(glm::normalize(slope.x * face[0] + slope.y * face[1] + axis), slope);
    };
    cell.facing = direction(vec2(0.5f)).first;
    constexpr int steps = 8;
    float sum = 0.0f, weights = 0.0f;
    for (int y = 0; y < steps; ++y)
        for (int x = 0; x < steps; ++x) {
            const auto [way, slope] = direction((vec2(x, y) + 0.5f) / static_cast<float>(steps));
            // Solid angle per angles: d(tan) twice over the distance's cube.
            const vec2 stretch = 1.0f + slope * slope;
            const float weight = stretch.x * stretch.y * std::pow(1.0f + glm::dot(slope, slope), -1.5f);
            sum += weight * glm::dot(way, cell.facing);
            weights += weight;
        }
    cell.widening = std::sqrt(weights / sum);
    return cell;
}

static void append_grid(std::vector<DiscCell>& cells, const vec3& apex, const mat3& face, float half_rad,
                        std::uint32_t side) {
    const auto edge = [&](std::uint32_t i) {
        return half_rad * (2.0f * static_cast<float>(i) / static_cast<float>(side) - 1.0f);
    };
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x)
            cells.push_back(rectangle(apex, face, {edge(x), edge(y)}, {edge(x + 1), edge(y + 1)}));
}

/// What a pyramid around a face's axis leaves of all directions: four sides, and the half space behind.
static void append_rest(std::vector<DiscCell>& cells, const vec3& apex, const mat3& face, float half_rad,
                        float reach_m) {
    const vec3& axis = face[2];
    for (int side = 0; side < 4; ++side) {
        const vec3 out = (side & 1 ? -1.0f : 1.0f) * face[side >> 1], along = face[1 - (side >> 1)];
        const float middle_rad = 0.5f * (half_rad + quarter_turn_rad);
        cells.push_back({.directions = {.apex = apex,
                                        .inwards = {std::cos(half_rad) * out - std::sin(half_rad) * axis, out - along,
                                                    out + along, axis}},
                         .facing = std::sin(middle_rad) * out + std::cos(middle_rad) * axis,
                         .reach_m = reach_m});
    }
    cells.push_back({.directions = {.apex = apex, .inwards = {-axis}}, .facing = -axis, .reach_m = reach_m});
}

std::vector<DiscCell> make_disc_cells(const Light& light, std::uint32_t per_quarter, const vec3& turn) {
    std::vector<DiscCell> cells;
    const float half_rad = light.spot_half_angle_rad + margin_rad;
    // From 4.0 on an object's scale may shear the cone: then it is not round, and half_angle_rad not its angle.
    const mat3 product = glm::transpose(light.light_from_world_directions) * light.light_from_world_directions;
    float shear = 0.0f;
    for (int c = 0; c < 3 && light.spot_falloff == SpotFalloff::Blender4; ++c)
        shear = std::max(shear, glm::length(product[c] / product[0][0] - mat3(1.0f)[c]));
    if (light.kind == LightKind::Spot && half_rad < 0.5f * quarter_turn_rad && shear < 1e-3f) {
        const auto [x, y] = orthonormal_basis(light.spot_axis);
        const float angle = 4.0f * quarter_turn_rad * turn.x;
        const mat3 face(std::cos(angle) * x + std::sin(angle) * y, std::cos(angle) * y - std::sin(angle) * x,
                        light.spot_axis);
        const float width_rad = quarter_turn_rad / static_cast<float>(per_quarter);
        append_grid(cells, light.position, face, half_rad,
                    static_cast<std::uint32_t>(std::ceil(2.0f * half_rad / width_rad)));
        append_rest(cells, light.position, face, half_rad, 2.0f * light.radius_m / std::sin(margin_rad));
        return cells;
    }
    const mat3 axes = random_rotation(turn);
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {1.0f, -1.0f})
            append_grid(cells, light.position, mat3(axes[(axis + 1) % 3], axes[(axis + 2) % 3], sign * axes[axis]),
                        0.5f * quarter_turn_rad, per_quarter);
    return cells;
}

LightSample sample_disc(const Light& light, std::uint32_t light_index, const DiscCell& cell, vec2 u) {
    Light without_size = light;
    without_size.radius_m = 0.0f;
    LightSample sample = sample_light(without_size, light_index, vec3(0.5f));
    sample.spot = light.kind == LightKind::Spot ? &light : nullptr;
    sample.textured = light.texture ? &light : nullptr;
    const vec2 disc = light.radius_m * sample_concentric_disc(u);
    sample.falloff_offset = -cell.widening * from_frame(cell.facing, vec3(disc, 0.0f));
    sample.position -= sample.falloff_offset;
    sample.softening_m2 = glm::dot(disc, disc);
    sample.faces_receivers = true;
    sample.cell = &cell.directions;
    return sample;
}

static bool clip(ViewRay& ray, const DirectionCell& cell, float reach_m) {
    const vec3 start = ray.origin - cell.apex;
    for (const vec3& inwards : cell.inwards) {
        const float height = glm::dot(inwards, start), rise = glm::dot(inwards, ray.direction);
        if (rise > 0.0f)
            ray.near_m = std::max(ray.near_m, -height / rise);
        else if (rise < 0.0f)
            ray.far_m = std::min(ray.far_m, -height / rise);
        else if (height < 0.0f)
            return false;
    }
    if (std::isfinite(reach_m)) {
        const float middle = -glm::dot(start, ray.direction);
        const float half2 = reach_m * reach_m - glm::dot(start, start) + middle * middle;
        if (!(half2 > 0.0f))
            return false;
        ray.near_m = std::max(ray.near_m, middle - std::sqrt(half2));
        ray.far_m = std::min(ray.far_m, middle + std::sqrt(half2));
    }
    return ray.near_m < ray.far_m;
}

std::vector<RaySpan> clip_to_cell(std::span<const RaySpan> spans, const DirectionCell& cell, float reach_m) {
    std::vector<RaySpan> clipped;
    for (const RaySpan& span : spans) {
        ViewRay first = span.first, last = span.last;
        const bool is_first_inside = clip(first, cell, reach_m), is_last_inside = clip(last, cell, reach_m);
        if (!is_first_inside && !is_last_inside)
            continue;
        if (!is_first_inside)
            first.near_m = last.near_m, first.far_m = last.far_m;
        if (is_last_inside) {
            first.near_m = std::min(first.near_m, last.near_m);
            first.far_m = std::max(first.far_m, last.far_m);
        }
        // Between the two the cell may reach a little farther; rays that leave the rows ask the exact strip.
        const float slack_m = 0.02f * (first.far_m - first.near_m);
        RaySpan& kept = clipped.emplace_back(span);
        kept.first.near_m = kept.last.near_m = std::max(span.first.near_m, first.near_m - slack_m);
        kept.first.far_m = kept.last.far_m = std::min(span.first.far_m, first.far_m + slack_m);
    }
    return clipped;
}
} // namespace tyndall::light_shafts
