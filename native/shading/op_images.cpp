// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_images.hpp"
#include "shading/pixel_steps.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
namespace {
constexpr float inverse_pi = std::numbers::inv_pi_v<float>;
constexpr vec4 missing_image(1, 0, 1, 1);

vec2 on_sphere(const vec3& v) {
    const float length = glm::length(v);
    if (!(length > 0.0f))
        return vec2(0.0f);
    const float u = v.x == 0.0f && v.y == 0.0f ? 0.0f : 0.5f - 0.5f * inverse_pi * std::atan2(v.x, v.y);
    return {u, 1.0f - inverse_pi * std::acos(std::clamp(v.z / length, -1.0f, 1.0f))};
}

vec2 on_tube(const vec3& v) {
    if (v.x == 0.0f && v.y == 0.0f)
        return vec2(0.0f);
    return {0.5f * (1.0f - inverse_pi * std::atan2(v.x, v.y)), 0.5f * (v.z + 1.0f)};
}

/// What the three pairs of sides of a box have of a normal: a normal's shares are a place in a triangle, of which the
/// corners are one side's, the edges two sides', and the middle all sides'.
vec3 box_weights(const vec3& normal, float blend) {
    const vec3 n = glm::abs(normal) / (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
    const float limit = 0.5f * (1.0f + blend);
    for (int axis = 0; axis < 3; ++axis) {
        const float one = n[(axis + 1) % 3], other = n[(axis + 2) % 3];
        if (n[axis] > limit * (n[axis] + one) && n[axis] > limit * (n[axis] + other)) {
            vec3 weights(0.0f);
            weights[axis] = 1.0f;
            return weights;
        }
    }
    if (!(blend > 0.0f))
        return {1, 0, 0};
    constexpr int without[3] = {2, 0,
                                1}; // which side has nothing; the orders of tests and of shares are those of Cycles
    for (const int none : without) {
        const int first = none == 0 ? 1 : 0, second = 3 - none - first;
        if (n[none] < (1.0f - limit) * (n[first] + n[second])) {
            const float share = n[first] / (n[first] + n[second]);
            vec3 weights(0.0f);
            weights[first] = std::clamp((share - 0.5f * (1.0f - blend)) / blend, 0.0f, 1.0f);
            weights[second] = 1.0f - weights[first];
            return weights;
        }
    }
    return ((2.0f - limit) * n + (limit - 1.0f)) / (2.0f * limit - 1.0f);
}

vec4 in_box(const SurfaceOp& op, const Texture& texture, const ProgramPoint& point, const vec3& at) {
    const vec3 normal = normal_in_object(point, point.surface.shading_normal);
    const vec3 weights = box_weights(normal, op.value.x);
    vec4 sum(0.0f);
    if (weights.x > 0.0f)
        sum += weights.x * texture.lookup({normal.x < 0.0f ? 1.0f - at.y : at.y, at.z});
    if (weights.y > 0.0f)
        sum += weights.y * texture.lookup({normal.y > 0.0f ? 1.0f - at.x : at.x, at.z});
    if (weights.z > 0.0f)
        sum += weights.z * texture.lookup({normal.z > 0.0f ? 1.0f - at.y : at.y, at.x});
    return sum;
}

vec4 in_tiles(const SurfaceOp& op, const Material& material, const vec2& at) {
    constexpr float most = 1e6f;
    if (!(std::abs(at.x) < most && std::abs(at.y) < most))
        return missing_image;
    const vec2 tile = glm::trunc(at); // towards 0: a little below 0 still is the first
    for (const vec4& known : material.tables[op.table].values)
        if (known.x == tile.x && known.y == tile.y)
            return material.textures[static_cast<std::size_t>(known.z)]->lookup(at - tile);
    return missing_image;
}

vec4 in_environment(const SurfaceOp& op, const Texture& texture, const vec3& vector) {
    const float length = glm::length(vector);
    if (!(length > 0.0f))
        return texture.lookup(vec2(0.0f));
    const vec3 v = vector / length;
    if (static_cast<EnvironmentProjection>(op.option) == EnvironmentProjection::Equirectangular)
        return texture.lookup({0.5f - 0.5f * inverse_pi * std::atan2(v.y, v.x),
                               1.0f - inverse_pi * std::acos(std::clamp(v.z, -1.0f, 1.0f))});
    const float divisor = 2.0f * std::sqrt(std::max(-0.5f * (v.y - 1.0f), 0.0f));
    const vec2 in_ball = divisor > 0.0f ? vec2(v.x, v.z) / divisor : vec2(v.x, v.z);
    return texture.lookup(0.5f * (in_ball + 1.0f));
}
} // namespace

vec4 image_at(const SurfaceOp& op, const Material& material, const ProgramPoint& point, const vec3& vector) {
    const Texture& texture = *material.textures[op.texture];
    if (op.code == SurfaceOp::Code::EnvironmentAt)
        return in_environment(op, texture, vector);
    vec2 at(vector);
    switch (static_cast<ImageProjection>(op.option)) {
    case ImageProjection::Box:
        return in_box(op, texture, point, vector);
    case ImageProjection::Sphere:
        at = on_sphere(2.0f * (vector - 0.5f));
        break;
    case ImageProjection::Tube:
        at = on_tube(2.0f * (vector - 0.5f));
        break;
    default:
        break;
    }
    return op.selector == image_has_tiles ? in_tiles(op, material, at) : texture.lookup(at);
}
} // namespace tyndall
