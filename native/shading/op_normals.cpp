// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_normals.hpp"
#include "shading/pixel_steps.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
namespace {
/// Share that a dielectric of any relative index reflects; below 1 all of it, beyond the angle of total reflection.
float reflected_share(float cosine, float index) {
    const float c = std::abs(cosine), squared = index * index - 1.0f + c * c;
    if (!(squared > 0.0f))
        return 1.0f;
    const float g = std::sqrt(squared);
    const float across = (g - c) / (g + c), along = (c * (g + c) - 1.0f) / (c * (g - c) + 1.0f);
    return 0.5f * across * across * (1.0f + along * along);
}

vec3 tangent_normal(const ProgramPoint& point, vec3 colour, float strength, const vec3& tangent, float sign,
                    bool mixes) {
    vec3 normal = point.object_normal;
    if (normal == vec3(0.0f))
        normal = normal_in_object(point, point.surface.geometric_normal);
    if (!mixes) {
        colour.x *= strength;
        colour.y *= strength;
        colour.z = glm::mix(1.0f, colour.z, std::clamp(strength, 0.0f, 1.0f));
    }
    const vec3 bitangent = sign * glm::cross(normal, tangent);
    return normal_in_scene(point, unit_or(colour.x * tangent + colour.y * bitangent + colour.z * normal, vec3(0.0f)));
}
} // namespace

vec3 valid_specular(const ProgramPoint& point, const vec3& normal) {
    const vec3 geometric = true_normal(point), &incoming = point.incoming;
    if (normal == geometric)
        return normal;
    const vec3 mirrored = 2.0f * glm::dot(normal, incoming) * normal - incoming;
    const float height = glm::dot(incoming, geometric), least = std::min(0.9f * height, 0.01f);
    if (glm::dot(geometric, mirrored) >= least)
        return normal;
    // In the plane of both normals: the square of the new one's share of the geometric normal solves a quadratic equation.
    const vec3 across = unit_or(normal - glm::dot(normal, geometric) * geometric, normal);
    const float side = glm::dot(incoming, across);
    const float a = side * side + height * height, b = 2.0f * (a + height * least);
    const float c = (least + height) * (least + height);
    const float root = std::sqrt(std::max(b * b - 4.0f * a * c, 0.0f));
    const float up_squared = 0.25f * (side < 0.0f ? b + root : b - root) / a;
    return std::sqrt(std::max(1.0f - up_squared, 0.0f)) * across + std::sqrt(std::max(up_squared, 0.0f)) * geometric;
}

float fresnel_value(const ProgramPoint& point, const Operands& in) {
    const float index = std::max(in.a.x, 1e-5f);
    return reflected_share(glm::dot(point.incoming, in.b), point.surface.is_backface ? 1.0f / index : index);
}

float layer_weight(const SurfaceOp& op, const ProgramPoint& point, const Operands& in) {
    const float cosine = glm::dot(point.incoming, in.b);
    float blend = in.a.x;
    if (op.option == 0) {
        const float index = std::max(1.0f - blend, 1e-5f);
        return reflected_share(cosine, point.surface.is_backface ? index : 1.0f / index);
    }
    if (blend == 0.5f)
        return 1.0f - std::abs(cosine);
    blend = std::clamp(blend, 0.0f, 1.0f - 1e-5f);
    return 1.0f - std::pow(std::abs(cosine), blend < 0.5f ? 2.0f * blend : 0.5f / (1.0f - blend));
}

vec3 mapped_normal(const SurfaceOp& op, const ProgramPoint& point, const Operands& in) {
    const vec3& own = point.surface.shading_normal;
    const auto space = static_cast<NormalSpace>(op.option);
    if (space == NormalSpace::Unit)
        return unit_or(in.a, own);
    if (space == NormalSpace::ValidSpecular)
        return valid_specular(point, unit_or(in.a, own));
    vec3 normal = 2.0f * (in.a - 0.5f);
    bool mixes = true;
    if (space == NormalSpace::Tangent) {
        if (in.c == vec3(0.0f) || in.d.x == 0.0f) // the mesh has no such UV map
            return own;
        mixes = op.selector == strength_mixes_normals;
        normal = tangent_normal(point, normal, in.b.x, in.c, in.d.x, mixes);
    } else {
        if (space == NormalSpace::BlenderObject || space == NormalSpace::BlenderWorld)
            normal = {normal.x, -normal.y, -normal.z};
        const bool is_in_object = space == NormalSpace::Object || space == NormalSpace::BlenderObject;
        normal = is_in_object ? normal_in_scene(point, normal) : unit_or(normal, vec3(0.0f));
    }
    if (point.surface.is_backface)
        normal = -normal;
    if (mixes && in.b.x != 1.0f)
        normal = unit_or(own + (normal - own) * std::max(in.b.x, 0.0f), vec3(0.0f));
    return unit_or(normal, own);
}

vec3 bumped_normal(const SurfaceOp& op, const ProgramPoint& point, const Operands& in) {
    const vec3& normal = in.f;
    if (point.footprint_m <= 0.0f)
        return normal;
    const auto [first, second] = pixel_steps(point);
    const vec3 along_first = glm::cross(second, normal), along_second = glm::cross(normal, first);
    const float area = glm::dot(first, along_first);
    const vec3 slope = (in.b.x - in.a.x) * along_first + (in.c.x - in.a.x) * along_second;
    const float scale = (op.selector & bump_is_inverted) != 0 ? -in.e.x : in.e.x;
    const float side = area < 0.0f ? -1.0f : 1.0f, strength = std::max(in.d.x, 0.0f);
    vec3 bent = unit_or(op.value.x * std::abs(area) * normal - scale * side * slope, vec3(0.0f));
    bent = bent == vec3(0.0f) ? normal : unit_or(strength * bent + (1.0f - strength) * normal, normal);
    return (op.selector & bump_is_valid_specular) != 0 ? valid_specular(point, bent) : bent;
}
} // namespace tyndall
